// SPDX-License-Identifier: Apache-2.0
// Drives three nodes with the CANopen master of the package `canopen` (Daxbot/node-canopen).
//
//   node judge.mjs HOST PORT SHEETS CLOCK OUTPUT
//
// SHEETS: a directory with the DCF of each node, node1.dcf and so on. CLOCK: realtime, or lockstep,
// where each SYNC lets 10 ms pass. OUTPUT: a file for one JSON object {"sent": [[id, hex]],
// "received": [[id, hex]]} with all frames of this master and of its nodes, in order. Exit code 0:
// all expectations were met.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { setTimeout as sleep } from "node:timers/promises";

import canopen from "canopen";

import { SocketcandClient } from "./socketcand.mjs";

const { AccessType, DataType, Device, Eds, NmtState, ObjectType } = canopen;

const NODES = [1, 2, 3];
const PERIOD = 10; // [ms] of SYNC
const PATIENCE = 60_000; // [ms] of wall-clock time, generous for busy machines
const [host, port, folder, clock, output] = process.argv.slice(2);

const log = { sent: [], received: [] };
const boots = new Map(NODES.map((node) => [node, 0]));
const samples = new Map(NODES.map((node) => [node, 0])); // TPDO1 received
const emergencies = [];

function fail(error) {
  console.error(error?.stack ?? String(error));
  process.exit(1);
}

const bus = await SocketcandClient.connect(host, Number(port));
bus.on("close", fail);

const device = new Device({ id: 0x7e });
device.eds.setSyncCobId(0x80);
device.eds.setSyncGenerationEnable(true);
const sheets = new Map(NODES.map((node) => [node, Eds.fromFile(path.join(folder, `node${node}.dcf`))]));
for (const node of NODES) {
  device.mapRemoteNode({ id: node, eds: sheets.get(node), skipPdo: true });
  device.eds.addHeartbeatConsumer(node, 60_000);
}
device.on("message", ({ id, data }) => {
  log.sent.push([id, data.toString("hex")]);
  bus.send(id, data);
});
bus.on("frame", ({ id, data }) => {
  log.received.push([id, data.toString("hex")]);
  const node = id & 0x7f;
  if ((id & 0x780) === 0x700 && data[0] === 0) boots.set(node, boots.get(node) + 1);
  if ((id & 0x780) === 0x180) samples.set(node, samples.get(node) + 1);
  device.receive({ id, data, len: data.length });
});
device.emcy.on("emergency", ({ cobId, em }) => emergencies.push([cobId, em.code]));
device.start();
device.nmt.startNode(); // the master itself: its PDOs work only in this state

// Time.

function read(node, index, subIndex, dataType) {
  return device.sdo.upload({ deviceId: node, index, subIndex, dataType, timeout: PATIENCE });
}

function write(node, index, subIndex, data, dataType) {
  return device.sdo.download({ deviceId: node, index, subIndex, data, dataType, timeout: PATIENCE });
}

async function refusal(promise) {
  const error = await promise.then(() => undefined, (reason) => reason);
  assert.ok(error, "a request that has to be refused was accepted");
  return error.code;
}

let syncTimer; // in realtime
const beforeSync = []; // sent before each SYNC

function sync() {
  for (const act of beforeSync) act();
  device.sync.write();
}

/** Waits for one period. In lock-step, SYNC lets it pass; node `fence` answers after all effects of SYNC. */
async function pass(fence = 3) {
  if (clock === "realtime") return sleep(PERIOD);
  sync();
  if (fence) await read(fence, 0x1001, 0, DataType.UNSIGNED8);
  else await sleep(2);
}

async function until(condition, what, fence = 3) {
  const end = Date.now() + PATIENCE;
  while (!(await condition())) {
    if (Date.now() > end) throw new Error(`${what} did not come true`);
    await pass(fence);
  }
}

// 1. The data sheet, and every object in it.

const SIZES = new Map([
  [DataType.INTEGER8, 1],
  [DataType.UNSIGNED8, 1],
  [DataType.INTEGER16, 2],
  [DataType.UNSIGNED16, 2],
  [DataType.INTEGER32, 4],
  [DataType.UNSIGNED32, 4],
]);

function objectsOf(eds) {
  const objects = [];
  for (const entry of eds.values()) {
    if (!entry.subNumber) {
      objects.push([entry.index, 0, entry]);
      continue;
    }
    for (let sub = 0; sub <= entry[0].value; ++sub) {
      if (entry.at(sub)) objects.push([entry.index, sub, entry.at(sub)]);
    }
  }
  return objects;
}

