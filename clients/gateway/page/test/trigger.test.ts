// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import type { LogEvent } from "../src/data/events";
import { findTrigger, isTriggerEvent, type Trigger } from "../src/data/trigger";

const find = (values: number[], condition: Parameters<typeof findTrigger>[3], wanted: number, begin = 1) =>
  findTrigger((n) => values[n], begin, values.length, condition, wanted);

test("an edge is the first sample at or beyond the level after one on the other side", () => {
  const values = [0, 5, 10, 15, 10, 5, 10, 20];
  assert.equal(find(values, "rising", 10), 2);
  assert.equal(find(values, "rising", 10, 3), 6);
  assert.equal(find(values, "falling", 10), 4);
  assert.equal(find(values, "falling", -1), undefined);
});

test("a signal that starts beyond the level has no edge before it was on the other side", () => {
  assert.equal(find([20, 21, 22], "rising", 10), undefined);
  assert.equal(find([20, 21, 22], "above", 10), 1);
  assert.equal(find([20, 21, 9], "below", 10), 2);
});

test("a bit triggers when it changes, whatever the others do", () => {
  // Bit 10, target reached: set in 0x0637, not in 0x0237.
  const words = [0x0237, 0x0227, 0x0637, 0x0637, 0x0237];
  assert.equal(find(words, "bit_set", 10), 2);
  assert.equal(find(words, "bit_cleared", 10), 4);
  assert.equal(find(words, "bit_set", 3), undefined);
});

test("nothing is found without new samples", () => {
  assert.equal(find([0, 10], "rising", 5, 2), undefined);
});

test("an event is that of the axis or of its bench, by its kind or its text", () => {
  const trigger: Trigger = { mode: "single", axis: "1.2", member: "", condition: "event", value: 0, text: "FAULT", before: 0.5 };
  const event = (axis: number, kind: string, message = ""): LogEvent => ({ bench: 1, axis, tick: 1, time: 1, level: 2, kind, message });
  assert.ok(isTriggerEvent(trigger, event(2, "fault")));
  assert.ok(isTriggerEvent(trigger, event(0, "note", "a fault of the bench")));
  assert.ok(!isTriggerEvent(trigger, event(1, "fault")));
  assert.ok(!isTriggerEvent(trigger, { ...event(2, "fault"), bench: 2 }));
  assert.ok(!isTriggerEvent(trigger, event(2, "state_changed")));
  assert.ok(isTriggerEvent({ ...trigger, text: "" }, event(2, "state_changed")));
});
