// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { Samples } from "../src/data/samples";
import { TriggerRun, type Trigger } from "../src/data/trigger";

/** A bench in real time: its ticks of a millisecond count from 1970. */
const FIRST_TICK = 1_795_996_800_000;

function made(): Samples {
  const axis = { address: "1.1", bench: 1, axis: 1, name: "x", unit: undefined };
  return new Samples(axis, { period: 0.001, isRegular: true, capacity: 10_000, hasControlword: false });
}

/** A position in each tick from `first` on, in Switch on disabled. */
function message(first: number, positions: number[], missed = 0) {
  return {
    tick: BigUint64Array.from(positions, (_, i) => BigInt(first + i)),
    missed: BigInt(missed),
    load_position_actual_value: Int32Array.from(positions),
    ds402_statusword: Uint16Array.from(positions, () => 0x0240),
  };
}

test("the first message shows which signals an axis has", () => {
  const samples = made();
  assert.equal(samples.series("load_position_actual_value"), undefined);
  samples.take(message(FIRST_TICK, [7]));
  assert.deepEqual(samples.members, ["load_position_actual_value", "ds402_statusword"]);
  assert.equal(samples.series("ds402_controlword"), undefined, "nobody reads it");
  assert.equal(samples.history.value(samples.series("load_position_actual_value") ?? -1, 0), 7);
});

test("times are drive time, exact to the tick after 56 years", () => {
  const samples = made();
  samples.take(message(FIRST_TICK + 1, [1, 2]));
  assert.equal(samples.begin, (FIRST_TICK + 1) / 1000);
  assert.equal(samples.tickAt(samples.end ?? 0), FIRST_TICK + 2);
});

test("missed ticks are counted from the first message on, and are a gap", () => {
  const samples = made();
  samples.take(message(FIRST_TICK, [1, 2], 40));
  samples.take(message(FIRST_TICK + 5, [3], 43));
  assert.equal(samples.lost, 3);
  const { y } = samples.history.points(0, 1, 100, [0]);
  assert.deepEqual(y[0], [1, 2, null, 3]);
});

test("a bench that starts again begins a new history", () => {
  const samples = made();
  samples.take(message(FIRST_TICK, [1, 2, 3]));
  samples.take(message(10, [9]));
  assert.equal(samples.history.end, 1);
  assert.equal(samples.begin, 0.01);
});

const TRIGGER: Trigger = {
  mode: "normal", axis: "1.1", member: "load_position_actual_value", condition: "rising", value: 10, text: "", before: 0.25,
};

test("a run is complete when what comes after the trigger is there, and the next one is sought after it", () => {
  const samples = made();
  samples.take(message(1_000, [0]));
  const run = new TriggerRun(TRIGGER, samples, () => [], 1);
  // Rises through 10 in ticks 1,002 and 1,005; a window of 8 ms has six ticks after the trigger.
  samples.take(message(1_001, [0, 10, 20, 0, 10, 20]));
  assert.ok(!run.advance(0.008, samples.end ?? 0));
  assert.ok(run.isFilling);
  samples.take(message(1_007, [0, 0, 0, 15]));
  assert.ok(run.advance(0.008, samples.end ?? 0));
  assert.equal(run.at, 1.002);
  // The rise in tick 1,005 is within that run.
  samples.take(message(1_011, Array.from({ length: 8 }, () => 0)));
  assert.ok(run.advance(0.008, samples.end ?? 0));
  assert.deepEqual([run.last, run.at], [1.002, 1.01]);
});

test("what was before the trigger was armed is not found", () => {
  const samples = made();
  samples.take(message(1_000, [0, 20, 0, 0]));
  const run = new TriggerRun(TRIGGER, samples, () => [], samples.end ?? 0);
  assert.ok(!run.advance(0.001, 9));
  assert.ok(!run.isFilling);
});

test("a trigger on a signal that the axis does not have says so, as soon as its signals are known", () => {
  const samples = made();
  const run = new TriggerRun({ ...TRIGGER, member: "speed" }, samples, () => [], 0);
  assert.ok(!run.isWithoutSignal);
  samples.take(message(1_000, [0]));
  assert.ok(run.isWithoutSignal);
});

test("an event triggers at its own time", () => {
  const samples = made();
  samples.take(message(1_000, [0]));
  const event = { bench: 1, axis: 1, tick: 1_500, time: 1.5, level: 4, kind: "fault", message: "" };
  const run = new TriggerRun({ ...TRIGGER, condition: "event", text: "fault" }, samples, () => [{ ...event, time: 0.5 }, event], 1);
  assert.ok(run.advance(0.1, 2));
  assert.equal(run.at, 1.5);
});