async function checkObjects(node, eds) {
  const objects = objectsOf(eds);
  assert.ok(objects.length > 150, `only ${objects.length} objects`);
  for (const [index, sub, object] of objects) {
    const name = `${index.toString(16)}h:${sub}`;
    if (object.accessType === AccessType.WRITE_ONLY) continue;
    const raw = await read(node, index, sub).catch((error) => {
      // The error history may answer that it has no such entry.
      assert.equal(`${index.toString(16)}: ${error.code}`, `1003: ${0x08000024}`, name);
    });
    if (!raw) continue;
    const size = SIZES.get(object.dataType);
    if (size) assert.equal(raw.length, size, name);
    else assert.ok(raw.length > 0, name);
    if (size && object.accessType === AccessType.CONSTANT) assert.deepEqual(raw, object.raw, name);
    if (object.accessType !== AccessType.READ_WRITE && object.accessType !== "rww") {
      const code = await refusal(write(node, index, sub, Buffer.alloc(size ?? 1), object.dataType));
      assert.equal(code, 0x06010002, name); // attempt to write a read-only object
    }
  }
  return objects.length;
}

async function checkSheet() {
  for (const [node, eds] of sheets) {
    const [transmit, receive] = [eds.getTransmitPdos(), eds.getReceivePdos()];
    const ofNode = (cobIds) => cobIds.map((cobId) => cobId + node);
    assert.deepEqual(transmit.map((pdo) => pdo.cobId), ofNode([0x180, 0x280, 0x380, 0x480]));
    assert.deepEqual(receive.map((pdo) => pdo.cobId), ofNode([0x200, 0x300, 0x400, 0x500]));
    assert.deepEqual(transmit[2].dataObjects.map((object) => object.index), [0x6041, 0x6064]);
    assert.equal(eds.getEmcyCobId(), 0x80 + node);
  }
  const eds = sheets.get(1);
  console.log(`${await checkObjects(1, eds)} objects have the size and access of the data sheet`);
  assert.equal(await read(1, 0x1008, 0, DataType.VISIBLE_STRING), eds.getEntry(0x1008).value);
  assert.equal(await refusal(read(1, 0x5fff, 0)), 0x06020000);
  assert.equal(await refusal(read(1, 0x1018, 9)), 0x06090011);
}

// 2. Boot-up, heartbeat, mapping.

async function bootAll() {
  for (const node of NODES) device.nmt.resetNode(node);
  await until(() => NODES.every((node) => boots.get(node) === 1), "the boot-up of each node", 0);
  for (const node of NODES) await write(node, 0x1017, 0, 200, DataType.UNSIGNED16);
  const isPreOperational = (node) => device.nmt.consumers[node].state === NmtState.PRE_OPERATIONAL;
  await until(() => NODES.every(isPreOperational), "the heartbeats");
}

const OBJECTS = {
  controlword: [0x6040, DataType.UNSIGNED16],
  target: [0x607a, DataType.INTEGER32],
  mode: [0x6060, DataType.INTEGER8],
  statusword: [0x6041, DataType.UNSIGNED16],
  position: [0x6064, DataType.INTEGER32],
  modeDisplay: [0x6061, DataType.INTEGER8],
};
const RECEIVE = ["controlword", "target", "mode"];
const TRANSMIT = ["statusword", "position", "modeDisplay"];
const images = new Map(); // of each node: its process image in this master

async function remap(node, communication, cobId, names, transmission) {
  const mapping = communication + 0x200;
  await write(node, communication, 1, (0x80000000 | cobId) >>> 0, DataType.UNSIGNED32);
  await write(node, communication, 2, transmission, DataType.UNSIGNED8);
  await write(node, mapping, 0, 0, DataType.UNSIGNED8);
  for (const [place, name] of names.entries()) {
    const [index, type] = OBJECTS[name];
    await write(node, mapping, place + 1, index * 0x10000 + 8 * SIZES.get(type), DataType.UNSIGNED32);
  }
  await write(node, mapping, 0, names.length, DataType.UNSIGNED8);
  await write(node, communication, 1, cobId, DataType.UNSIGNED32);
}

