// SPDX-License-Identifier: Apache-2.0
// Runs the package's own tests of SDO and PDO against nodes of this project.
//
//   node own_tests.mjs HOST PORT CLOCK
//
// The files are those of the installed package (Daxbot/node-canopen, test/protocol/test_sdo.js and
// test_pdo.js), unchanged. Their devices are client and server in one, in loopback; here such a
// device sends to the bus, and the node with its node-ID is the server. Instead of the objects that
// the tests create, each case uses one of the node, of the same length if there is one. Prints the
// outcome of each case in a line. CLOCK: realtime, or lockstep, where this program sends SYNC. Exit
// code 0: each case has the outcome listed in CASES, and the files have no other cases.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { setTimeout as sleep } from "node:timers/promises";

import { SocketcandClient } from "./socketcand.mjs";

const require = createRequire(import.meta.url);
const canopen = require("canopen");
const { DataType, Device, SdoError } = canopen;

const NODE = 0xa; // the node-ID in the tests, except those with all nodes
const NODES = 126; // the last one in the tests with all nodes
const PATIENCE = 60_000; // [ms] of wall-clock time, generous for busy machines
const [host, port, clock] = process.argv.slice(2);

// The expected outcome of a case.

/** The transfers access object `index` of the node, and the case passes. */
const passes = (index, subIndex = 0, nodes = 1) => ({ index, subIndex, nodes });
/** The node aborts the first transfer with `code`. */
const refused = (code, reason, index, subIndex = 0) => ({ code, reason, index, subIndex, nodes: 1 });
const alone = { reason: "of the package alone, no frame" };

const WINDOW = 0x6065; // UNSIGNED32, every value
const TYPE = [0x1803, 2]; // UNSIGNED8, transmission type, up to 240
const TOO_LONG = [0x06070012, "no object of the node that is written is longer than 4 bytes"];
const NO_3_BYTES = [0x06070013, "the node has no object of 3 bytes"];
const CONSTANT = [0x06010002, "the texts of the node are constants"];

const EXPEDITED = {
  BOOLEAN: passes(0x5e08), // 0 or 1
  INTEGER8: passes(...TYPE),
  INTEGER16: passes(0x6071),
  INTEGER24: refused(...NO_3_BYTES, WINDOW),
  INTEGER32: passes(0x607c),
  UNSIGNED8: passes(...TYPE),
  UNSIGNED16: passes(0x6068),
  UNSIGNED24: refused(...NO_3_BYTES, WINDOW),
  UNSIGNED32: passes(WINDOW),
  VISIBLE_STRING: passes(WINDOW), // 4 characters
  OCTET_STRING: passes(WINDOW), // 4 bytes
  UNICODE_STRING: passes(0x6068), // 2 bytes
  REAL32: passes(WINDOW),
};
const LONG = [
  ...["INTEGER40", "INTEGER48", "INTEGER64", "UNSIGNED40", "UNSIGNED48", "UNSIGNED64"],
  ...["VISIBLE_STRING", "OCTET_STRING", "UNICODE_STRING", "REAL64", "TIME_OF_DAY", "TIME_DIFFERENCE"],
];

function casesOfSdo() {
  const cases = [
    ["should emit start once", alone],
    ["should emit stop once", alone],
    ["should transfer using the deprecated API", passes(WINDOW)],
  ];
  const add = (group, title, expected) => cases.push([`${group} transfer: should ${title}`, expected]);
  for (const [type, expected] of Object.entries(EXPEDITED)) {
    add("Expediated", `transfer ${type}`, expected);
  }
  add("Expediated", "transfer to any valid node id [1 - 127]", passes(WINDOW, 0, NODES));
  for (const type of LONG) {
    const isText = type === "VISIBLE_STRING";
    const expected = isText ? refused(...CONSTANT, 0x1008) : refused(...TOO_LONG, WINDOW);
    add("Segmented", `transfer ${type}`, expected);
  }
  // The segmented upload comes first and succeeds, but returns the node's text instead of the
  // test's.
  add("Segmented", "transfer subindexes >= 1", { ...passes(0x1008), differs: "vdrive" });
  add("Segmented", "transfer to any valid node id [1 - 127]", refused(...CONSTANT, 0x1008));
  add("Segmented", "handle large transfers", refused(...TOO_LONG, WINDOW));
  for (const [type, expected] of Object.entries(EXPEDITED)) {
    add("Block", `transfer ${type}`, expected);
  }
  for (const type of LONG) add("Block", `transfer ${type}`, refused(...TOO_LONG, WINDOW));
  add("Block", "handle large transfers", refused(...TOO_LONG, WINDOW));
  return cases.map(([title, expected]) => [`Sdo: ${title}`, expected]);
}

