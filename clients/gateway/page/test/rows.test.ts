// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { decodePowerState, wayBetween } from "../src/data/power";
import { matches, sorted, type Filter, type Row } from "../src/data/rows";

const ROW: Row = {
  bench: 1,
  axis: 1,
  name: "left",
  state: "operation_enabled",
  mode: 1,
  position: 0,
  velocity: 0,
  torque: 0,
  error: 0,
  owner: "",
  fault: 0,
  moving: false,
  age: 0,
};
const ALL: Filter = { text: "", bench: undefined, faulted: false, moving: false, owned: false };

test("the search finds names by any part and addresses by their start", () => {
  const row = { ...ROW, bench: 2, axis: 13, name: "Gantry left" };
  for (const text of ["gan", "LEFT", "2.1", "2.13", "left gan", ""]) assert.ok(matches(row, { ...ALL, text }), text);
  for (const text of ["right", "13", "2.2", "left right"]) assert.ok(!matches(row, { ...ALL, text }), text);
});

test("filters show the named kind of axes", () => {
  assert.ok(!matches(ROW, { ...ALL, faulted: true }));
  assert.ok(matches({ ...ROW, state: "fault_reaction_active" }, { ...ALL, faulted: true }));
  assert.ok(!matches(ROW, { ...ALL, moving: true }));
  assert.ok(matches({ ...ROW, moving: true }, { ...ALL, moving: true }));
  assert.ok(!matches(ROW, { ...ALL, owned: true }));
  assert.ok(matches({ ...ROW, owner: "@" }, { ...ALL, owned: true }));
  assert.ok(!matches(ROW, { ...ALL, bench: 2 }));
});

test("speeds are ordered by size, equal rows by address, names as people count", () => {
  const rows = [
    { ...ROW, axis: 3, name: "axis10", velocity: -50 },
    { ...ROW, axis: 1, name: "axis9", velocity: 20 },
    { ...ROW, axis: 2, name: "axis2", velocity: 20 },
  ];
  const order = (key: "velocity" | "name" | "address", descending: boolean) =>
    sorted(rows, { key, descending }).map((row) => row.axis);
  assert.deepEqual(order("velocity", true), [3, 1, 2]);
  assert.deepEqual(order("name", false), [2, 1, 3]);
  assert.deepEqual(order("address", true), [3, 2, 1]);
});

test("faults come first in the order of states", () => {
  const rows = [{ ...ROW, axis: 1 }, { ...ROW, axis: 2, state: "fault" as const }];
  assert.deepEqual(sorted(rows, { key: "state", descending: false }).map((row) => row.axis), [2, 1]);
});

test("statuswords decode by the masks of CiA 402, for any other bits", () => {
  const words: [number, string][] = [
    [0x0250, "switch_on_disabled"],
    [0x0231, "ready_to_switch_on"],
    [0x0233, "switched_on"],
    [0x1637, "operation_enabled"],
    [0x0217, "quick_stop_active"],
    [0x021f, "fault_reaction_active"],
    [0x0218, "fault"],
    [0x0200, "not_ready_to_switch_on"],
  ];
  for (const [word, state] of words) assert.equal(decodePowerState(word), state, word.toString(16));
});

test("the path between two states has the fewest transitions", () => {
  assert.deepEqual(wayBetween("switch_on_disabled", "operation_enabled"), [2, 3, 4]);
  assert.deepEqual(wayBetween("operation_enabled", "switch_on_disabled"), [9]);
  assert.deepEqual(wayBetween("operation_enabled", "fault"), [13, 14]);
  assert.deepEqual(wayBetween("fault", "switch_on_disabled"), [15]);
  assert.deepEqual(wayBetween("quick_stop_active", "operation_enabled"), [16]);
  assert.deepEqual(wayBetween("fault", "fault"), []);
});