function addImage(node) {
  const image = {};
  for (const [place, [name, [, dataType]]] of Object.entries(OBJECTS).entries()) {
    image[name] = device.eds.addEntry(0x5000 + node * 0x10 + place, {
      parameterName: `${name} of node ${node}`,
      objectType: ObjectType.VAR,
      dataType,
      accessType: AccessType.READ_WRITE,
    });
  }
  const map = (names) => names.map((name) => image[name]);
  device.eds.addTransmitPdo({ cobId: 0x200 + node, transmissionType: 255, dataObjects: map(RECEIVE) });
  device.eds.addReceivePdo({ cobId: 0x180 + node, transmissionType: 1, dataObjects: map(TRANSMIT) });
  images.set(node, image);
}

function command(node, values) {
  for (const [name, value] of Object.entries(values)) images.get(node)[name].value = value;
  device.pdo.write(0x200 + node);
}

const status = (node) => images.get(node).statusword.value;
const position = (node) => images.get(node).position.value;

async function mapAll() {
  // A mapping cannot be changed while its PDO is valid.
  assert.equal(await refusal(write(1, 0x1a00, 1, 0x60640020, DataType.UNSIGNED32)), 0x06010000);
  for (const node of NODES) {
    addImage(node);
    await remap(node, 0x1400, 0x200 + node, RECEIVE, 255);
    await remap(node, 0x1800, 0x180 + node, TRANSMIT, 1);
    device.nmt.startNode(node);
  }
  if (clock === "realtime") syncTimer = setInterval(sync, PERIOD);
  const isOperational = (node) => device.nmt.consumers[node].state === NmtState.OPERATIONAL;
  await until(() => NODES.every(isOperational), "the nodes' operational state");
  await until(() => NODES.every((node) => samples.get(node) > 1), "the TPDOs");
}

// 3. Profile position mode, by SDO and by PDO.

const statusBySdo = (node) => read(node, 0x6041, 0, DataType.UNSIGNED16);
const setControlword = (node, word) => write(node, 0x6040, 0, word, DataType.UNSIGNED16);

const ENABLING = [
  [0x06, 0x6f, 0x21],
  [0x07, 0x6f, 0x23],
  [0x0f, 0x6f, 0x27],
];

async function enableBySdo(node, mode) {
  await write(node, 0x6060, 0, mode, DataType.INTEGER8);
  for (const [word, mask, bits] of ENABLING) {
    await setControlword(node, word);
    await until(async () => ((await statusBySdo(node)) & mask) === bits, `6041h behind word ${word}`);
  }
  await until(async () => (await read(node, 0x6061, 0, DataType.INTEGER8)) === mode, "6061h");
}

async function startMoveBySdo(node, target) {
  await write(node, 0x607a, 0, target, DataType.INTEGER32);
  await setControlword(node, 0x1f);
  await until(async () => (await statusBySdo(node)) & 0x1000, "set-point acknowledge");
  await setControlword(node, 0x0f);
}

async function moveBySdo() {
  await enableBySdo(1, 1);
  await startMoveBySdo(1, 12_000);
  await until(async () => (await statusBySdo(1)) & 0x0400, "target reached");
  assert.equal(await read(1, 0x6064, 0, DataType.INTEGER32), 12_000);
}

async function enableByPdo(node, mode) {
  command(node, { mode, target: position(node) });
  for (const [word, mask, bits] of ENABLING) {
    command(node, { controlword: word });
    await until(() => (status(node) & mask) === bits, `6041h behind word ${word}`);
  }
  await until(() => images.get(node).modeDisplay.value === mode, "6061h");
}

async function moveByPdo() {
  await enableByPdo(2, 1);
  command(2, { target: -7000, controlword: 0x1f });
  await until(() => status(2) & 0x1000, "set-point acknowledge");
  command(2, { controlword: 0x0f });
  await until(() => status(2) & 0x0400 && position(2) === -7000, "target reached");
}

// 4. Cyclic synchronous position mode: all nodes by SYNC at 100 Hz, 60C2h = 10 ms.

