// SPDX-License-Identifier: Apache-2.0
import { defineConfig } from "vite";
import { foxgloveLayout } from "./foxglove_layout";

// The gateway serves the files in dist; names in assets contain a hash of their content.
export default defineConfig({
  base: "./",
  build: {
    outDir: "dist",
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
  },
  plugins: [
    {
      name: "foxglove-layout",
      generateBundle() {
        const source = JSON.stringify(foxgloveLayout(), undefined, 2) + "\n";
        this.emitFile({ type: "asset", fileName: "foxglove-layout.json", source });
      },
    },
  ],
});
