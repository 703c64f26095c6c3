// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { extentOf, stepResponseOf, type Part } from "../src/data/measures";

const STEP = 0.0001; // [s] per sample

function part(samples: number, value: (time: number) => number): Part {
  return { begin: 0, end: samples, time: (n) => n * STEP, value: (n) => value(n * STEP) };
}

const near = (actual: number | undefined, expected: number, tolerance: number) =>
  assert.ok(actual !== undefined && Math.abs(actual - expected) <= tolerance, `${actual} is not ${expected} ± ${tolerance}`);

test("minimum, maximum and mean of a ramp are its ends and its middle", () => {
  // 0 to 100 in 101 samples: their sum is 100 x 101 / 2.
  assert.deepEqual(extentOf({ begin: 0, end: 101, time: (n) => n, value: (n) => n }), { minimum: 0, maximum: 100, mean: 50 });
});

test("nothing is measured without samples", () => {
  assert.equal(extentOf({ begin: 5, end: 5, time: (n) => n, value: (n) => n }), undefined);
  assert.equal(stepResponseOf(part(10, (time) => time)), undefined);
});

for (const [what, height, offset] of [["up", 2000, 0], ["down", -300, 1000]] as const) {
  test(`a first-order lag of 20 ms that goes ${what} rises in 2.197 time constants and settles in 3.912`, () => {
    const lag = 0.02;
    const found = stepResponseOf(part(5000, (time) => offset + height * (1 - Math.exp(-time / lag))));
    // 1 - e^(-t/T) is 0.1 and 0.9 at times that differ by T ln 9, and stays within 2 % of 1 after T ln 50.
    near(found?.rise, lag * Math.log(9), 2e-5);
    near(found?.settling, lag * Math.log(50), 2 * STEP);
    near(found?.overshoot, 0, 1e-6);
  });
}

test("a second-order system with a damping of 0.5 overshoots by 16.3 %", () => {
  const damping = 0.5;
  const omega = 100; // [rad/s]
  const damped = omega * Math.sqrt(1 - damping ** 2);
  const found = stepResponseOf(
    part(5000, (time) => 1000 * (1 - Math.exp(-damping * omega * time) * (Math.cos(damped * time) + (damping * omega * Math.sin(damped * time)) / damped))),
  );
  // e^(-pi d / sqrt(1 - d^2))
  near(found?.overshoot, Math.exp((-Math.PI * damping) / Math.sqrt(1 - damping ** 2)), 1e-4);
  // By the roots of its response, this system stays within 2 % after 8.08 / omega; the envelope would give 8.11.
  near(found?.settling, 0.0808, 0.0005);
});

test("a step between two samples rises within their distance", () => {
  const found = stepResponseOf(part(1000, (time) => (time < 0.03 ? 0 : 100)));
  // From 10 % to 90 % of the line between the two samples.
  near(found?.rise, 0.8 * STEP, 1e-9);
  near(found?.settling, 0.03, STEP);
});

test("what returns, goes on or stands is no step", () => {
  assert.equal(stepResponseOf(part(1000, () => 7)), undefined, "stands");
  assert.equal(stepResponseOf(part(1000, (time) => time)), undefined, "goes on");
  assert.equal(stepResponseOf(part(1000, (time) => Math.sin(time * 200))), undefined, "swings");
});
