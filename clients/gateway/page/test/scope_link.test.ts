// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { formatScope, parseScope, SET_POINTS, type ScopeState } from "../src/data/scope_link";

const STATE: ScopeState = {
  strips: [
    { axis: "1.1", members: ["position_demand_value", "load_position_actual_value"] },
    { axis: "1.12", members: ["torque_demand"] },
    { axis: "1.1", members: [SET_POINTS] },
  ],
  window: 2,
  // A bench in real time: seconds since 1970, to the microsecond.
  range: [1795996800.123456, 1795996802.123456],
  cursors: [1795996801, 1795996801.5],
  trigger: { mode: "normal", axis: "1.1", member: "load_velocity_actual_value", condition: "rising", value: -1000, text: "", before: 0.25 },
};

test("a link opens what it was made of", () => {
  assert.deepEqual(parseScope(formatScope(STATE)), { state: STATE, bad: [] });
});

test("a text that the trigger looks for survives what has a meaning in links", () => {
  const trigger = { ...STATE.trigger!, condition: "event" as const, text: "a & b = c, 50 %; d" };
  assert.deepEqual(parseScope(formatScope({ strips: [], trigger })).state.trigger, trigger);
});

test("parts that cannot be read are named and left out", () => {
  const { state, bad } = parseScope("s=1.1:a b&w=-1&t=5,5&c=1&g=once,1.1,x,rising,0,0.5,&z=1&w=3");
  assert.deepEqual(bad, ["s=1.1:a b", "w=-1", "t=5,5", "c=1", "g=once,1.1,x,rising,0,0.5,", "z=1"]);
  assert.equal(state.window, 3);
});

test("an escape that is none is a part that cannot be read", () => {
  assert.deepEqual(parseScope("s=%zz&w=3"), { state: { window: 3 }, bad: ["s=%zz"] });
});
