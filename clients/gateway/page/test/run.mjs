// SPDX-License-Identifier: Apache-2.0
// Runs the tests of those parts of the page that need no browser, with the test runner of node.
import { build } from "esbuild";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const sources = readdirSync(here).filter((name) => name.endsWith(".test.ts"));
// In node_modules, where the bundled tests find the packages of the page.
const work = mkdtempSync(join(here, "../node_modules/.test-"));
try {
  await build({
    entryPoints: sources.map((name) => join(here, name)),
    bundle: true,
    packages: "external",
    platform: "node",
    format: "esm",
    outdir: work,
    outExtension: { ".js": ".mjs" },
    logLevel: "warning",
  });
  const programs = sources.map((name) => join(work, name.replace(/\.ts$/, ".mjs")));
  process.exitCode = spawnSync(process.execPath, ["--test", ...programs], { stdio: "inherit" }).status ?? 1;
} finally {
  rmSync(work, { recursive: true });
}
