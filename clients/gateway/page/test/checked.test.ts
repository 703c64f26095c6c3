// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { CONTROL, DICTIONARY } from "../src/data/tables";
import { checked } from "../src/protocol/checked";

const MESSAGE = { enabled: true, holder: "a", you: false, name: "b", session: "", taken_at_ns: "0", silence_ms: 10_000 };

test("a message that fits its schema has its type", () => {
  assert.equal(checked(CONTROL, MESSAGE, "control").holder, "a");
});

test("members that the schema does not name are ignored", () => {
  assert.equal(checked(CONTROL, { ...MESSAGE, newer: 1 }, "control").name, "b");
});

test("a missing member and one of another type are named", () => {
  const { session: _, ...without } = MESSAGE;
  assert.throws(() => checked(CONTROL, without, "control"), /control\.session is missing/);
  assert.throws(
    () => checked(CONTROL, { ...MESSAGE, you: "yes" }, "control"),
    /control\.you is of type string: expected boolean/,
  );
});

test("the path of a wrong member leads through lists", () => {
  const dictionary = { version: "1", objects: [], modes: [], error_codes: [], statusword_bits: [], controlword_bits: [] };
  assert.throws(
    () => checked(DICTIONARY, { ...dictionary, disturbances: [null] }, "dictionary"),
    /dictionary\.disturbances\[0\] is of type null: expected object/,
  );
});