// The tests map the dummies 0002h and 0005h, one byte each. Here, RPDO1 of the node is 6060h and
// TPDO1 is 6061h, also one byte each: a value passes through the drive and back.
const CASES_OF_PDO = [
  ["should emit start once", alone],
  ["should emit stop once", alone],
  // The test sends 0; readBack checks the effect on the node.
  ["should produce a PDO object", { mode: 1, readBack: 0, nodes: 1 }],
  ["should emit on consuming a PDO object", { mode: 0, readBack: 1, nodes: 1 }],
  ["should listen to Eds#newTpdo", { mode: 0, readBack: 1, nodes: 1 }],
  ["should listen to Eds#removeTpdo", alone],
].map(([title, expected]) => [`Pdo: ${title}`, expected]);

const CASES = [...casesOfSdo(), ...CASES_OF_PDO];

// The bus, with a master that prepares the node for PDOs.

let title = "the bus"; // of the running case

function fail(error) {
  console.error(`${title}: ${error.stack}`);
  process.exit(1);
}

const bus = await SocketcandClient.connect(host, Number(port));
bus.on("close", fail);
const devices = new Set(); // of the running case
const answered = new Set(); // nodes that sent the counted kind of frame to the running case
let counted = 0x580; // SDO responses or, in the PDO cases, TPDO1
let place; // object of the running case
let bootUps = 0; // of NODE

const master = new Device({ id: 0x7f });
for (let node = 1; node <= NODES; ++node) {
  master.eds.addSdoClientParameter(node, 0x600 + node, 0x580 + node);
}
master.on("message", ({ id, data }) => bus.send(id, data));
master.start();

bus.on("frame", ({ id, data }) => {
  const message = { id, data, len: data.length };
  if (id === 0x700 + NODE && data[0] === 0) bootUps += 1;
  if ((id & 0x780) === counted) answered.add(id & 0x7f);
  master.receive(message);
  for (const device of devices) device.receive(message);
});

async function until(condition, what) {
  const end = Date.now() + PATIENCE;
  while (!(await condition())) {
    if (Date.now() > end) throw new Error(`${what} did not come true`);
    await sleep(2);
  }
}

/** Lets drive time pass by SYNCs, with an SDO access between them. SDOs need no drive time. */
async function sendSyncs() {
  for (;;) {
    bus.send(0x80, []);
    await master.sdo.upload({ deviceId: 1, index: 0x1000, timeout: PATIENCE });
    await sleep(1);
  }
}

const read = (index, dataType) =>
  master.sdo.upload({ deviceId: NODE, index, dataType, timeout: PATIENCE });
const write = (index, subIndex, data, dataType) =>
  master.sdo.download({ deviceId: NODE, index, subIndex, data, dataType, timeout: PATIENCE });
const isMode = async (mode) => (await read(0x6061, DataType.INTEGER8)) === mode;

async function mapOne(communication, cobId, object) {
  const mapping = communication + 0x200;
  await write(communication, 1, (0x80000000 | cobId) >>> 0, DataType.UNSIGNED32);
  await write(mapping, 0, 0, DataType.UNSIGNED8);
  await write(mapping, 1, object * 0x10000 + 8, DataType.UNSIGNED32);
  await write(mapping, 0, 1, DataType.UNSIGNED8);
  await write(communication, 1, cobId, DataType.UNSIGNED32);
}

async function preparePdos({ mode }) {
  const before = bootUps;
  master.nmt.resetNode(NODE);
  await until(() => bootUps > before, "the boot-up");
  await mapOne(0x1400, 0x200 + NODE, 0x6060);
  await mapOne(0x1800, 0x180 + NODE, 0x6061);
  await write(0x6060, 0, mode, DataType.INTEGER8);
  await until(() => isMode(mode), `6061h = ${mode}`);
  master.nmt.startNode(NODE);
  await read(0x1000, DataType.UNSIGNED32); // answered after the NMT command
}

// The device in the package's tests.

