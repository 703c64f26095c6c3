// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

/** The messages that the page posts to the worker that has the WebSocket, and those that the worker sends. */
interface FakeWorker {
  onmessage?: (event: { data: unknown }) => void;
  orders: { kind: string; packet?: string }[];
}

const workers: FakeWorker[] = [];
class Worker implements FakeWorker {
  orders: { kind: string; packet?: string }[] = [];
  constructor() {
    workers.push(this);
  }
  postMessage(order: { kind: string; packet?: string }): void {
    this.orders.push(order);
  }
}
Object.defineProperties(globalThis, {
  Worker: { value: Worker },
  navigator: { value: { language: "en", userAgent: "" } },
  window: { value: { addEventListener: () => undefined, setTimeout: () => 0, clearTimeout: () => undefined } },
});
const { Model } = await import("../src/model");

/** A gateway as the page sees it. */
class FakeGateway {
  readonly model = new Model("ws://gateway/");
  private readonly worker = workers[workers.length - 1];
  private channels: string[] = [];
  private readonly subscriptions = new Map<string, number>();

  start(): void {
    this.channels = [];
    this.subscriptions.clear();
    this.report({ kind: "opened" });
    this.send({ op: "serverInfo", name: "gateway" });
    this.advertise("/gateway/control");
  }

  end(): void {
    this.report({ kind: "closed" });
  }

  advertise(...topics: string[]): void {
    const first = this.channels.length;
    this.channels.push(...topics);
    const channels = topics.map((topic, i) => ({ id: first + i, topic, encoding: "json", schemaName: "", schema: "" }));
    this.send({ op: "advertise", channels });
  }

  publish(topic: string, message: object): void {
    for (const { packet } of this.worker.orders.splice(0)) this.note(packet);
    const id = this.subscriptions.get(topic);
    assert.ok(id !== undefined, `the page has subscribed ${topic}`);
    const text = new TextEncoder().encode(JSON.stringify(message));
    const frame = new Uint8Array(13 + text.length);
    frame[0] = 1;
    new DataView(frame.buffer).setUint32(1, id, true);
    frame.set(text, 13);
    this.report({ kind: "batch", batch: { packets: [frame.buffer], dropped: 0 } });
  }

  private note(packet: unknown): void {
    if (typeof packet !== "string") return;
    const { op, subscriptions } = JSON.parse(packet) as { op: string; subscriptions: { id: number; channelId: number }[] };
    if (op === "subscribe") for (const { id, channelId } of subscriptions) this.subscriptions.set(this.channels[channelId], id);
  }

  private send(message: object): void {
    this.report({ kind: "batch", batch: { packets: [JSON.stringify(message)], dropped: 0 } });
  }

  private report(data: object): void {
    this.worker.onmessage?.({ data });
  }
}

const OWN = "0x0000000000000064";
const OTHER = "0x0000000000000065";
const OWN_NUMBER = 0x64;

const AXIS = {
  axis: 1,
  name: "x",
  topic: "x",
  unit: { kind: "rotary", name: "deg", per: 4096 },
  supported_drive_modes: 0,
  user_position_lower_limit: 0,
  user_position_upper_limit: 0,
  app_speed_limit: 0,
};

function bringBench(gateway: FakeGateway): void {
  gateway.advertise("/bench1/description", "/bench1/state", "/bench1/events", "/bench1/status");
  gateway.publish("/bench1/description", {
    bench: 1,
    name: "cell",
    clock_mode: "realtime",
    period_us: 1000,
    dictionary_version: "1",
    service_version: "1",
    host: "bench-0",
    incarnation: "7",
    axes: [AXIS],
  });
}

function publishState(gateway: FakeGateway, age_ms: number, takings: object[] = []): void {
  gateway.publish("/bench1/state", {
    bench: 1,
    tick: 1,
    time_ns: "0",
    rate: 1,
    clock_mode: "realtime",
    wire_starts: 1,
    longest_silence_us: 0,
    alive: true,
    age_ms,
    owners: [{ session: OTHER, name: "vdrive (process 9 on host)" }],
    takings,
  });
}

function control(gateway: FakeGateway, you: boolean, holder = "page", session = OWN): void {
  gateway.publish("/gateway/control", { enabled: true, holder, you, name: "page", session, taken_at_ns: "0", silence_ms: 10_000 });
}

