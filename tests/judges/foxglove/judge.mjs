// SPDX-License-Identifier: Apache-2.0
// Reads a gateway with the client and the decoder published by Foxglove, offering only the old
// sub-protocol, and prints the decoded values.
//
//   node judge.mjs PORT TOPIC LAST_TICK
//
// Standard output: the line "ready" once the first message has arrived; then, after LAST_TICK has
// been seen, one JSON object: {"tick": {member: value}}. Also calls /read and reads a parameter,
// and prints these answers as "read" and "parameter". Exit code 0: everything was received.
import rosmsg from "@foxglove/rosmsg";
import serialization from "@foxglove/rosmsg2-serialization";
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const { parse } = rosmsg;
const { MessageReader } = serialization;
const { FoxgloveClient } = protocol;

const [port, topic, last] = [process.argv[2], process.argv[3], BigInt(process.argv[4])];
const ticks = {};
const result = { ticks };
const readers = new Map();
let service;
let seen = false;
let done = false;
let answers = 0;

const client = new FoxgloveClient({
  ws: new WebSocket(`ws://127.0.0.1:${port}/`, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]),
});

function finish() {
  if (done || !seen || answers < 2) return;
  done = true;
  process.stdout.write(JSON.stringify(result) + "\n", () => process.exit(0));
}

client.on("error", (error) => {
  console.error(String(error?.message ?? error));
  process.exit(1);
});
client.on("advertise", (channels) => {
  for (const channel of channels) {
    if (channel.topic !== topic) continue;
    const reader = new MessageReader(parse(channel.schema, { ros2: true }));
    readers.set(client.subscribe(channel.id), reader);
    client.getParameters([topic.slice(1).replace("/trace", "/0x6502")], "judge");
    client.sendServiceCallRequest({
      serviceId: service.id,
      callId: 1,
      encoding: "json",
      data: new DataView(
        new TextEncoder().encode('{"axis":"1.1","objects":["0x6502"]}').buffer,
      ),
    });
  }
});
client.on("advertiseServices", (services) => {
  service = services.find((candidate) => candidate.name === "/read");
});
client.on("serviceCallResponse", (response) => {
  result.read = JSON.parse(new TextDecoder().decode(response.data));
  answers += 1;
  finish();
});
client.on("parameterValues", ({ parameters }) => {
  result.parameter = parameters[0];
  answers += 1;
  process.stdout.write("ready\n");
  finish();
});
client.on("message", ({ subscriptionId, data }) => {
  const message = readers.get(subscriptionId).readMessage(data);
  message.tick.forEach((tick, place) => {
    const row = {};
    for (const [name, values] of Object.entries(message)) {
      if (["stamp", "axis", "missed", "tick"].includes(name)) continue;
      row[name] = Number(values[place]);
    }
    ticks[String(tick)] = row;
    if (tick >= last) seen = true;
  });
  finish();
});
