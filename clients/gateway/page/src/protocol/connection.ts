// SPDX-License-Identifier: Apache-2.0
// A client of the Foxglove WebSocket protocol: channels, services, parameters. It reconnects automatically, and then
// renews the subscriptions of its users by topic.

import { decodeCdr, type Message } from "./cdr";
import { checked, type Of } from "./checked";
import type { Batch, Packet } from "./mailbox";
import { parseSchema, type Definition } from "./schema";
import type { Order, Report } from "./socket_worker";

export interface Channel {
  id: number;
  topic: string;
  encoding: string;
  schemaName: string;
  schema: string;
  schemaEncoding?: string;
}

/** The members of two protocol messages that the page uses. */
const SERVER_INFO = {
  type: "object",
  properties: {
    name: { type: "string" },
    metadata: { type: "object", properties: { version: { type: "string" } }, required: [] },
  },
  required: ["name"],
} as const;
const SERVER_STATUS = {
  type: "object",
  properties: { level: { type: "integer" }, message: { type: "string" }, id: { type: "string" } },
  required: ["level", "message"],
} as const;

export type ServerInfo = Of<typeof SERVER_INFO>;
export type ServerStatus = Of<typeof SERVER_STATUS>;

/** @param logTime [ns] of drive time */
export type Handler = (message: Message, logTime: bigint) => void;

export interface Answer {
  ok: boolean;
  outcome: string;
  message: string;
  code: number;
  [more: string]: unknown;
}

interface Subscription {
  topic: string;
  id: number;
  handler: Handler;
  channel?: Channel;
  definition?: Definition;
}

interface Call {
  resolve: (answer: Answer) => void;
  timer: number;
}

export interface Listener {
  connected(info: ServerInfo): void;
  disconnected(): void;
  topicsChanged(): void;
  status(status: ServerStatus): void;
  statusEnded(ids: string[]): void;
  /** The page was slower than its channels: this number of messages was dropped. */
  leftOut(messages: number): void;
  parameters(values: { name: string; value: unknown }[]): void;
}

const SUB_PROTOCOLS = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
const MESSAGE_DATA = 1;
const SERVICE_RESPONSE = 3;
const SERVICE_REQUEST = 2;
const FIRST_RETRY_MS = 250;
const LONGEST_RETRY_MS = 2_000;
const CALL_LIMIT_MS = 10_000;
const CLOSE_TIME_MS = 50;
const encoder = new TextEncoder();
const decoder = new TextDecoder();

function failed(outcome: string, message: string): Answer {
  return { ok: false, outcome, message, code: 0 };
}

export class Connection {
  private readonly worker = new Worker(new URL("./socket_worker.ts", import.meta.url), { type: "module" });
  private isOpen = false;
  private retry = FIRST_RETRY_MS;
  private nextId = 1;
  private readonly channels = new Map<string, Channel>();
  private readonly services = new Map<string, number>();
  private readonly subscriptions = new Map<number, Subscription>();
  private readonly calls = new Map<number, Call>();
  /** Messages of channels that this page has dropped because they arrived faster than it could take them. */
  dropped = 0;

  constructor(
    private readonly url: string,
    private readonly listener: Listener,
  ) {
    window.addEventListener("pagehide", () => this.close());
    this.worker.onmessage = ({ data }: MessageEvent<Report>) => this.onReport(data);
  }

  open(): void {
    this.order({ kind: "open", url: this.url, protocols: SUB_PROTOCOLS });
  }

  /**
   * Closes the WebSocket by the closing handshake of its protocol, so that control is released. The browser ends the
   * worker together with the page, so this waits for the worker to send the close frame.
   */
  private close(): void {
    if (!this.isOpen) return;
    this.order({ kind: "close" });
    const end = performance.now() + CLOSE_TIME_MS;
    while (performance.now() < end);
  }

  private order(order: Order): void {
    this.worker.postMessage(order);
  }

  private onReport(report: Report): void {
    if (report.kind === "opened") this.isOpen = true;
    else if (report.kind === "closed") this.onClose();
    else this.onBatch(report.batch);
  }

  private onBatch({ packets, dropped }: Batch): void {
    if (dropped > 0) {
      this.dropped += dropped;
      this.listener.leftOut(dropped);
    }
    for (const packet of packets) {
      try {
        if (typeof packet === "string") this.onText(packet);
        else this.onBinary(packet);
      } catch (error) {
        reportError(error); // later packets are processed nevertheless
      }
    }
    this.order({ kind: "taken" });
  }

  topics(): string[] {
    return [...this.channels.keys()];
  }

  hasService(name: string): boolean {
    return this.services.has(name);
  }

  /** @return a function that ends the subscription; further calls do nothing. The topic may appear later. */
  subscribe(topic: string, handler: Handler): () => void {
    const subscription: Subscription = { topic, id: this.nextId++, handler };
    this.subscriptions.set(subscription.id, subscription);
    this.attach([subscription]);
    return () => {
      const isOpen = this.subscriptions.delete(subscription.id);
      if (isOpen && subscription.channel !== undefined) {
        this.send({ op: "unsubscribe", subscriptionIds: [subscription.id] });
      }
    };
  }

  /** If the thread of the page takes no messages for this time, the connection is closed as lost. The next connection
   *  starts with 10 s again. */
  setPatience(milliseconds: number): void {
    this.order({ kind: "patience", milliseconds });
  }

