// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { hasHandshake, heldSetPoints, homingState } from "../src/data/setpoints";

// Statuswords of Operation enabled, voltage on, remote: 0237h; bit 10 = 0400h, bit 12 = 1000h.
const MOVING = 0x0237;
const REACHED = 0x0637;
const MOVING_ACKNOWLEDGED = 0x1237;

test("a drive at its target holds no set-point", () => {
  assert.deepEqual(heldSetPoints(0x0f, REACHED, 1), { active: 0, waiting: 0 });
  assert.deepEqual(heldSetPoints(0x3f, REACHED | 0x1000, 1), { active: 0, waiting: 0 });
});

test("a drive that moves and acknowledges nothing has a free place", () => {
  assert.deepEqual(heldSetPoints(0x0f, MOVING, 1), { active: 1, waiting: 0 });
});

test("an acknowledge that outlasts bit 4 means a waiting set-point", () => {
  assert.deepEqual(heldSetPoints(0x0f, MOVING_ACKNOWLEDGED, 1), { active: 1, waiting: 1 });
});

test("while bit 4 is set, bit 5 means that none waits, and without it the number is unknown", () => {
  assert.deepEqual(heldSetPoints(0x3f, MOVING_ACKNOWLEDGED, 1), { active: 1, waiting: 0 });
  assert.deepEqual(heldSetPoints(0x1f, MOVING_ACKNOWLEDGED, 1), { active: 1, waiting: undefined });
});

test("only profile position mode has the handshake of set-points", () => {
  assert.ok(hasHandshake(1) && hasHandshake(undefined));
  for (const mode of [0, 2, 3, 4, 6, 7, 8, 9, 10]) assert.ok(!hasHandshake(mode), String(mode));
});

test("in another mode or state, and under halt, the words do not show set-points", () => {
  assert.equal(heldSetPoints(0x010f, REACHED, 1), undefined);
  assert.equal(heldSetPoints(0x0f, MOVING, 3), undefined);
  assert.equal(heldSetPoints(0x07, 0x0233, 1), undefined); // Switched on
});

test("the state of homing is that of bits 13, 12 and 10 (CiA 402-2)", () => {
  // Operation enabled: bits 12 and 10 in each combination, then bit 13 without and with bit 10.
  const states = [0x0237, 0x0637, 0x1237, 0x1637, 0x2237, 0x2637].map(homingState);
  assert.deepEqual(states, ["runs", "stands", "attained", "done", "error_moves", "error_stands"]);
});
