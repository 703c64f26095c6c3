// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { EventList, eventsCsv, eventText, matchesEvent, type LogEvent } from "../src/data/events";

const EPOCH_S = 1.8e9;

/** An event of bench 1, axis 2, at this time [s]. */
function event(time: number, more: Partial<LogEvent> = {}): LogEvent {
  return { bench: 1, axis: 2, tick: Math.round(time * 1000), time, level: 2, kind: "state_changed", message: "Fault", ...more };
}

const times = (list: EventList) => list.events.map(({ time }) => time);

test("the history comes before newer events, and no event appears twice", () => {
  const list = new EventList(100);
  list.add(event(EPOCH_S + 3));
  list.add(event(EPOCH_S + 4));
  // The gateway has also stored the first of them.
  list.merge([event(EPOCH_S + 1), event(EPOCH_S + 2), event(EPOCH_S + 3)]);
  assert.deepEqual(times(list), [1, 2, 3, 4].map((second) => EPOCH_S + second));
  list.merge([event(EPOCH_S + 1), event(EPOCH_S + 5)]);
  assert.deepEqual(times(list), [1, 2, 3, 4, 5].map((second) => EPOCH_S + second));
});

test("events of one tick that differ are not the same", () => {
  const list = new EventList(100);
  list.add(event(EPOCH_S));
  list.merge([event(EPOCH_S, { axis: 3 }), event(EPOCH_S, { message: "fault 0x8611", kind: "fault" }), event(EPOCH_S, { bench: 4 })]);
  assert.equal(list.events.length, 4);
});

test("the events of several benches stand in the order of their times, those without a date first", () => {
  const list = new EventList(100);
  list.add(event(EPOCH_S + 2));
  list.merge([event(EPOCH_S + 1, { bench: 7 }), event(EPOCH_S + 3, { bench: 7 })]);
  list.merge([event(5, { bench: 9 })]);
  assert.deepEqual(times(list), [5, EPOCH_S + 1, EPOCH_S + 2, EPOCH_S + 3]);
});

test("another run of a bench forgets the events of the run before, and no others", () => {
  const list = new EventList(100);
  list.add(event(50));
  list.add(event(60, { bench: 2 }));
  list.forget(1);
  list.add(event(0.5));
  assert.deepEqual(times(list), [60, 0.5]);
  list.merge([event(0.1), event(0.5)]);
  assert.deepEqual(times(list), [0.1, 0.5, 60]);
});

test("a flood of one kind leaves the events of others", () => {
  const list = new EventList(10);
  list.add(event(EPOCH_S, { kind: "fault" }));
  for (let i = 1; i <= 50; ++i) list.add(event(EPOCH_S + i, { kind: "tick_overrun" }));
  assert.deepEqual(times(list), [0, 42, 43, 44, 45, 46, 47, 48, 49, 50].map((second) => EPOCH_S + second));
});

test("of too many the oldest are removed, and each change is seen", () => {
  const list = new EventList(3);
  for (let i = 0; i < 5; ++i) list.add(event(EPOCH_S + i));
  assert.deepEqual(times(list), [2, 3, 4].map((second) => EPOCH_S + second));
  const { version } = list;
  list.merge([event(EPOCH_S - 1)]);
  assert.deepEqual(times(list), [2, 3, 4].map((second) => EPOCH_S + second));
  assert.ok(list.version > version);
});

const SESSION = "00000000abcdef01";
const NAMED: LogEvent = {
  bench: 1,
  axis: 2,
  tick: 1_500,
  time: 1.5,
  level: 3,
  kind: "control_changed",
  message: `axis 2: session 0x${SESSION} takes the axis from session 0x0000000000000002`,
};

test("an event has the names of programs that are known, and not its axis, which stands next to it", () => {
  assert.equal(
    eventText(NAMED, (session) => (session === SESSION ? "vdrive" : undefined), () => ""),
    "vdrive takes the axis from session 0x0000000000000002",
  );
  assert.equal(eventText({ ...NAMED, axis: 0, message: "axis 2: faulted" }, () => undefined, () => ""), "axis 2: faulted");
  const error = (code: number) => (code === 0x8611 ? "following error" : "");
  assert.equal(eventText({ ...NAMED, message: "fault 0x8611 reset" }, () => undefined, error), "fault 0x8611 following error reset");
  assert.equal(eventText({ ...NAMED, message: "fault 0x1234" }, () => undefined, error), "fault 0x1234");
});

test("events are filtered by level, by every word of a text and by session", () => {
  const all = { level: 0, text: "", session: "" };
  const matches = (filter: object) => matchesEvent(NAMED, "1.2 lift control_changed vdrive takes the axis", { ...all, ...filter });
  assert.ok(matches({}) && matches({ level: 3 }) && matches({ text: "LIFT takes" }) && matches({ session: SESSION }));
  assert.ok(!matches({ level: 4 }) && !matches({ text: "lift faulted" }) && !matches({ session: "1".padStart(16, "0") }));
});

test("a saved event has its date where drive time has one, and quotes what CSV needs quoted", () => {
  const rows = [{ event: { ...NAMED, time: 1_795_996_800.25 }, source: "1.2 lift", text: 'says "no", and waits' }];
  assert.equal(
    eventsCsv(rows),
    'source,tick,time [s],date,level,kind,text\n1.2 lift,1500,1795996800.250000,2026-11-30T00:00:00.250000Z,3,control_changed,"says ""no"", and waits"\n',
  );
});
