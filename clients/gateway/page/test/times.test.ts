// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { formatTime, isoDate, timeText } from "../src/data/times";

/** 2026-03-05 14:03:27 in the time zone where the tests run [s]. */
const AFTERNOON = new Date(2026, 2, 5, 14, 3, 27).getTime() / 1000;

test("a time from the epoch on is a time of the day, any other one is seconds", () => {
  assert.equal(timeText(AFTERNOON + 0.25), "14:03:27.250");
  assert.equal(timeText(12.25), "12.250 s");
  assert.equal(formatTime(AFTERNOON, 0), "14:03:27");
  assert.equal(formatTime(12.25, 1), "12.3");
});

test("a fraction that is rounded up begins the next second", () => {
  assert.equal(formatTime(AFTERNOON + 0.99996, 3), "14:03:28.000");
  assert.equal(formatTime(AFTERNOON + 0.9994, 3), "14:03:27.999");
});

test("a date has the microseconds of the tick, and no date is made up", () => {
  // A tick of 125 us: 2026-01-01T00:00:00Z is 1767225600 s since 1970.
  assert.equal(isoDate(1767225600.000125), "2026-01-01T00:00:00.000125Z");
  assert.equal(isoDate(1767225599.9999999), "2026-01-01T00:00:00.000000Z");
  assert.equal(isoDate(600), "");
});