async function stream() {
  const cycles = 200;
  const amplitude = 8000;
  const begin = new Map();
  const walked = new Map(NODES.map((node) => [node, []]));
  for (const node of NODES) {
    await write(node, 0x60c2, 1, PERIOD, DataType.UNSIGNED8);
    await write(node, 0x60c2, 2, -3, DataType.INTEGER8);
    command(node, { controlword: 0x06 }); // node 1 was enabled by SDO
    await until(() => (status(node) & 0x6f) === 0x21, "ready to switch on");
    await enableByPdo(node, 8);
    begin.set(node, position(node));
  }
  let cycle = 0;
  const target = (node) => {
    const phase = (2 * Math.PI * cycle) / cycles;
    return begin.get(node) + Math.round((amplitude * node * (1 - Math.cos(phase))) / 6);
  };
  beforeSync.push(() => {
    if (cycle < cycles) cycle += 1;
    for (const node of NODES) {
      walked.get(node).push(position(node));
      command(node, { target: target(node) });
    }
  });
  await until(() => cycle === cycles, "the stream");
  const isBack = (node) => Math.abs(position(node) - begin.get(node)) <= 20;
  await until(() => NODES.every(isBack), "the end of the stream");
  beforeSync.length = 0;
  for (const node of NODES) {
    assert.equal(status(node) & 0x6f, 0x27, `node ${node}`);
    if (clock === "realtime") continue; // because a busy machine delays SYNC and samples
    const places = walked.get(node);
    const steps = places.slice(1).map((value, before) => Math.abs(value - places[before]));
    const widest = Math.max(...places.map((value) => Math.abs(value - begin.get(node))));
    // The path's peak is amplitude * node / 3, its steepest step amplitude * node / 6 * 2 pi /
    // cycles: 126 UU for node 3. Anything well above that is a jump.
    const steepest = (amplitude * node * Math.PI) / 3 / cycles;
    assert.ok(Math.max(...steps) < 1.5 * steepest, `node ${node} jumped by ${Math.max(...steps)}`);
    assert.ok(Math.abs(widest - (amplitude * node) / 3) < 200, `node ${node} went ${widest}`);
  }
  console.log(`${cycles} set-points of 3 nodes were followed`);
}

// 5. Homing by the index pulse.

async function home() {
  await write(3, 0x6098, 0, 34, DataType.INTEGER8);
  command(3, { mode: 6, controlword: 0x0f });
  await until(() => images.get(3).modeDisplay.value === 6, "6061h = 6");
  command(3, { controlword: 0x1f });
  await until(() => (status(3) & 0x1400) === 0x1400, "homing attained");
  assert.equal(status(3) & 0x2000, 0);
  await until(() => position(3) === 0, "6064h = 0"); // the servo settles within the window 6067h
}

// 6. A blocked load: an emergency, the fault, its reset.

async function meetFault() {
  command(1, { mode: 1 });
  await until(() => images.get(1).modeDisplay.value === 1, "6061h = 1");
  await write(1, 0x5e01, 0, 1, DataType.UNSIGNED8);
  await startMoveBySdo(1, 200_000);
  await until(() => emergencies.some(([id, code]) => id === 0x81 && code === 0x8611), "EMCY 8611h");
  await until(() => (status(1) & 0x4f) === 0x08, "fault");
  assert.equal(await read(1, 0x603f, 0, DataType.UNSIGNED16), 0x8611);
  assert.notEqual(await read(1, 0x1001, 0, DataType.UNSIGNED8), 0);
  assert.equal((await read(1, 0x1003, 1, DataType.UNSIGNED32)) & 0xffff, 0x8611);
  await write(1, 0x5e01, 0, 0, DataType.UNSIGNED8);
  command(1, { controlword: 0x00 });
  await pass();
  command(1, { controlword: 0x80 });
  await until(() => (status(1) & 0x4f) === 0x40, "switch on disabled");
  await until(() => emergencies.at(-1)[0] === 0x81 && emergencies.at(-1)[1] === 0, "EMCY 0000h, error reset");
  assert.equal(await read(1, 0x1001, 0, DataType.UNSIGNED8), 0);
}

// 7. Resets restore the defaults.

async function reset() {
  device.nmt.resetNode(1);
  device.nmt.resetCommunication(2);
  await until(() => boots.get(1) === 2 && boots.get(2) === 2, "the boot-ups");
  for (const node of [1, 2]) {
    assert.equal(await read(node, 0x1a00, 0, DataType.UNSIGNED8), 1);
    assert.equal(await read(node, 0x1a00, 1, DataType.UNSIGNED32), 0x60410010);
    assert.equal(await read(node, 0x1017, 0, DataType.UNSIGNED16), 0);
  }
  await until(async () => ((await statusBySdo(1)) & 0x4f) === 0x40, "switch on disabled");
}

try {
  await bootAll();
  await checkSheet();
  await mapAll();
  await moveBySdo();
  await moveByPdo();
  await stream();
  await home();
  await meetFault();
  await reset();
  clearInterval(syncTimer);
  for (const node of NODES) device.nmt.stopNode(node);
  await sleep(300);
  fs.writeFileSync(output, JSON.stringify(log));
  process.exit(0);
} catch (error) {
  fail(error);
}
