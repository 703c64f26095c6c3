// SPDX-License-Identifier: Apache-2.0
import { defineConfig } from "vite";

// The gateway serves index.html and /assets only.
export default defineConfig({
  base: "./",
  build: {
    outDir: "dist",
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
  },
});
