// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { McapWriter } from "@mcap/core";
import type { Recorded } from "../src/data/recorded";
import { CsvReader } from "../src/data/recorded_csv";
import { McapReader } from "../src/data/recorded_mcap";
import { recordedAxisOf } from "../src/data/recorded_window";

const HEADS = "axis,name,tick,missed,ds402_statusword,load_position_actual_value,owner,owner_epoch,unit,unit_size,position_in_unit,velocity_in_unit";
const row = (axis: string, tick: number, position: number, missed = 0) => `${axis},lift,${tick},${missed},592,${position},,0,deg,4096,0,0\n`;

function readCsv(...parts: string[]): Recorded {
  const reader = new CsvReader();
  for (const part of parts) reader.append(part);
  return reader.finish();
}

const positions = ({ axes, period }: Recorded, place = 0) => {
  const samples = axes[place].finish(period);
  const series = samples.series("load_position_actual_value") ?? -1;
  return Array.from({ length: samples.history.end }, (_, n) => samples.history.value(series, n));
};

test("rows of CSV become the samples of their axes, wherever the text was divided", () => {
  const text = `${HEADS}\n${row("1.1", 100, 7)}${row("1.2", 100, -8)}${row("1.1", 101, 9)}`;
  for (let place = 0; place < text.length; ++place) {
    const recorded = readCsv(text.slice(0, place), text.slice(place));
    assert.equal(recorded.cut, "");
    assert.deepEqual(recorded.axes.map(({ address, name, unit }) => [address, name, unit]), [
      ["1.1", "lift", { kind: "rotary", name: "deg", per: 4096 }],
      ["1.2", "lift", { kind: "rotary", name: "deg", per: 4096 }],
    ]);
    assert.deepEqual(positions(recorded), [7, 9]);
  }
});

test("missing samples are counted and are a gap", () => {
  const recorded = readCsv(`${HEADS}\n${row("1.1", 100, 1)}${row("1.1", 104, 2, 3)}`);
  const samples = recorded.axes[0].finish(recorded.period);
  assert.equal(samples.lost, 3);
  assert.deepEqual(samples.history.points(0, 1, 100, [samples.series("load_position_actual_value") ?? -1]).y[0], [1, null, 2]);
});

test("CSV that is cut is shown up to its last whole line, and says where it ends", () => {
  const recorded = readCsv(`${HEADS}\n${row("1.1", 100, 1)}${row("1.1", 101, 2).slice(0, 20)}`);
  assert.match(recorded.cut, /^line 3 is incomplete/);
  assert.deepEqual(positions(recorded), [1]);
});

for (const [what, text, reason] of [
  ["another table", "time,speed\n1,2\n", /^line 1: no column axis, tick, ds402_statusword/],
  ["a text", `${HEADS}\n${row("1.1", 100, 1)}${row("1.1", 101, 2).replace("592", "abc")}`, /^line 3: ds402_statusword "abc" is not a whole number/],
  ["a fraction", `${HEADS}\n${row("1.1", 100, 1.5)}`, /^line 2: load_position_actual_value "1.5" is not a whole number/],
  ["a value out of range", `${HEADS}\n${row("1.1", 100, 2 ** 31)}`, /^line 2: load_position_actual_value "2147483648" is out of range/],
  ["a short line", `${HEADS}\n1.1,lift,100\n`, /^line 2: 3 columns instead of 12/],
  ["a tick twice", `${HEADS}\n${row("1.1", 100, 1)}${row("1.1", 100, 2)}`, /^line 3: tick 100 of axis 1.1 comes after tick 100/],
  ["no axis", `${HEADS}\n${row("lift", 100, 1)}`, /^line 2: axis "lift" is not an address such as 1\.2/],
  ["heads alone", `${HEADS}\n`, /no sample/],
  ["nothing", "", /empty/],
] as const) {
  test(`CSV with ${what} is refused with the line`, () => {
    assert.throws(() => readCsv(text), { message: reason });
  });
}

const SCHEMA = "builtin_interfaces/Time stamp\nuint64 tick\nint32 load_position_actual_value\nuint16 ds402_statusword\nuint64 owner_session\n";

/** CDR of SCHEMA: int32, uint32, uint64, int32, uint16, uint64 with their alignments. */
function status(tick: number, position: number): Uint8Array {
  const view = new DataView(new ArrayBuffer(4 + 32));
  view.setUint8(1, 1);
  view.setBigUint64(4 + 8, BigInt(tick), true);
  view.setInt32(4 + 16, position, true);
  view.setUint16(4 + 20, 0x0250, true);
  return new Uint8Array(view.buffer);
}

