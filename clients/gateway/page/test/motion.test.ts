// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { movesOrPresses } from "../src/data/motion";

const ENABLED = 0x0637; // Operation enabled
const STANDING = { statusword: ENABLED, velocity: 0, torque: 0 };

test("an axis whose demand has a velocity moves in every mode", () => {
  for (const commandsTorque of [false, true]) {
    assert.ok(movesOrPresses({ ...STANDING, velocity: -1 }, commandsTorque));
    assert.ok(!movesOrPresses(STANDING, commandsTorque));
  }
});

test("an axis that stands presses in the modes that command a torque", () => {
  assert.ok(movesOrPresses({ ...STANDING, torque: -300 }, true));
  assert.ok(!movesOrPresses({ ...STANDING, torque: -300 }, false), "the torque holds a load");
});

test("the torque of a stop does not press", () => {
  assert.ok(!movesOrPresses({ statusword: 0x0617, velocity: 0, torque: 300 }, true), "Quick stop active");
});
