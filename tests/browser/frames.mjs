// SPDX-License-Identifier: Apache-2.0
// The frames per second that the page draws with 1,024 axes: in the overview, still and scrolling,
// and in the view Control with all of them selected.
import { PATIENCE_MS, startBrowser, startGateway, startService, stopAll } from "./bench.mjs";

const AXES = 1024;
const SECONDS = 10;

try {
  startService("--axes", String(AXES));
  const gateway = await startGateway(0);
  const browser = await startBrowser();
  const page = await (await browser.newContext({ viewport: { width: 1280, height: 800 } })).newPage();
  await page.goto(gateway.address);
  await page.locator('[data-address="1.20"] .lamp.switch_on_disabled').waitFor({ timeout: PATIENCE_MS });
  const measure = (scroll) =>
    page.evaluate(
      ([seconds, step]) =>
        new Promise((resolve) => {
          const scroller = document.querySelector(".scroller, .chosen");
          const began = performance.now();
          let last = began;
          const frames = [];
          const frame = (now) => {
            if (now > last) frames.push(now - last);
            last = now;
            scroller.scrollTop += step;
            if (scroller.scrollTop + scroller.clientHeight >= scroller.scrollHeight - 1) scroller.scrollTop = 0;
            if (now - began < seconds * 1000) requestAnimationFrame(frame);
            else {
              frames.sort((a, b) => a - b);
              const at = (share) => frames[Math.min(frames.length - 1, Math.floor(frames.length * share))];
              resolve({ rate: (frames.length / (now - began)) * 1000, median: at(0.5), p99: at(0.99) });
            }
          };
          requestAnimationFrame(frame);
        }),
      [SECONDS, scroll],
    );
  const report = async (view) => {
    for (const [name, step] of [["standing", 0], ["scrolling 20 pixels a frame", 20]]) {
      const { rate, median, p99 } = await measure(step);
      console.log(
        `${AXES} axes, ${view} ${name}: ${rate.toFixed(1)} frames/s, median ${median.toFixed(1)} ms, 99 % below ${p99.toFixed(1)} ms`,
      );
    }
  };
  await report("overview");
  await page.check(".row.head input");
  await page.click("nav a >> nth=3");
  await page.locator(".chosen li").nth(AXES - 1).waitFor({ state: "attached", timeout: PATIENCE_MS });
  await report("control");
  await browser.close();
} finally {
  await stopAll();
}
