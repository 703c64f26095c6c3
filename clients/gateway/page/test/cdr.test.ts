// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { decodeCdr } from "../src/protocol/cdr";
import { parseSchema } from "../src/protocol/schema";

/** Encapsulation of little-endian CDR, then the bytes. */
function payload(...bytes: number[]): Uint8Array {
  return Uint8Array.from([0, 1, 0, 0, ...bytes]);
}

test("a schema names fields, sequences, fixed arrays and nested types", () => {
  const schema = parseSchema(
    "# comment\nuint8 DEBUG=1\nbuiltin_interfaces/Time stamp # trailing\nint16[] data\nfloat64[3] three\nstring<=10 name\n" +
      "================================================================================\n" +
      "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
  );
  assert.deepEqual(
    schema.fields.map((field) => [field.name, field.array]),
    [["stamp", false], ["data", true], ["three", 3], ["name", false]],
  );
  assert.deepEqual(schema.fields[0].type, {
    fields: [{ name: "sec", type: "int32", array: false }, { name: "nanosec", type: "uint32", array: false }],
  });
});

test("a schema with an unknown type is refused by its name", () => {
  assert.throws(() => parseSchema("pkg/Unknown field"), /unknown type pkg\/Unknown/);
  assert.throws(() => parseSchema("uint8"), /cannot read "uint8"/);
});

test("scalars are aligned to their size from the start of the body", () => {
  const schema = parseSchema("uint8 a\nint32 b\nuint8 c\nuint64 d\n");
  // a at 0, b at 4 (-2), c at 8, d at 16 (2^40)
  const message = decodeCdr(schema, payload(7, 0, 0, 0, 0xfe, 0xff, 0xff, 0xff, 9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0));
  assert.deepEqual(message, { a: 7, b: -2, c: 9, d: 1n << 40n });
});

test("sequences of numbers are typed arrays, and an empty one takes only its length", () => {
  const schema = parseSchema("uint64[] none\nint16[] some\nuint8 end\n");
  const message = decodeCdr(schema, payload(0, 0, 0, 0, 2, 0, 0, 0, 0xff, 0xff, 3, 0, 5));
  assert.deepEqual(message["none"], new BigUint64Array());
  assert.deepEqual(message["some"], Int16Array.from([-1, 3]));
  assert.equal(message["end"], 5);
});

test("a sequence of 64-bit numbers is aligned to 8 after its length", () => {
  const schema = parseSchema("uint64[] ticks");
  const message = decodeCdr(schema, payload(1, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0));
  assert.deepEqual(message["ticks"], BigUint64Array.from([5n]));
});

test("a string ends before its zero and is read as UTF-8", () => {
  const schema = parseSchema("string name\nuint8 end");
  const message = decodeCdr(schema, payload(4, 0, 0, 0, 0xe8, 0xbd, 0xb4, 0, 1));
  assert.deepEqual(message, { name: "轴", end: 1 });
});

test("a message that is shorter than its schema is refused", () => {
  assert.throws(() => decodeCdr(parseSchema("uint32[] data"), payload(255, 255, 255, 255)), /bytes wanted/);
  assert.throws(() => decodeCdr(parseSchema("string[] data"), payload(255, 255, 255, 255)), /bytes wanted/);
  assert.throws(() => decodeCdr(parseSchema("uint8 a"), Uint8Array.from([0, 1])), /little-endian/);
  assert.throws(() => decodeCdr(parseSchema("uint8 a"), Uint8Array.from([0, 0, 0, 0, 1])), /little-endian/);
});
