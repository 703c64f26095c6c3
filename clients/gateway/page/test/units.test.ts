// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { formatAge, formatHex, formatNumber, formatPermille, formatUnits, parseNumber, scaleOf, toUserUnits, USER_UNITS } from "../src/data/units";

test("a rotary axis is shown in degrees with decimals that resolve one user unit", () => {
  const scale = scaleOf({ kind: "rotary", name: "deg", per: 4096 });
  // 360 / 4096 = 0.088 degrees a unit: 2 decimals.
  assert.deepEqual(scale, { name: "°", factor: 360 / 4096, decimals: 2 });
  assert.equal(formatUnits(1024, scale), "90.00");
  assert.equal(toUserUnits(90, scale), 1024);
  assert.equal(toUserUnits(0.05, scale), 1); // the nearest whole unit
});

test("a linear axis counts its user units in one unit of length", () => {
  const scale = scaleOf({ kind: "linear", name: "mm", per: 1000 });
  assert.equal(formatUnits(-1500, scale), "−1.500");
  assert.equal(toUserUnits(-1.5, scale), -1500);
});

test("an axis without a known unit is shown in user units", () => {
  assert.equal(scaleOf(undefined), USER_UNITS);
  assert.equal(scaleOf({ kind: "rotary", name: "deg", per: 0 }), USER_UNITS);
  assert.equal(scaleOf({ kind: "rotary", name: "parsec", per: 1 }), USER_UNITS);
});

test("numbers have groups of three and a true minus sign, and no minus before zero", () => {
  assert.equal(formatNumber(-1234567, 0), "−1\u202f234\u202f567");
  assert.equal(formatNumber(999, 1), "999.0");
  assert.equal(formatNumber(-0.04, 1), "0.0");
  assert.equal(formatNumber(NaN, 1), "–");
  assert.equal(formatPermille(-123), "−12.3");
  assert.equal(formatHex(0x8611), "8611h");
});

test("formatted numbers can be typed again", () => {
  for (const value of [0, 1234567, -1234567, -0.5]) {
    assert.equal(parseNumber(formatNumber(value, value % 1 === 0 ? 0 : 1)), value);
  }
  assert.equal(parseNumber(" 0x6041 "), 0x6041);
  assert.equal(parseNumber("12a"), undefined);
  assert.equal(parseNumber(""), undefined);
});

test("ages are rounded", () => {
  assert.equal(formatAge(3), "<0.1 s");
  assert.equal(formatAge(1234), "1.2 s");
  assert.equal(formatAge(61_000), "61 s");
  assert.equal(formatAge(600_000), "10 min");
  assert.equal(formatAge(Infinity), "–");
});
