// SPDX-License-Identifier: Apache-2.0
// MCAP as written by `vdrive record`: the status of axes or of benches, and events.

import { McapStreamReader, type McapTypes } from "@mcap/core";
import { decompress } from "fzstd";
import { decodeCdr, type Message, type NumberArray } from "../protocol/cdr";
import { parseSchema, type Definition, type Field, type Primitive } from "../protocol/schema";
import type { LogEvent } from "./events";
import { RecordedAxis, recordedUnit, SampleLimit, TooLarge, type Kinds, type Recorded } from "./recorded";

/** A larger chunk is damaged, or was not written by `vdrive record`. */
const MOST_CHUNK_BYTES = 64 * 2 ** 20;
const DEFAULT_PERIOD_NS = 1_000_000;
/** members of a status that are not values of the drive */
const OTHERS = new Set(["tick", "axis", "owner_session", "stamp"]);

const KINDS: Partial<Record<Primitive, new (length: number) => Int8Array | Uint8Array | Int16Array | Uint16Array | Int32Array | Uint32Array>> = {
  bool: Uint8Array,
  int8: Int8Array,
  uint8: Uint8Array,
  int16: Int16Array,
  uint16: Uint16Array,
  int32: Int32Array,
  uint32: Uint32Array,
};

interface Channel {
  bench: number;
  /** number of the axis; 0 = all axes, or events */
  axis: number;
  definition: Definition;
  schema: string;
}

/** The numeric members of a status; in that of a bench they are arrays. */
function kindsOf(fields: readonly Field[]): Kinds {
  const found = new Map<string, NonNullable<(typeof KINDS)[Primitive]>>();
  for (const { name, type } of fields) {
    const kind = typeof type === "string" ? KINDS[type] : undefined;
    if (kind !== undefined && !OTHERS.has(name)) found.set(name, kind);
  }
  return found;
}

function bounded(size: bigint): Uint8Array {
  if (size > MOST_CHUNK_BYTES) throw new Error(`a chunk of ${size} bytes: the limit is ${MOST_CHUNK_BYTES}`);
  return new Uint8Array(Number(size));
}

/** Takes the bytes of a file in pieces. Errors name the byte. */
export class McapReader {
  private readonly reader = new McapStreamReader({
    decompressHandlers: { zstd: (bytes, size) => decompress(bytes, bounded(size)) },
  });
  private readonly schemas = new Map<number, McapTypes.Schema>();
  private readonly channels = new Map<number, Channel>();
  /** by address */
  private readonly axes = new Map<string, RecordedAxis>();
  private readonly names = new Map<string, string>();
  /** address of an axis, such as "1.2", by its bench and its name in topics, such as "1/x" */
  private readonly topics = new Map<string, string>();
  private readonly units = new Map<string, ReturnType<typeof recordedUnit>>();
  /** missing samples before a tick: "bench:tick" */
  private readonly gaps = new Map<string, number>();
  private readonly events: LogEvent[] = [];
  private readonly limit = new SampleLimit();
  private periodNs = DEFAULT_PERIOD_NS;
  private bytes = 0;
  /** offset of the next record */
  private place = 0;
  private cut = "";

  /** In a damaged file, ignores everything after the damage. @throws Error if the file is not a recording */
  append(bytes: Uint8Array): void {
    if (this.cut !== "") return;
    try {
      if (!this.reader.done()) this.reader.append(bytes);
      this.bytes += bytes.byteLength;
      for (let record = this.next(); record !== undefined; record = this.next()) this.take(record);
    } catch (error) {
      const reason = `byte ${this.place}: ${(error as Error).message}`;
      if (this.axes.size === 0 || error instanceof TooLarge) throw new Error(reason);
      this.cut = `${reason}; everything before that is shown`;
    }
  }

  /** @throws Error if nothing can be shown */
  finish(): Recorded {
    if (this.axes.size === 0) throw new Error("it contains no axis status: not a vdrive recording");
    if (this.cut === "" && !this.reader.done()) this.cut = `the file is truncated: it ends at byte ${this.bytes}, within a record that begins at byte ${this.place}; everything before that is shown`;
    const axes = [...this.axes.values()];
    for (const axis of axes) axis.unit = this.units.get(axis.address);
    return { axes, events: this.events, period: this.periodNs * 1e-9, cut: this.cut };
  }

  private next(): McapTypes.TypedMcapRecord | undefined {
    this.place = this.bytes - this.reader.bytesRemaining();
    return this.reader.nextRecord();
  }

