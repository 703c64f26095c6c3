// SPDX-License-Identifier: Apache-2.0
// A ROS 2 node on the stack published by Foxglove, which is neither Fast DDS nor Cyclone DDS.
//
//   node judge.mjs DOMAIN MESSAGES
//
// Waits for the topic /joint_states, reads the given number of its messages with every field, and
// checks the announcement of the writer. Standard output: the line "first" at the first message,
// and at the end one JSON object {"topic", "dataType", "type", "userData", "messages": [...]}. Exit
// code 0: everything was received.
import rosmsg from "@foxglove/rosmsg";
import ros2 from "@foxglove/ros2";
import nodejs from "@foxglove/ros2/nodejs.js";
import serialization from "@foxglove/rosmsg2-serialization";
import rtps from "@foxglove/rtps";

const { RosNode } = ros2;
const { getNetworkInterfaces, UdpSocketNode } = nodejs;
const [domain, wanted] = [Number(process.argv[2]), Number(process.argv[3])];
const topic = "/joint_states";
const separator = "=".repeat(80);
const definition = rosmsg.parse(
  [
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id",
    "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec",
  ].join(`\n${separator}\n`),
  { ros2: true },
);

const node = new RosNode({
  name: "judge",
  addresses: ["127.0.0.1"],
  domainId: domain,
  udpSocketCreate: UdpSocketNode.Create,
  getNetworkInterfaces,
});
setTimeout(() => {
  console.error("judge: not enough messages in 90 s");
  process.exit(1);
}, 90_000);

const result = { topic: null, type: null, userData: null, messages: [] };
node.on("error", (error) => console.error(String(error)));
node.on("discoveredPublication", (endpoint) => {
  if (endpoint.topicName !== "rt/joint_states") return;
  result.type = endpoint.typeName;
  result.userData = endpoint.userData;
});
await node.start();
// RosNode.subscribe() requests TRANSIENT_LOCAL, but joint states are volatile, as in every ROS
// system; so this uses the next lower layer of the same stack.
const reader = new serialization.MessageReader(definition);
const participant = new rtps.Participant({
  name: "judge",
  addresses: ["127.0.0.1"],
  domainId: domain,
  udpSocketCreate: UdpSocketNode.Create,
});
participant.on("error", (error) => console.error(String(error)));
await participant.start();
participant.subscribe({
  topicName: "rt/joint_states",
  typeName: "sensor_msgs::msg::dds_::JointState_",
  durability: rtps.Durability.Volatile,
  reliability: { kind: rtps.Reliability.Reliable, maxBlockingTime: { sec: 1, nsec: 0 } },
  history: { kind: rtps.HistoryKind.KeepLast, depth: 10 },
});
participant.on("userData", (data) => {
  if (data.subscription.topicName !== "rt/joint_states") return;
  const message = reader.readMessage(data.serializedData);
  if (result.messages.length >= wanted) return;
  if (result.messages.length === 0) process.stdout.write("first\n");
  result.messages.push({
    sec: message.header.stamp.sec,
    nanosec: message.header.stamp.nanosec ?? message.header.stamp.nsec,
    frame_id: message.header.frame_id,
    name: [...message.name],
    position: [...message.position],
    velocity: [...message.velocity],
    effort: [...message.effort],
  });
  if (result.messages.length === wanted) {
    const published = node.getPublishedTopics().find(([name]) => name === topic);
    result.topic = published?.[0];
    result.dataType = published?.[1];
    process.stdout.write(JSON.stringify(result) + "\n", () => process.exit(0));
  }
});
