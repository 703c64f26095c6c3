// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { Motion, type Reading, type MotionStatus } from "../src/data/motions";

const OWN = 7n;
const ENABLED = 0x0237;
const REACHED = 1 << 10;
const LIMIT = 1 << 11;
const ATTAINED = 1 << 12;
const HOMING_ERROR = 1 << 13;
const HALT = 0x10f;

/** A move from 1,000 to 5,000 in profile position mode, accepted before tick 100. */
const ACCEPTED: Reading = { tick: 100, controlword: 0x0f, mode: 1, target: 5000, position: 1000, span: 0 };
const ON_THE_WAY: MotionStatus = {
  tick: 101,
  owner: OWN,
  statusword: ENABLED,
  mode: 1,
  errorCode: 0,
  inputs: 0,
  position: 2000,
  demand: 2010,
  velocity: 20_000,
};
const AT_TARGET: MotionStatus = { ...ON_THE_WAY, tick: 300, statusword: ENABLED | REACHED, position: 4999, demand: 5000, velocity: 0 };

function move(reading: Partial<Reading> = {}, target: number | undefined = reading.target ?? ACCEPTED.target): Motion {
  const motion = Motion.of({ ...ACCEPTED, ...reading }, OWN, target);
  assert.ok(motion !== undefined);
  return motion;
}

function taking(motion: Motion, ...statuses: Partial<MotionStatus>[]): Motion {
  for (const status of statuses) motion.take({ ...ON_THE_WAY, ...status });
  return motion;
}

test("a move covers a growing share of its way until it reaches its target", () => {
  const motion = move();
  assert.equal(motion.share, 0);
  taking(motion, {});
  assert.equal(motion.share, 0.25); // 1,000 of 4,000
  assert.equal(motion.end, undefined);
  taking(motion, AT_TARGET);
  assert.deepEqual(motion.end, { kind: "reached" });
  assert.equal(motion.position, 4999);
});

test("a status from before the drive had accepted the move is of another one", () => {
  const motion = taking(move(), { ...AT_TARGET, tick: 99 });
  assert.equal(motion.end, undefined);
  assert.equal(motion.position, 1000);
});

test("a demand that has arrived is not the end before bit 10", () => {
  assert.equal(taking(move(), { ...AT_TARGET, statusword: ENABLED }).end, undefined);
});

const ENDS: [string, Partial<MotionStatus>, Motion["end"]][] = [
  ["a fault", { statusword: 0x0208, errorCode: 0x8611 }, { kind: "fault", code: 0x8611 }],
  ["a quick stop", { statusword: 0x0217 }, { kind: "state", state: "quick_stop_active" }],
  ["a lost enable", { statusword: 0x0250 }, { kind: "state", state: "switch_on_disabled" }],
  ["another mode", { mode: 3 }, { kind: "mode", mode: 3 }],
  ["another session", { owner: 9n }, { kind: "owner", session: 9n }],
  ["nobody's control", { owner: 0n }, { kind: "owner", session: 0n }],
  ["a software limit", { statusword: ENABLED | REACHED | LIMIT, demand: 4000, velocity: 0 }, { kind: "software_limit" }],
  ["a limit switch in the way", { inputs: 2, velocity: 0 }, { kind: "positive_limit" }],
];

for (const [name, status, end] of ENDS) {
  test(`a move is ended by ${name}, and stays so`, () => {
    const motion = taking(move(), {}, status, { ...AT_TARGET, tick: 400 });
    assert.deepEqual(motion.end, end);
    assert.equal(motion.position, 2000);
  });
}

test("a limit switch that has opened again has ended the move, one on the other side does not", () => {
  assert.deepEqual(taking(move(), { inputs: 2 }, { inputs: 0, velocity: 0 }).end, { kind: "positive_limit" });
  assert.equal(taking(move(), { inputs: 1 }, { inputs: 1, velocity: 0 }).end, undefined);
  assert.deepEqual(taking(move({ target: -5000 }), { inputs: 1, velocity: 0 }).end, { kind: "negative_limit" });
});

/** The axis stands still on its way, with bit 10 set. */
const STANDS: Partial<MotionStatus> = { statusword: ENABLED | REACHED, velocity: 0 };

test("where the axis stands on its way the drive is asked: a halt, another set-point, or it goes on", () => {
  const answers: [Partial<Reading>, Motion["end"]][] = [
    [{ controlword: HALT }, { kind: "halt" }],
    [{ target: 0 }, { kind: "set_point", target: 0 }],
    [{}, undefined],
    [{ tick: 99, controlword: HALT }, undefined],
  ];
  for (const [reading, end] of answers) {
    const motion = taking(move(), STANDS);
    assert.ok(motion.mustAsk);
    motion.answer({ ...ACCEPTED, tick: 102, ...reading });
    assert.deepEqual(motion.end, end);
  }
});

test("an answer that comes when the axis moves on ends nothing", () => {
  const motion = taking(move(), STANDS, { tick: 102 });
  assert.ok(!motion.mustAsk);
  motion.answer({ ...ACCEPTED, tick: 102, controlword: HALT });
  assert.equal(motion.end, undefined);
});

test("where a relative move ends is not known before, and bit 10 without a halt is its end", () => {
  const relative = Motion.of(ACCEPTED, OWN, undefined);
  assert.ok(relative !== undefined);
  const motion = taking(relative, {});
  assert.equal(motion.target, undefined);
  assert.equal(motion.share, undefined);
  taking(motion, STANDS);
  motion.answer({ ...ACCEPTED, tick: 102 });
  assert.deepEqual(motion.end, { kind: "reached" });
});

test("on a modulo axis 6062h of a target beyond the range is its place in the range", () => {
  const ends = (status: Partial<MotionStatus>, span: number, target: number) => {
    const motion = taking(move({ target }), { ...STANDS, ...status });
    motion.answer({ ...ACCEPTED, tick: 102, target, span });
    return motion.end;
  };
  assert.deepEqual(ends({ demand: 1400 }, 3600, 5000), { kind: "reached" });
  assert.deepEqual(ends({ demand: 3400 }, 3600, -200), { kind: "reached" });
  assert.equal(ends({ demand: 1401 }, 3600, 5000), undefined);
  assert.equal(ends({ demand: 1400 }, 0, 5000), undefined, "607Bh makes no modulo axis of it");
});

test("a homing run ends with home found, a homing error, a halt or an interruption", () => {
  const runs = (status: Partial<MotionStatus>) => taking(move({ mode: 6 }), { mode: 6 }, { mode: 6, ...status });
  assert.equal(runs({}).end, undefined);
  assert.equal(runs({ statusword: ENABLED | ATTAINED }).end, undefined);
  assert.deepEqual(runs({ statusword: ENABLED | ATTAINED | REACHED }).end, { kind: "home_found" });
  assert.deepEqual(runs({ statusword: ENABLED | HOMING_ERROR | REACHED }).end, { kind: "homing_error" });
  for (const [controlword, kind] of [[HALT, "halt"], [0x0f, "interrupted"]] as const) {
    const motion = runs(STANDS);
    motion.answer({ ...ACCEPTED, mode: 6, controlword });
    assert.deepEqual(motion.end, { kind });
  }
});

test("a mode without an end has no motion to follow", () => {
  assert.equal(Motion.of({ ...ACCEPTED, mode: 3 }, OWN, undefined), undefined);
});