  private take(record: McapTypes.TypedMcapRecord): void {
    if (record.type === "Schema") this.schemas.set(record.id, record);
    else if (record.type === "Channel") this.takeChannel(record);
    else if (record.type === "Metadata" && record.name === "vdrive.bench") this.takeBench(record.metadata);
    else if (record.type === "Metadata" && record.name === "vdrive.gaps") {
      for (const [place, count] of record.metadata) this.gaps.set(place, Number(count));
    } else if (record.type === "Message") this.takeMessage(record);
  }

  private takeBench(metadata: Map<string, string>): void {
    const bench = metadata.get("bench") ?? "";
    this.periodNs = Number(metadata.get("period_ns") ?? this.periodNs);
    for (const [key, text] of metadata) {
      const [what, axis] = key.split("."); // unit.1
      if (what === "axis") this.names.set(`${bench}.${axis}`, text);
      const size = Number(metadata.get(`unit_size.${axis}`));
      if (what === "unit" && size > 0) this.units.set(`${bench}.${axis}`, recordedUnit(text, size));
    }
  }

  private takeChannel({ id, topic, schemaId, messageEncoding, metadata }: McapTypes.Channel): void {
    const schema = this.schemas.get(schemaId);
    const [, bench, name] = /^\/bench(\d+)\/(?:(\w+)\/)?(?:status|events)$/.exec(topic) ?? [];
    if (bench === undefined || schema === undefined || messageEncoding !== "cdr") return;
    const definition = parseSchema(new TextDecoder().decode(schema.data));
    const axis = name === undefined ? 0 : this.axisOf(bench, name, metadata);
    this.channels.set(id, { bench: Number(bench), axis, definition, schema: schema.name });
  }

  /** A file recorded by another program identifies its axes only by their topics. */
  private axisOf(bench: string, topic: string, metadata: Map<string, string>): number {
    const axis = Number(metadata.get("axis") ?? this.topics.size + 1);
    const address = `${bench}.${axis}`;
    this.topics.set(`${bench}/${topic}`, address);
    if (!this.names.has(address)) this.names.set(address, metadata.get("name") ?? topic);
    return axis;
  }

  private takeMessage({ channelId, data }: McapTypes.Message): void {
    const channel = this.channels.get(channelId);
    if (channel === undefined) return;
    const message = decodeCdr(channel.definition, data);
    if (channel.schema.endsWith("/AxisStatus")) this.takeAxis(channel, message);
    else if (channel.schema.endsWith("/BenchStatus")) this.takeAxes(channel, message);
    else if (channel.schema.endsWith("Log")) this.takeEvent(channel, message);
  }

  private takeAxis({ bench, axis, definition }: Channel, message: Message): void {
    this.add(bench, axis, definition, Number(message["tick"]), (member) => Number(message[member]));
  }

  private takeAxes({ bench, definition }: Channel, message: Message): void {
    const axes = message["axis"] as NumberArray;
    for (let place = 0; place < axes.length; ++place) {
      const value = (member: string) => Number((message[member] as NumberArray)[place]);
      this.add(bench, Number(axes[place]), definition, Number(message["tick"]), value);
    }
  }

  private add(bench: number, axis: number, { fields }: Definition, tick: number, value: (member: string) => number): void {
    const address = `${bench}.${axis}`;
    let made = this.axes.get(address);
    if (made === undefined) {
      made = new RecordedAxis(address, this.names.get(address) ?? "", kindsOf(fields));
      this.axes.set(address, made);
    }
    this.limit.add();
    made.add(tick, value, this.gaps.get(`${bench}:${tick}`) ?? 0);
  }

  /** @param source the bench, or the bench and its axis: "bench1/x" */
  private axisNamed(bench: number, source: string): number {
    const [, topic] = source.split("/");
    if (topic === undefined) return 0;
    const inTopics = (name: string) => name.replace(/[^A-Za-z0-9]/g, "_");
    const address = this.topics.get(`${bench}/${topic}`) ?? [...this.names].find(([own, name]) => own.startsWith(`${bench}.`) && inTopics(name) === topic)?.[0];
    return Number(address?.split(".")[1] ?? 0);
  }

  private takeEvent({ bench }: Channel, message: Message): void {
    const { sec, nanosec } = message["timestamp"] as { sec: number; nanosec: number };
    const time = sec + nanosec * 1e-9;
    this.events.push({
      bench,
      axis: this.axisNamed(bench, message["name"] as string),
      tick: Math.round((sec * 1e9 + nanosec) / this.periodNs),
      time,
      level: message["level"] as number,
      kind: message["file"] as string,
      message: message["message"] as string,
    });
  }
}