  /** Never rejects: a call that cannot be made has the outcome "lost" or "timed_out". */
  call(service: string, request: object): Promise<Answer> {
    const id = this.services.get(service);
    if (!this.isOpen) {
      return Promise.resolve(failed("lost", "the page has no connection to the gateway"));
    }
    if (id === undefined) {
      return Promise.resolve(failed("not_found", `the gateway has no service ${service}`));
    }
    const callId = this.nextId++;
    this.post(serviceRequest(id, callId, JSON.stringify(request)));
    return new Promise((resolve) => {
      const timer = window.setTimeout(() => {
        this.calls.delete(callId);
        resolve(failed("timed_out", `${service}: no answer within ${CALL_LIMIT_MS / 1000} s`));
      }, CALL_LIMIT_MS);
      this.calls.set(callId, { resolve, timer });
    });
  }

  private onClose(): void {
    this.isOpen = false;
    this.channels.clear();
    this.services.clear();
    for (const subscription of this.subscriptions.values()) subscription.channel = undefined;
    for (const call of this.calls.values()) {
      window.clearTimeout(call.timer);
      call.resolve(failed("lost", "the connection to the gateway was lost"));
    }
    this.calls.clear();
    this.listener.disconnected();
    window.setTimeout(() => this.open(), this.retry);
    this.retry = Math.min(this.retry * 2, LONGEST_RETRY_MS);
  }

  private onText(data: string): void {
    const message = JSON.parse(data) as { op: string; [more: string]: unknown };
    switch (message.op) {
      case "serverInfo":
        this.retry = FIRST_RETRY_MS;
        this.listener.connected(checked(SERVER_INFO, message, "serverInfo"));
        break;
      case "advertise":
        this.advertised(message["channels"] as Channel[]);
        break;
      case "unadvertise":
        this.unadvertised(new Set(message["channelIds"] as number[]));
        break;
      case "advertiseServices":
        for (const service of message["services"] as { id: number; name: string }[]) {
          this.services.set(service.name, service.id);
        }
        this.listener.topicsChanged();
        break;
      case "unadvertiseServices":
        this.forgetServices(new Set(message["serviceIds"] as number[]));
        break;
      case "serviceCallFailure":
        this.answered(message["callId"] as number, failed("failed", String(message["message"])));
        break;
      case "status":
        this.listener.status(checked(SERVER_STATUS, message, "status"));
        break;
      case "removeStatus":
        this.listener.statusEnded(message["statusIds"] as string[]);
        break;
      case "parameterValues":
        this.listener.parameters(message["parameters"] as { name: string; value: unknown }[]);
        break;
    }
  }

  private advertised(channels: Channel[]): void {
    const topics = new Set<string>();
    for (const channel of channels) {
      this.channels.set(channel.topic, channel);
      topics.add(channel.topic);
    }
    const waiting = [...this.subscriptions.values()].filter((s) => topics.has(s.topic));
    this.attach(waiting);
    this.listener.topicsChanged();
  }

  private unadvertised(ids: Set<number>): void {
    for (const [topic, channel] of this.channels) {
      if (ids.has(channel.id)) this.channels.delete(topic);
    }
    for (const subscription of this.subscriptions.values()) {
      if (subscription.channel !== undefined && ids.has(subscription.channel.id)) {
        subscription.channel = undefined;
      }
    }
    this.listener.topicsChanged();
  }

  private forgetServices(ids: Set<number>): void {
    for (const [name, id] of this.services) if (ids.has(id)) this.services.delete(name);
  }

  private attach(subscriptions: Subscription[]): void {
    const asked: { id: number; channelId: number }[] = [];
    for (const subscription of subscriptions) {
      const channel = this.channels.get(subscription.topic);
      if (channel === undefined || subscription.channel === channel) continue;
      subscription.channel = channel;
      subscription.definition = channel.encoding === "cdr" ? parseSchema(channel.schema) : undefined;
      asked.push({ id: subscription.id, channelId: channel.id });
    }
    if (asked.length > 0) this.send({ op: "subscribe", subscriptions: asked });
  }

  private onBinary(data: ArrayBuffer): void {
    const view = new DataView(data);
    const operation = view.getUint8(0);
    if (operation === MESSAGE_DATA) {
      const subscription = this.subscriptions.get(view.getUint32(1, true));
      if (subscription === undefined) return; // sent before the end of the subscription arrived
      const payload = new Uint8Array(data, 13);
      const message =
        subscription.definition === undefined
          ? (JSON.parse(decoder.decode(payload)) as Message)
          : decodeCdr(subscription.definition, payload);
      subscription.handler(message, view.getBigUint64(5, true));
    } else if (operation === SERVICE_RESPONSE) {
      const length = view.getUint32(9, true);
      const text = decoder.decode(new Uint8Array(data, 13 + length));
      this.answered(view.getUint32(5, true), JSON.parse(text) as Answer);
    }
  }

  private answered(callId: number, answer: Answer): void {
    const call = this.calls.get(callId);
    if (call === undefined) return;
    this.calls.delete(callId);
    window.clearTimeout(call.timer);
    call.resolve(answer);
  }

  private send(message: object): void {
    if (this.isOpen) this.post(JSON.stringify(message));
  }

  private post(packet: Packet): void {
    this.order({ kind: "send", packet });
  }
}

function serviceRequest(service: number, call: number, body: string): ArrayBuffer {
  const encoding = encoder.encode("json");
  const payload = encoder.encode(body);
  const frame = new Uint8Array(13 + encoding.length + payload.length);
  const view = new DataView(frame.buffer);
  view.setUint8(0, SERVICE_REQUEST);
  view.setUint32(1, service, true);
  view.setUint32(5, call, true);
  view.setUint32(9, encoding.length, true);
  frame.set(encoding, 13);
  frame.set(payload, 13 + encoding.length);
  return frame.buffer;
}
