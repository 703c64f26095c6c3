// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import type { LogEvent } from "../src/data/events";
import { marksOf, type Moment } from "../src/data/moments";

function event(tick: number, kind: string): LogEvent {
  return { bench: 1, axis: 2, tick, time: tick / 1000, level: 2, kind, message: kind };
}

const shown = (moments: Moment[], events: LogEvent[]) => marksOf(moments, events).map(({ tick, kind }) => `${kind} ${tick}`);

test("a change that the status and an event show is one mark", () => {
  const moments: Moment[] = [{ tick: 100, state: "fault_reaction_active" }, { tick: 100, code: 0x8611 }, { tick: 150, state: "fault" }];
  const events = [event(100, "state_changed"), event(101, "fault"), event(150, "state_changed")];
  assert.deepEqual(shown(moments, events), ["state 100", "fault 100", "state 150"]);
});

test("a change that only an event shows has its mark: nobody watched the axis then", () => {
  const events = [event(10, "fault"), event(20, "state_changed")];
  assert.deepEqual(shown([{ tick: 200, state: "fault" }], events), ["fault 10", "state 20", "state 200"]);
});

test("a fault does not hide a change of state of the same tick, nor the other way round", () => {
  assert.deepEqual(shown([{ tick: 100, code: 0x8611 }], [event(100, "state_changed")]), ["fault 100", "state 100"]);
});

test("any other event is a separate mark, in the order of ticks", () => {
  const events = [event(90, "control_changed"), event(100, "tick_jumped"), event(300, "fault_reset")];
  assert.deepEqual(shown([{ tick: 100, state: "fault" }], events), ["event 90", "state 100", "event 100", "event 300"]);
});

test("a late tick has no mark: hundreds of them would hide the others", () => {
  assert.deepEqual(shown([], [event(90, "tick_overrun"), event(91, "fault_reset"), event(92, "tick_overrun")]), ["event 91"]);
});
