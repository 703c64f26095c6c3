// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import {
  formatAge,
  formatHex,
  formatNumber,
  formatPermille,
  formatUnits,
  parseNumber,
  parseQuantity,
  retyped,
  scaleOf,
  suffixOf,
  toUserUnits,
  USER_UNITS,
  wholeUserUnits,
} from "../src/data/units";

test("a rotary axis is shown in degrees with decimals that resolve one user unit", () => {
  const scale = scaleOf({ kind: "rotary", name: "deg", per: 4096 });
  // 360 / 4096 = 0.088 degrees per unit: 2 decimals.
  assert.deepEqual(scale, { name: "°", factor: 360 / 4096, decimals: 2 });
  assert.equal(formatUnits(1024, scale), "90.00");
  assert.equal(toUserUnits(90, scale), 1024);
  assert.equal(toUserUnits(0.05, scale), 1); // the nearest integer
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

const ROTARY = { kind: "rotary", name: "deg", per: 4096 };
const LINEAR = { kind: "linear", name: "mm", per: 1000 };

/** @return the user units of typed text while the page shows user units. */
const typed = (text: string, unit: typeof ROTARY) => {
  const found = parseQuantity(text, USER_UNITS, unit);
  return "why" in found ? found.why : (wholeUserUnits(found) ?? "a fraction");
};

test("a value with a unit becomes the nearest user units, a fraction of a bare one is refused", () => {
  assert.equal(typed("90deg", ROTARY), 1024);
  assert.equal(typed("-90 °", ROTARY), -1024);
  assert.equal(typed("0.5 rev", ROTARY), 2048);
  assert.equal(typed("0.05deg", ROTARY), 1); // 0.57 of a unit
  assert.equal(typed("-0.0005mm", LINEAR), -1); // half a unit, away from 0
  assert.equal(typed("1.5", ROTARY), "a fraction");
  assert.equal(typed("1.6 UU", ROTARY), "a fraction");
  assert.equal(typed("0x10", ROTARY), 16);
  assert.equal(typed("1e6", ROTARY), 1_000_000);
});

test("a number with a unit that the axis does not have is refused", () => {
  for (const text of ["90mm", "9O", "90deg/s"]) assert.equal(typed(text, ROTARY), "no_such_unit");
  for (const text of ["deg", "1.5.5deg", "", "1,5,5", "1.234,5"]) assert.equal(typed(text, ROTARY), "not_a_number");
  assert.equal(typed("90deg", LINEAR), "no_such_unit");
  assert.deepEqual(parseQuantity("12 mm", USER_UNITS, ROTARY), { why: "no_such_unit", units: ["deg", "rad", "rev", "UU"] });
  assert.deepEqual(parseQuantity("90deg", USER_UNITS, LINEAR), { why: "no_such_unit", units: ["mm", "UU"] });
  assert.deepEqual(parseQuantity("12 mm", USER_UNITS, LINEAR, "/s"), { why: "no_such_unit", units: ["mm/s", "UU/s"] });
});

test("a decimal comma is a decimal point, and one that could part thousands is refused", () => {
  assert.equal(parseNumber("1,5"), 1.5);
  assert.equal(parseNumber("-0,125"), -0.125);
  assert.equal(typed("1,5 mm", LINEAR), 1500);
  assert.equal(typed("12,25mm", LINEAR), 12_250);
  assert.equal(typed("1,5", LINEAR), "a fraction");
  assert.equal(typed("1,500", LINEAR), "ambiguous_comma");
  assert.equal(typed("-12,345 mm", LINEAR), "ambiguous_comma");
});

// The units of the dictionary, as the core has them.
test("every object that is a position, a velocity, an acceleration or a jerk has the unit of its axis", () => {
  const scale = scaleOf(LINEAR);
  const rows: [units: string, suffix: string][] = [["PosUU", ""], ["PosCU（位置坐标转换，用户单位）", ""], ["p", ""], ["VelUU", "/s"], ["VelCU", "/s"], ["AccUU", "/s²"], ["JerkUU", "/s³"]];
  for (const [units, expected] of rows) {
    const suffix = suffixOf(units);
    assert.equal(suffix, expected, units);
    if (suffix === undefined) continue;
    assert.deepEqual(parseQuantity(`12 mm${suffix}`, USER_UNITS, LINEAR, suffix), { value: 12, scale });
    assert.deepEqual(parseQuantity(`1,5mm${suffix.replace("²", "2").replace("³", "^3")}`, USER_UNITS, LINEAR, suffix), { value: 1.5, scale });
  }
  for (const units of ["-", "ms", "rpm", "TqCU（转矩坐标转换，用户单位 mA）", "0.1 % of rated"]) assert.equal(suffixOf(units), undefined, units);
});

test("what was typed is converted with the unit, and back without loss", () => {
  const degrees = scaleOf(ROTARY);
  assert.equal(retyped("100000", USER_UNITS, degrees), "8789.06");
  assert.equal(retyped("8789.06", degrees, USER_UNITS), "100000");
  assert.equal(retyped("100000", USER_UNITS, USER_UNITS), "100000");
  assert.equal(retyped("90deg", USER_UNITS, degrees), "90deg");
  assert.equal(retyped("", USER_UNITS, degrees), "");
});

test("ages are rounded", () => {
  assert.equal(formatAge(3), "<0.1 s");
  assert.equal(formatAge(1234), "1.2 s");
  assert.equal(formatAge(61_000), "61 s");
  assert.equal(formatAge(600_000), "10 min");
  assert.equal(formatAge(Infinity), "–");
});
