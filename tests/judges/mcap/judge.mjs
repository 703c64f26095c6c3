// SPDX-License-Identifier: Apache-2.0
// Reads an MCAP recording with the readers published by its authors, and with Foxglove's decoder.
//
//   node judge.mjs FILE CUTS SEED
//
// Standard output: one JSON object: {"rows": [{member: value}], "topics": {topic: messages}, ...}.
// Reads the complete file as a stream, with the checksums of its chunks, data and summary; then
// through its indexes, which must lead to the same messages; then truncated at CUTS places
// determined by SEED, where the messages found must be the first ones of the complete file. Exit
// code 0: all of that holds.
import rosmsg from "@foxglove/rosmsg";
import serialization from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";
import { open, readFile } from "node:fs/promises";

const { parse } = rosmsg;
const { MessageReader } = serialization;
const [path, cuts, seed] = [process.argv[2], Number(process.argv[3]), Number(process.argv[4])];
const decompressHandlers = {
  zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))),
};

function check(holds, text) {
  if (holds) return;
  console.error(`judge.mjs: ${text}`);
  process.exit(1);
}

/** CRC-32 without any library. */
const table = Array.from({ length: 256 }, (_, byte) => {
  for (let bit = 0; bit < 8; ++bit) byte = byte & 1 ? (byte >>> 1) ^ 0xedb88320 : byte >>> 1;
  return byte >>> 0;
});
function crcOf(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = (crc >>> 8) ^ table[(crc ^ byte) & 0xff];
  return (crc ^ 0xffffffff) >>> 0;
}

function readStream(bytes) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const records = [];
  reader.append(bytes);
  for (let record; (record = reader.nextRecord()); ) records.push(record);
  return { records, done: reader.done(), left: reader.bytesRemaining() };
}

/** The identity of a message. */
function keyOf(message) {
  return `${message.channelId} ${message.sequence} ${message.logTime} ${crcOf(message.data)}`;
}

const bytes = new Uint8Array(await readFile(path));
const whole = readStream(bytes);
check(whole.done && whole.left === 0, "the stream has no end");
const of = (type) => whole.records.filter((record) => record.type === type);
const messages = of("Message");
const [statistics] = of("Statistics");
const [dataEnd] = of("DataEnd");
const [footer] = of("Footer");

// Checksums: the reader has checked those of the chunks; the data and the summary are checked here.
check(of("Statistics").length === 1 && dataEnd && footer, "statistics, data end or footer");
const dataEndAt = Number(footer.summaryStart) - 13;
check(dataEnd.dataSectionCrc === crcOf(bytes.subarray(0, dataEndAt)), "the sum of the data");
const summary = bytes.subarray(Number(footer.summaryStart), bytes.length - 8 - 4);
check(footer.summaryCrc !== 0 && footer.summaryCrc === crcOf(summary), "the sum of the summary");

// Counts.
check(statistics.messageCount === BigInt(messages.length), "the count of messages");
check(statistics.schemaCount === new Set(of("Schema").map((s) => s.id)).size, "schemas");
const channels = new Map(of("Channel").map((channel) => [channel.id, channel]));
check(statistics.channelCount === channels.size, "the count of channels");
check(statistics.chunkCount === of("ChunkIndex").length, "the count of chunks");
check(statistics.metadataCount === of("Metadata").length, "the count of metadata");
check(of("MetadataIndex").length === of("Metadata").length, "indexes of metadata");
const topics = {};
for (const channel of channels.values()) topics[channel.topic] = 0;
let [first, last] = [messages[0].logTime, messages[0].logTime];
for (const message of messages) {
  topics[channels.get(message.channelId).topic] += 1;
  if (message.logTime < first) first = message.logTime;
  if (message.logTime > last) last = message.logTime;
}
check(statistics.messageStartTime === first && statistics.messageEndTime === last, "times");
for (const [id, channel] of channels) {
  const count = Number(statistics.channelMessageCounts.get(id) ?? 0n);
  check(count === topics[channel.topic], `the count of ${channel.topic}`);
}
check(of("SummaryOffset").length === 5, "summary offsets");

// Through its indexes.
const file = await open(path);
const indexed = await McapIndexedReader.Initialize({
  readable: {
    size: async () => BigInt((await file.stat()).size),
    read: async (offset, size) => {
      const buffer = new Uint8Array(Number(size));
      await file.read(buffer, 0, Number(size), Number(offset));
      return buffer;
    },
  },
  decompressHandlers,
});
const found = [];
for await (const message of indexed.readMessages()) found.push(keyOf(message));
check(found.length === messages.length, `${found.length} of ${messages.length} by index`);
const sorted = messages.map(keyOf).sort();
check(found.sort().every((key, place) => key === sorted[place]), "other messages by index");
const metadata = [];
for await (const record of indexed.readMetadata()) metadata.push(record.name);
await file.close();

// Values.
const schemas = new Map(of("Schema").map((schema) => [schema.id, schema]));
const readers = new Map();
for (const [id, channel] of channels) {
  const schema = schemas.get(channel.schemaId);
  check(channel.messageEncoding === "cdr" && schema.encoding === "ros2msg", "encodings");
  const text = new TextDecoder().decode(schema.data);
  readers.set(id, new MessageReader(parse(text, { ros2: true })));
}
const plain = (value) => (typeof value === "bigint" ? String(value) : Number(value));
const rows = [];
const parameters = [];
const events = [];
for (const message of messages) {
  const { topic } = channels.get(message.channelId);
  const content = readers.get(message.channelId).readMessage(message.data);
  if (topic.endsWith("/events")) {
    events.push(content.message);
    continue;
  }
  const { sec, nanosec } = content.stamp ?? content.timestamp;
  check(BigInt(sec) * 1000000000n + BigInt(nanosec) === message.logTime, "a stamp");
  const row = { topic };
  for (const [name, value] of Object.entries(content)) {
    if (name === "stamp") continue;
    row[name] = ArrayBuffer.isView(value) || Array.isArray(value) ? Array.from(value, plain) : plain(value);
  }
  (topic.endsWith("/parameters") ? parameters : rows).push(row);
}

// Truncated.
let state = BigInt(seed);
function random(below) {
  state = (state * 6364136223846793005n + 1442695040888963407n) & 0xffffffffffffffffn;
  return Number((state >> 33n) % BigInt(below));
}
const keys = messages.map(keyOf);
let most = 0;
for (let i = 0; i < cuts; ++i) {
  const size = 8 + random(bytes.length - 8);
  const cut = readStream(bytes.subarray(0, size));
  check(!cut.done, `cut at ${size} it is whole`);
  const read = cut.records.filter((record) => record.type === "Message").map(keyOf);
  check(read.every((key, place) => key === keys[place]), `cut at ${size}, seed ${seed}`);
  most = Math.max(most, read.length);
}
process.stdout.write(
  JSON.stringify({ rows, parameters, events, topics, metadata, most, messages: messages.length }) + "\n",
);
