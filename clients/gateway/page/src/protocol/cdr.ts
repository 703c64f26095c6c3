// SPDX-License-Identifier: Apache-2.0
// CDR version 1, little-endian. Arrays of numbers become typed arrays over one copy of the message, so that 1,024 axes
// can arrive 60 times a second.

import type { Definition, Field, Primitive } from "./schema";

export type NumberArray =
  | Int8Array
  | Uint8Array
  | Int16Array
  | Uint16Array
  | Int32Array
  | Uint32Array
  | BigInt64Array
  | BigUint64Array
  | Float32Array
  | Float64Array;
export type Value = number | bigint | boolean | string | NumberArray | Message | Value[];
export interface Message {
  [field: string]: Value;
}

type ArrayMaker = {
  new (buffer: ArrayBuffer, offset: number, length: number): NumberArray;
  BYTES_PER_ELEMENT: number;
};
const ARRAYS: Record<Exclude<Primitive, "string">, ArrayMaker> = {
  bool: Uint8Array,
  int8: Int8Array,
  uint8: Uint8Array,
  int16: Int16Array,
  uint16: Uint16Array,
  int32: Int32Array,
  uint32: Uint32Array,
  int64: BigInt64Array,
  uint64: BigUint64Array,
  float32: Float32Array,
  float64: Float64Array,
};
const ENCAPSULATION = 4;
const CDR_LITTLE_ENDIAN = 1;
const text = new TextDecoder();

class Reader {
  private offset = 0;
  private readonly view: DataView;

  constructor(private readonly body: ArrayBuffer) {
    this.view = new DataView(body);
  }

  message(definition: Definition): Message {
    const made: Message = {};
    for (const field of definition.fields) made[field.name] = this.field(field);
    return made;
  }

  private field(field: Field): Value {
    if (field.array === false) return this.one(field.type);
    const length = field.array === true ? this.length() : field.array;
    if (typeof field.type === "string" && field.type !== "string") {
      return this.numbers(field.type, length);
    }
    // Each element has at least one byte, so a length beyond the message is refused before it is used.
    this.need(length);
    const made: Value[] = [];
    for (let i = 0; i < length; ++i) made.push(this.one(field.type));
    return made;
  }

  private one(type: Primitive | Definition): Value {
    if (typeof type !== "string") return this.message(type);
    if (type === "string") return this.string();
    const size = ARRAYS[type].BYTES_PER_ELEMENT;
    this.align(size);
    this.need(size);
    const at = this.offset;
    this.offset += size;
    switch (type) {
      case "bool":
        return this.view.getUint8(at) !== 0;
      case "int8":
        return this.view.getInt8(at);
      case "uint8":
        return this.view.getUint8(at);
      case "int16":
        return this.view.getInt16(at, true);
      case "uint16":
        return this.view.getUint16(at, true);
      case "int32":
        return this.view.getInt32(at, true);
      case "uint32":
        return this.view.getUint32(at, true);
      case "int64":
        return this.view.getBigInt64(at, true);
      case "uint64":
        return this.view.getBigUint64(at, true);
      case "float32":
        return this.view.getFloat32(at, true);
      case "float64":
        return this.view.getFloat64(at, true);
    }
  }

  private numbers(type: Exclude<Primitive, "string">, length: number): NumberArray {
    const maker = ARRAYS[type];
    if (length === 0) return new maker(new ArrayBuffer(0), 0, 0);
    this.align(maker.BYTES_PER_ELEMENT);
    this.need(length * maker.BYTES_PER_ELEMENT);
    const made = new maker(this.body, this.offset, length);
    this.offset += length * maker.BYTES_PER_ELEMENT;
    return made;
  }

  private string(): string {
    const length = this.length();
    this.need(length);
    const made = text.decode(new Uint8Array(this.body, this.offset, Math.max(0, length - 1)));
    this.offset += length;
    return made;
  }

  private length(): number {
    this.align(4);
    this.need(4);
    const made = this.view.getUint32(this.offset, true);
    this.offset += 4;
    return made;
  }

  private align(size: number): void {
    this.offset = Math.ceil(this.offset / size) * size;
  }

  private need(bytes: number): void {
    if (this.offset + bytes > this.body.byteLength) {
      throw new Error(`message: ${bytes} bytes wanted at ${this.offset} of ${this.body.byteLength}`);
    }
  }
}

/** @param payload with the four bytes of the encapsulation; not a Buffer of Node.js, whose slice() does not copy
 *  @throws Error if the payload is shorter than its definition, or is not little-endian CDR. */
export function decodeCdr(definition: Definition, payload: Uint8Array): Message {
  if (payload.byteLength < ENCAPSULATION || payload[1] !== CDR_LITTLE_ENDIAN) {
    throw new Error("message: not CDR in little-endian order");
  }
  // One copy, because typed arrays need alignment from the start of a buffer.
  const body = payload.slice(ENCAPSULATION);
  return new Reader(body.buffer).message(definition);
}
