// SPDX-License-Identifier: Apache-2.0
// The processor time and memory of the gateway and its page with 1,024 axes in real time: without
// an open page, with the overview, and with the view of an axis, which has one trace.
import { readFile } from "node:fs/promises";
import { PATIENCE_MS, startBrowser, startGateway, startService, stopAll } from "./bench.mjs";

const AXES = 1024;
const SECONDS = 60;
const TICKS_A_SECOND = 100; // of /proc, sysconf(_SC_CLK_TCK)

/** @return processor time [s] and resident memory [MB] of a program. */
async function usage(pid) {
  const fields = (await readFile(`/proc/${pid}/stat`, "utf8")).split(") ").at(-1).split(" ");
  const status = await readFile(`/proc/${pid}/status`, "utf8");
  return {
    seconds: (Number(fields[11]) + Number(fields[12])) / TICKS_A_SECOND,
    memory: Number(/VmRSS:\s+(\d+)/.exec(status)[1]) / 1024,
  };
}

try {
  startService("--axes", String(AXES));
  const gateway = await startGateway(0);
  const pid = gateway.child.pid;
  const rest = (seconds) => new Promise((resolve) => setTimeout(resolve, seconds * 1000));
  await rest(5); // the gateway finds the bench and reads it

  /** @param session of the page, to read its own metrics; none = no page is open */
  const report = async (what, session) => {
    const metrics = async () => {
      if (session === undefined) return {};
      await session.send("HeapProfiler.collectGarbage");
      const { metrics } = await session.send("Performance.getMetrics");
      return Object.fromEntries(metrics.map(({ name, value }) => [name, value]));
    };
    const before = { gateway: await usage(pid), page: await metrics() };
    await rest(SECONDS);
    const after = { gateway: await usage(pid), page: await metrics() };
    const share = (seconds) => (seconds / SECONDS).toFixed(3);
    const heap = (page) => (page.JSHeapUsedSize / 1e6).toFixed(1);
    const ofPage =
      session === undefined
        ? ""
        : `; page ${share(after.page.TaskDuration - before.page.TaskDuration)} of a core, ` +
          `heap ${heap(before.page)} to ${heap(after.page)} MB`;
    console.log(
      `${AXES} axes, ${what}: gateway ${share(after.gateway.seconds - before.gateway.seconds)} of a core, ` +
        `${after.gateway.memory.toFixed(1)} MB${ofPage}`,
    );
  };

  await report("nobody looks");
  const browser = await startBrowser();
  const page = await (await browser.newContext({ viewport: { width: 1280, height: 800 } })).newPage();
  const session = await page.context().newCDPSession(page);
  await session.send("Performance.enable");
  await page.goto(gateway.address);
  await page.locator('[data-address="1.20"] .lamp.switch_on_disabled').waitFor({ timeout: PATIENCE_MS });
  await rest(5);
  await report("overview", session);
  await page.click('[data-address="1.20"]');
  await page.locator(".plot canvas").first().waitFor({ timeout: PATIENCE_MS });
  await rest(5);
  await report("an axis with its trace", session);
  await report("the same, later", session);
  await browser.close();
} finally {
  await stopAll();
}