/** Publishes the status of axis 1.1 in profile position mode.
 *  @param owner number of the session that owns the axis
 *  @param velocity [UU/s] demand and actual velocity */
function status(gateway: FakeGateway, tick: number, owner: number, velocity = 0): void {
  gateway.publish("/bench1/status", {
    tick,
    axis: [1],
    owner_session: [owner],
    op_mode_actual: [1],
    load_position_actual_value: [51_892],
    load_velocity_actual_value: [velocity],
    velocity_demand_value: [velocity],
  });
}

function connected(): FakeGateway {
  const gateway = new FakeGateway();
  gateway.start();
  control(gateway, true);
  bringBench(gateway);
  return gateway;
}

test("what was kept of an axis shows the bench of a gateway that was started again", () => {
  const gateway = connected();
  const { model } = gateway;
  publishState(gateway, 0);
  const [kept] = [model.find("1.1"), ...model.axes()];
  assert.ok(kept !== undefined);
  gateway.end();
  gateway.start(); // the bench is found after the page has connected
  assert.equal(model.find("1.1"), undefined);
  assert.equal(kept.axis.name, "x");
  bringBench(gateway);
  publishState(gateway, 12);
  assert.equal(kept.bench, model.benches.get(1));
  assert.equal(kept.bench.state?.age_ms, 12);
  assert.equal(kept.axis, model.find("1.1")?.axis);
});

const LOSS = `nothing was received from session ${OWN} for 500 ms; 1 axis lost its master`;
const event = (sec: number) => ({ timestamp: { sec, nanosec: 0 }, level: 4, name: "bench1/x", file: "master_lost", message: LOSS });

for (const order of ["the event before the status", "the status before the event"]) {
  test(`an axis that the watchdog has freed was taken by nobody, and may be commanded: ${order}`, () => {
    const gateway = connected();
    const { model } = gateway;
    status(gateway, 4000, OWN_NUMBER);
    const steps = [() => gateway.publish("/bench1/events", event(5)), () => status(gateway, 5000, 0)];
    if (order.startsWith("the status")) steps.reverse();
    for (const step of steps) step();
    assert.equal(model.whyTaken(["1.1"]), undefined);
    assert.match(model.outcome?.text ?? "", /; nobody took them: 1\.1: nothing was received .* for 500 ms/);
    assert.equal(model.notices().length, 1);
  });
}

test("a loss from before does not explain that another session has taken the axis now", () => {
  const gateway = connected();
  const { model } = gateway;
  gateway.publish("/bench1/events", event(5));
  status(gateway, 6000, OWN_NUMBER);
  status(gateway, 7000, 0);
  publishState(gateway, 0, [{ axis: 1, from: OWN, by: OTHER, tick: 6500 }]);
  assert.match(model.whyTaken(["1.1"]) ?? "", /^taken from this page/);
  assert.match(model.notices()[0].text, /now controlled by vdrive \(process 9 on host\): 1\.1$/);
});

test("a page from which control is taken names who has it, until a person removes the line", () => {
  const gateway = connected();
  control(gateway, false, "night shift", OTHER);
  const [notice] = gateway.model.notices();
  assert.match(notice.text, /control was taken from this page by night shift$/);
  notice.press();
  assert.deepEqual(gateway.model.notices(), []);
});

test("the question before control is taken names the holder and what moves, and claims nothing that it does not know", () => {
  const gateway = connected();
  const { model } = gateway;
  publishState(gateway, 0);
  control(gateway, false, "night shift", OTHER);
  status(gateway, 1000, 0x65);
  assert.match(model.takeOverText(), /^Take control from night shift, in control since \d\d:\d\d\? None of its axes is moving\.$/);
  status(gateway, 1001, 0x65, 20_480);
  assert.match(model.takeOverText(), /\? Moving now: 1\.1 \(profile position, 51.892 UU, 20.480 UU\/s\)$/);
  status(gateway, 1002, 0x66, 20_480);
  assert.match(model.takeOverText(), /None of its axes is moving/, "it is another session's");
  gateway.advertise("/bench2/description", "/bench2/state");
  assert.match(model.takeOverText(), /it is shown only in Overview and Control\.$/, "the status of bench 2 is not received");
});