async function recording(): Promise<Uint8Array> {
  const parts: Uint8Array[] = [];
  let length = 0n;
  const writable = {
    position: () => length,
    write: (bytes: Uint8Array) => {
      parts.push(bytes.slice());
      length += BigInt(bytes.byteLength);
      return Promise.resolve();
    },
  };
  const writer = new McapWriter({ writable, chunkSize: 100 });
  await writer.start({ profile: "", library: "" });
  const schemaId = await writer.registerSchema({ name: "vdrive_msgs/msg/AxisStatus", encoding: "ros2msg", data: new TextEncoder().encode(SCHEMA) });
  await writer.addMetadata({
    name: "vdrive.bench",
    metadata: new Map([["bench", "3"], ["period_ns", "500000"], ["axis.7", "z axis"], ["unit.7", "mm"], ["unit_size.7", "1000"]]),
  });
  await writer.addMetadata({ name: "vdrive.gaps", metadata: new Map([["3:104", "2"]]) });
  const channelId = await writer.registerChannel({ topic: "/bench3/z_axis/status", schemaId, messageEncoding: "cdr", metadata: new Map([["axis", "7"]]) });
  for (const [sequence, tick] of [100, 101, 104, 105].entries()) {
    await writer.addMessage({ channelId, sequence, logTime: BigInt(tick) * 500_000n, publishTime: 0n, data: status(tick, tick * 10) });
  }
  await writer.end();
  return Buffer.concat(parts);
}

function readMcap(bytes: Uint8Array, part = bytes.length): Recorded {
  const reader = new McapReader();
  for (let at = 0; at < bytes.length; at += part) reader.append(bytes.subarray(at, at + part));
  return reader.finish();
}

test("a recording in MCAP has axes, units, period and gaps", async () => {
  const recorded = readMcap(await recording(), 37);
  assert.equal(recorded.cut, "");
  assert.deepEqual([recorded.axes[0].address, recorded.axes[0].name, recorded.axes[0].unit], ["3.7", "z axis", { kind: "linear", name: "mm", per: 1000 }]);
  const samples = recorded.axes[0].finish(recorded.period);
  assert.equal(samples.lost, 2);
  assert.equal(samples.end, 105 * 0.0005);
  assert.deepEqual(samples.members, ["load_position_actual_value", "ds402_statusword"]);
});

test("MCAP that is cut anywhere is shown up to its last whole chunk, or has no sample yet", async () => {
  const bytes = await recording();
  let shown = 0;
  for (let length = 1; length < bytes.length; ++length) {
    try {
      const recorded = readMcap(bytes.subarray(0, length));
      assert.match(recorded.cut, new RegExp(`^the file is truncated: it ends at byte ${length}, within a record that begins at byte \\d+`));
      const found = positions(recorded);
      assert.ok(found.length >= shown, "no sample is lost again");
      shown = found.length;
    } catch (error) {
      assert.match((error as Error).message, /^it contains no axis status/);
      assert.equal(shown, 0);
    }
  }
  assert.equal(shown, 4);
});

test("what is no MCAP, or damaged, is named with its byte", async () => {
  assert.throws(() => readMcap(new TextEncoder().encode("no recording of anything")), { message: /^byte 0: .*MCAP/ });
  const bytes = (await recording()).slice();
  // The second chunk: its CRC no longer matches.
  const place = Buffer.from(bytes).indexOf(Buffer.from(status(104, 1040).subarray(12, 24)));
  bytes[place] ^= 1;
  const recorded = readMcap(bytes);
  assert.match(recorded.cut, /^byte \d+: .*CRC/);
  assert.ok(positions(recorded).length > 0);
});

test("an axis of a window has a sample for each tick, and lists of different lengths are refused", () => {
  const axis = { address: "1.2", bench: 1, axis: 2, name: "lift", unit: undefined };
  const window = (position: unknown) => recordedAxisOf(axis, { tick: [100, 101, 105], load_position_actual_value: position });
  const recorded = { axes: [window([7, -8, 9])], events: [], period: 0.001, cut: "" };
  assert.deepEqual([recorded.axes[0].first, recorded.axes[0].last], [100, 105]);
  assert.deepEqual(positions(recorded), [7, -8, 9]);
  assert.throws(() => window([7, -8]), /2 values of load_position_actual_value for 3 ticks/);
  assert.throws(() => window("7"), /load_position_actual_value/);
});