class DeviceOnBus extends Device {
  constructor(args = {}) {
    super({ ...args, loopback: false });
    if (!args.loopback) return;
    devices.add(this);
    this.on("message", ({ id, data }) => bus.send(id, data));
    // On a busy machine the test's time-out of 30 ms would not be the node's fault.
    const toPlace = (args) => ({ ...args, ...place, timeout: PATIENCE });
    const { sdo, eds, pdo } = this;
    const [upload, download] = [sdo.upload.bind(sdo), sdo.download.bind(sdo)];
    sdo.upload = (args) => upload(toPlace(args));
    sdo.download = (args) => download(toPlace(args));
    // Identifiers that a test omits default to 600h and 580h in the package, which belong to no
    // node.
    const addServer = eds.addSdoClientParameter.bind(eds);
    eds.addSdoClientParameter = (node, request = 0x600 + node, response = 0x580 + node) =>
      addServer(node, request, response);
    // TPDO1 of this device is RPDO1 of the node.
    const toRpdo = (cobId) => (cobId === 0x180 + NODE ? 0x200 + NODE : cobId);
    const [addTransmitPdo, writePdo] = [eds.addTransmitPdo.bind(eds), pdo.write.bind(pdo)];
    eds.addTransmitPdo = (args) => addTransmitPdo({ ...args, cobId: toRpdo(args.cobId) });
    pdo.write = (cobId) => writePdo(toRpdo(cobId));
  }
}
canopen.Device = DeviceOnBus; // for modules that require the package from now on

// Collects the cases of the files through the functions that a test runner provides.

const found = []; // [name, function]; three names occur twice
const groups = [];
globalThis.describe = (title, define) => {
  groups.push(title);
  define();
  groups.pop();
};
globalThis.it = (title, run) => {
  found.push([[...groups, title].join(": "), run]);
};

/** The error of a case, if any. */
async function errorOf(run) {
  const over = new AbortController();
  const late = sleep(PATIENCE, null, { signal: over.signal }).then(
    () => new Error("it has not ended"),
    () => undefined,
  );
  const work = run.length
    ? new Promise((resolve) => run.call({}, resolve))
    : Promise.resolve().then(() => run.call({}));
  const error = await Promise.race([work.then((reason) => reason, (reason) => reason), late]);
  over.abort();
  return error;
}

function judge(error, expected) {
  if (expected.code) {
    assert.ok(error instanceof SdoError, `no abort: ${error?.stack}`);
    assert.equal(error.code.toString(16), expected.code.toString(16));
    const code = expected.code.toString(16).padStart(8, "0");
    return `cannot run, ${expected.reason}: answered with ${code}h`;
  }
  if (expected.differs) {
    assert.equal(error?.name, "AssertionError", error?.stack);
    assert.equal(error.actual, expected.differs);
    return "uploads by segments; cannot go on, the text is the node's and a constant";
  }
  if (error) throw error;
  return expected.nodes > 1 ? `passes with ${expected.nodes} nodes` : "passes";
}

async function runCase(run, expected) {
  place = undefined;
  if (expected.index) place = { index: expected.index, subIndex: expected.subIndex };
  if (expected.mode !== undefined) await preparePdos(expected);
  counted = expected.mode === undefined ? 0x580 : 0x180;
  answered.clear();
  const error = await errorOf(run);
  const outcome = judge(error, expected);
  if (expected.readBack !== undefined) {
    await until(() => isMode(expected.readBack), `6061h = ${expected.readBack}`);
  }
  await until(() => answered.size === expected.nodes, `the part of ${expected.nodes} nodes`);
  for (const device of devices) device.stop();
  devices.clear();
  return outcome;
}

const summary = { pass: 0, part: 0, refused: 0, alone: 0 };

function kindOf({ nodes, code, differs }) {
  if (!nodes) return "alone";
  if (code) return "refused";
  return differs ? "part" : "pass";
}
try {
  for (const file of ["test_sdo.js", "test_pdo.js"]) require(`canopen/test/protocol/${file}`);
  assert.deepEqual(found.map(([name]) => name), CASES.map(([name]) => name));
  let isClockRunning = clock !== "lockstep";
  for (const [number, [name, expected]] of CASES.entries()) {
    title = name;
    summary[kindOf(expected)] += 1;
    if (!expected.nodes) {
      console.log(`${name}: not run, ${expected.reason}`);
      continue;
    }
    if (expected.mode !== undefined && !isClockRunning) {
      isClockRunning = true;
      sendSyncs().catch(fail);
    }
    console.log(`${name}: ${await runCase(found[number][1], expected)}`);
  }
  console.log(
    `of ${CASES.length} cases that the package has for SDO and PDO ${summary.pass} pass, ` +
      `${summary.part} passes in part, ${summary.refused} need what a node does not have and get its ` +
      `abort code, ${summary.alone} need no node`,
  );
  process.exit(0);
} catch (error) {
  fail(error);
}
