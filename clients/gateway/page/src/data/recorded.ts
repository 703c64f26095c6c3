// SPDX-License-Identifier: Apache-2.0
// The samples of a recording: collected while the file is read, then turned into the samples of its axes.

import type { Message } from "../protocol/cdr";
import type { LogEvent } from "./events";
import { Samples } from "./samples";
import type { AxisUnit } from "./units";

/** Limit for all axes together: a sample takes some 100 bytes. */
export const MOST_RECORDED_SAMPLES = 4_000_000;
export const MOST_RECORDED_BYTES = 256 * 2 ** 20;
const BLOCK = 4_096;
const ROTARY = ["deg", "rad", "rev"];

type Column = Int8Array | Uint8Array | Int16Array | Uint16Array | Int32Array | Uint32Array | Float64Array;
export type Kinds = ReadonlyMap<string, new (length: number) => Column>;

interface Block {
  ticks: BigUint64Array;
  columns: Map<string, Column>;
  length: number;
  /** missing ticks before it */
  missed: number;
}

/** @return the unit of an axis as stored in a recording */
export function recordedUnit(name: string, size: number): AxisUnit {
  return { kind: ROTARY.includes(name) ? "rotary" : "linear", name, per: size };
}

/** One axis of a recording. */
export class RecordedAxis {
  count = 0;
  private readonly blocks: Block[] = [];
  private missed = 0;
  /** ticks of the first and the last sample; -1 before one was added */
  first = -1;
  last = -1;

  constructor(
    readonly address: string,
    readonly name: string,
    private readonly kinds: Kinds,
    public unit?: AxisUnit,
  ) {}

  /** @param value returns the value of a member
   *  @param missed number of missing samples before this one
   *  @throws Error if the tick is not after the previous one */
  add(tick: number, value: (member: string) => number, missed: number): void {
    if (tick <= this.last) throw new Error(`tick ${tick} of axis ${this.address} comes after tick ${this.last}`);
    this.last = tick;
    if (this.count === 0) this.first = tick;
    this.missed += missed;
    let block = this.blocks.at(-1);
    if (block === undefined || block.length === BLOCK || missed > 0) {
      const columns = new Map([...this.kinds].map(([member, Kind]) => [member, new Kind(BLOCK)]));
      block = { ticks: new BigUint64Array(BLOCK), columns, length: 0, missed: this.missed };
      this.blocks.push(block);
    }
    block.ticks[block.length] = BigInt(tick);
    for (const [member, column] of block.columns) column[block.length] = value(member);
    ++block.length;
    ++this.count;
  }

  /** Moves the samples into the result. @param period [s] of a tick */
  finish(period: number): Samples {
    const [bench, axis] = this.address.split(".").map(Number);
    const { address, name, unit } = this;
    const samples = new Samples({ address, bench, axis, name, unit }, { period, isRegular: true, capacity: this.count, hasControlword: false });
    // `missed` of the first block is the base from which Samples counts later losses.
    for (let block = this.blocks.shift(); block !== undefined; block = this.blocks.shift()) {
      const { length, columns, ticks, missed } = block;
      const message: Message = { tick: ticks.subarray(0, length), missed: BigInt(missed) };
      for (const [member, column] of columns) message[member] = column.subarray(0, length);
      samples.take(message);
    }
    return samples;
  }
}

/** The contents of a recording. */
export interface Recorded {
  axes: RecordedAxis[];
  events: LogEvent[];
  /** [s] of a tick */
  period: number;
  /** why the file is incomplete; "" if it is complete */
  cut: string;
}

/** The file has more than MOST_RECORDED_SAMPLES; nothing of it is shown. */
export class TooLarge extends Error {}

/** Counts the samples of all axes. */
export class SampleLimit {
  private count = 0;

  /** @throws TooLarge beyond MOST_RECORDED_SAMPLES */
  add(): void {
    if (++this.count > MOST_RECORDED_SAMPLES) {
      throw new TooLarge(`more than ${MOST_RECORDED_SAMPLES} samples of all axes: record fewer axes or a shorter time`);
    }
  }
}
