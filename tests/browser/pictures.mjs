// SPDX-License-Identifier: Apache-2.0
// Creates docs/images/page_*.png: each view in both themes and both widths, with a bench in
// operation.
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { PATIENCE_MS, startBrowser, startGateway, startService, stopAll } from "./bench.mjs";

const IMAGES = join(process.env.VDRIVE_ROOT, "docs/images");
const AXES = ["left", "right", "x", "y", "z", "gantry_1", "gantry_2", "spindle", "turret", "feeder", "gripper", "wrist"];
const SIZES = [
  { name: "wide", width: 1280, height: 860 },
  { name: "narrow", width: 390, height: 844 },
];
const COLOURS = 96; // per picture: more make no visible difference

const work = mkdtempSync(join(tmpdir(), "vdrive-pictures-"));

async function choose(page, addresses) {
  await page.goto(page.url().replace(/#.*/, "#/"));
  for (const address of addresses) {
    const box = page.locator(`[data-address="${address}"] input`);
    await box.waitFor({ timeout: PATIENCE_MS });
    await box.check();
  }
}

/** Enables most axes, moves some, and disturbs one. */
async function prepare(page) {
  await page.locator('[data-test="take"]').click();
  await choose(page, ["1.1", "1.2", "1.3", "1.4", "1.6", "1.7", "1.8"]);
  await page.goto(page.url().replace(/#.*/, "#/control"));
  await page.locator('[data-test="enable"]').click();
  await page.locator("footer .good").waitFor({ timeout: PATIENCE_MS });
  await page.goto(page.url().replace(/#.*/, "#/axis/1.7"));
  await page.locator('[data-test="over_current"]').check({ force: true });
  await page.locator('[data-figure="state"] .fault').waitFor({ timeout: PATIENCE_MS });
  for (const axis of ["1.6", "1.8"]) {
    await page.goto(page.url().replace(/#.*/, `#/axis/${axis}`));
    await page.locator('[data-test="jog-plus"]').waitFor();
    await page.fill("#move-target", axis === "1.6" ? "9000000" : "-9000000");
    await page.locator('[data-test="move"]').click();
    await page.waitForTimeout(300);
  }
}

async function show(page, hash) {
  await page.goto(page.url().replace(/#.*/, hash));
  if (hash === "#/axis/1.3") {
    await page.waitForTimeout(2_500);
    for (const target of ["12000", "4000"]) {
      await page.fill("#move-target", target);
      await page.locator('[data-test="move"]').click();
      await page.waitForTimeout(2_200);
    }
  } else {
    await page.waitForTimeout(5_000);
  }
}

try {
  const configuration = join(work, "bench.yaml");
  const axes = AXES.map((name, i) => `  - {number: ${i + 1}, name: ${name}}`).join("\n");
  writeFileSync(configuration, `bench:\n  number: 1\n  name: cell\naxes:\n${axes}\n`);
  startService("--config", configuration);
  const gateway = await startGateway(0, "--control");
  const browser = await startBrowser();
  const page = await (await browser.newContext({ viewport: SIZES[0], locale: "en-US" })).newPage();
  await page.goto(`${gateway.address}#/`);
  await prepare(page);
  await choose(page, []);
  for (const [view, hash] of [["overview", "#/"], ["axis", "#/axis/1.3"], ["control", "#/control"]]) {
    await show(page, hash);
    for (const size of SIZES) {
      await page.setViewportSize(size);
      for (const theme of ["light", "dark"]) {
        await page.selectOption(".settings select >> nth=2", theme);
        await page.locator("main").evaluate((main) => main.scrollTo(0, 0));
        await page.mouse.move(0, 0);
        await page.waitForTimeout(1_000); // the metrics of some frames
        const file = join(work, `page_${view}_${theme}_${size.name}.png`);
        await page.screenshot({ path: file });
        const small = join(IMAGES, `page_${view}_${theme}_${size.name}.png`);
        const made = spawnSync("pngquant", ["--force", "--output", small, String(COLOURS), file], { stdio: "inherit" });
        if (made.status !== 0) throw new Error("pngquant failed");
      }
    }
    await page.setViewportSize(SIZES[0]);
  }
  await browser.close();
} finally {
  await stopAll();
  rmSync(work, { recursive: true });
}
