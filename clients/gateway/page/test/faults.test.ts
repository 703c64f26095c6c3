// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { scaleOf, strip, windowsOf, type KeptWindow } from "../src/data/faults";

function kept(window: number, axes: number[]): KeptWindow {
  const causes = axes.map((axis) => ({ kind: "fault", axis, code: 0x8611, tick: 10 }));
  return { window, first_tick: 0, last_tick: 20, is_open: false, causes };
}

test("the windows of an axis are those with a cause of it, newest first", () => {
  const windows = [kept(1, [1, 2]), kept(2, [3]), kept(3, [2])];
  assert.deepEqual(windowsOf(windows, 2).map(({ window }) => window), [3, 1]);
});

test("a strip has each value where there are pixels enough", () => {
  // 0 is at the bottom, 10 at the top, 5 in the middle
  const values = [0, 10, 5];
  assert.equal(strip(values, scaleOf(values), 100, 40), "0.0,40.0 50.0,0.0 100.0,20.0");
});

test("a strip keeps the highest and the lowest value of a pixel", () => {
  const values = new Array<number>(1000).fill(0);
  values[501] = 7;
  values[502] = -3;
  assert.deepEqual(scaleOf(values), { low: -3, high: 7 });
  const points = strip(values, scaleOf(values), 10, 100);
  assert.ok(points.includes(",0.0"));
  assert.ok(points.includes(",100.0"));
});

test("a strip of one value is a line in the middle", () => {
  assert.equal(strip([4, 4, 4], scaleOf([4, 4, 4]), 10, 20), "0.0,10.0 5.0,10.0 10.0,10.0");
});

test("two lines of a strip share a scale", () => {
  // on a scale from 0 to 20, 5 is a quarter above the bottom
  const scale = scaleOf([0, 20], [5, 5]);
  assert.equal(strip([5, 5], scale, 10, 40), "0.0,30.0 10.0,30.0");
});
