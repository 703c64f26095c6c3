// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { strip, windowsOf, type KeptWindow } from "../src/data/faults";

function kept(window: number, axes: number[]): KeptWindow {
  const causes = axes.map((axis) => ({ kind: "fault", axis, code: 0x8611, tick: 10 }));
  return { window, first_tick: 0, last_tick: 20, is_open: false, causes };
}

test("the windows of an axis are those with a cause of it, newest first", () => {
  const windows = [kept(1, [1, 2]), kept(2, [3]), kept(3, [2])];
  assert.deepEqual(windowsOf(windows, 2).map(({ window }) => window), [3, 1]);
});

test("a strip has each value where there are pixels enough", () => {
  // 0 stands at the bottom, 10 at the top, 5 in the middle
  assert.deepEqual(strip([0, 10, 5], 100, 40), { points: "0.0,40.0 50.0,0.0 100.0,20.0", low: 0, high: 10 });
});

test("a strip keeps the highest and the lowest value of a pixel", () => {
  const values = new Array<number>(1000).fill(0);
  values[501] = 7;
  values[502] = -3;
  const { points, low, high } = strip(values, 10, 100);
  assert.deepEqual([low, high], [-3, 7]);
  assert.ok(points.includes(",0.0"));
  assert.ok(points.includes(",100.0"));
});

test("a strip of one value is a line in the middle", () => {
  assert.equal(strip([4, 4, 4], 10, 20).points, "0.0,10.0 5.0,10.0 10.0,10.0");
});
