// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { BLOCK, History, labelDecimals, niceRange } from "../src/data/history";

/** A fixed pseudo-random sequence (linear congruential generator). */
function numbers(seed: number): () => number {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return (state >>> 8) % 2001 - 1000;
  };
}

function filled(samples: number, capacity: number, spikes: Map<number, number> = new Map()): History {
  const history = new History([Int32Array], capacity);
  const next = numbers(1);
  for (let n = 0; n < samples; ++n) history.append(n * 0.001, [spikes.get(n) ?? next()]);
  return history;
}

test("few samples are drawn unchanged", () => {
  const history = filled(100, 1000);
  const points = history.points(0.0105, 0.0195, 50, [0]);
  // Samples 11 to 19 are inside; one at each end lets the line run to the edge.
  assert.deepEqual(points.y[0], Array.from({ length: 11 }, (_, i) => history.value(0, 10 + i)));
});

for (const [what, samples] of [["columns of samples", 20_000], ["columns of blocks", 200_000]] as const) {
  test(`a spike of one sample is visible in ${what}`, () => {
    for (const place of [BLOCK * 7, BLOCK * 8 - 1, 5_003, samples - 1]) {
      const history = filled(samples, samples + BLOCK, new Map([[place, 50_000], [place - 30, -50_000]]));
      const { y } = history.points(0, samples * 0.001, 200, [0]);
      assert.ok(y[0].includes(50_000), `positive spike at ${place}`);
      assert.ok(y[0].includes(-50_000), `negative spike at ${place - 30}`);
      assert.ok(y[0].length <= 2 * 202, "two points a column, and one column at each end");
    }
  });
}

test("each column has the extremes of its samples, as a plain search finds them", () => {
  const history = filled(10_000, 20_000);
  const columns = 100;
  const from = 2;
  const to = 8;
  const width = (to - from) / columns;
  const { x, y } = history.points(from, to, columns, [0]);
  const expected = new Map<number, number[]>();
  for (let n = 0; n < 10_000; ++n) {
    const time = history.time(n);
    if (time < from - 0.0015 || time > to + 0.0005) continue;
    const column = Math.floor(time / width);
    expected.set(column, [...(expected.get(column) ?? []), history.value(0, n)]);
  }
  for (let i = 2; i + 3 < x.length; i += 2) {
    const column = Math.floor(x[i] / width);
    const values = expected.get(column) ?? [];
    const seen = [y[0][i] as number, y[0][i + 1] as number].sort((a, b) => a - b);
    assert.deepEqual(seen, [Math.min(...values), Math.max(...values)], `column ${column}`);
  }
});

test("the extremes of a column keep their order", () => {
  for (const slope of [1, -1]) {
    const history = new History([Int32Array], 10_000);
    for (let n = 0; n < 5_000; ++n) history.append(n * 0.001, [slope * n]);
    const { y } = history.points(0, 5, 100, [0]);
    for (let i = 1; i < y[0].length; ++i) {
      assert.ok(slope * ((y[0][i] as number) - (y[0][i - 1] as number)) > 0, `point ${i} of slope ${slope}`);
    }
  }
});

test("times of the points ascend", () => {
  const history = filled(50_000, 60_000);
  for (const window of [1, 10, 50]) {
    const { x } = history.points(50 - window, 50, 300, [0]);
    for (let i = 1; i < x.length; ++i) assert.ok(x[i] >= x[i - 1], `${x[i - 1]} then ${x[i]}`);
  }
});

test("the oldest samples are removed in whole blocks", () => {
  const history = filled(BLOCK * 10 + 5, BLOCK * 4);
 
  // 645 samples in a capacity of 256: the first 389 do not fit, and whole blocks are dropped, up to 448.
  assert.equal(history.first, 448);
  assert.equal(history.end, 645);
  const { x } = history.points(0, 1, 1000, [0]);
  assert.equal(x[0], history.time(history.first));
});

test("lost samples are a gap, not a line", () => {
  const history = new History([Int32Array], 1000);
  history.append(0, [1]);
  history.append(0.001, [1]);
  history.markGap();
  history.append(0.1, [5]);
  assert.deepEqual(history.points(0, 0.1, 500, [0]).y[0], [1, 1, null, 5]);
});

test("lost samples are a gap in columns, too", () => {
  for (const samples of [10_000, 100_000]) {
    const history = new History([Int32Array], 2 * samples + BLOCK);
    for (let n = 0; n < 2 * samples; ++n) {
      if (n === samples) history.markGap();
      history.append((n < samples ? n : n + samples) * 0.001, [1]);
    }
    const { x, y } = history.points(0, 3 * samples * 0.001, 200, [0]);
    const at = y[0].indexOf(null);
    // The gap begins after the first third; a column has 1.5 % of the length of a third.
    assert.ok(at > 0 && Math.abs(x[at] / (samples * 0.001) - 1) < 0.02, `at ${x[at]} s`);
    assert.equal(y[0].indexOf(null, at + 1), -1, "only one gap");
  }
});

test("the nearest sample of a time is found, none in an empty history", () => {
  assert.equal(new History([Int32Array], 100).nearest(3), undefined);
  const history = filled(10, 100);
  assert.equal(history.nearest(-1), 0);
  assert.equal(history.nearest(0.0034), 3);
  assert.equal(history.nearest(0.0036), 4);
  assert.equal(history.nearest(9), 9);
});

test("the scale of a plot has round limits around its values", () => {
  assert.deepEqual(niceRange(0, 20_000, 20), [-5_000, 25_000]);
  const [low, high] = niceRange(7, 7, 20);
  assert.ok(low < 7 && high > 7 && high - low >= 20);
  assert.deepEqual(niceRange(Infinity, -Infinity, 10), [-5, 5]);
});

test("labels of a scale show its grid as it is", () => {
  assert.equal(labelDecimals([0, 2.5, 5, 7.5]), 1);
  assert.equal(labelDecimals([0, 0.25, 0.5]), 2);
  assert.equal(labelDecimals([0.1, 0.2, 0.3]), 1);
  assert.equal(labelDecimals([-20, -10, 0]), 0);
  assert.equal(labelDecimals([3_600.0001, 3_600.0002]), 4);
  assert.equal(labelDecimals([7]), 0);
});
