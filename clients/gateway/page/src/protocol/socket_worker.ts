// SPDX-License-Identifier: Apache-2.0
// Holds the WebSocket to the gateway in its own thread. A page that holds control must send something within its limit
// of silence, 1 s to 10 s, and on a busy machine a thread that draws may be late.

import { Mailbox, type Batch, type Packet } from "./mailbox";
import { LONGEST_SILENCE_MS } from "./silence";

/** From the page. */
export type Order =
  | { kind: "open"; url: string; protocols: string[] }
  | { kind: "send"; packet: Packet }
  | { kind: "taken" }
  | { kind: "patience"; milliseconds: number }
  | { kind: "close" };

/** To the page. */
export type Report = { kind: "batch"; batch: Batch } | { kind: "opened" } | { kind: "closed" };

const SIGN_OF_LIFE_MS = 250;
const SIGN_OF_LIFE = JSON.stringify({ op: "unsubscribe", subscriptionIds: [] });
// Close code for a page that has taken nothing for `patience`: it is lost even if this thread works, because no user
// can stop an axis with it. The gateway treats a connection that ends with this code as lost.
const PAGE_STANDS_STILL = 4000;
const NORMAL_CLOSURE = 1000;

function report(message: Report, transfer: Transferable[] = []): void {
  self.postMessage(message, { transfer });
}

const mailbox = new Mailbox((batch) => {
  report({ kind: "batch", batch }, batch.packets.filter((packet) => typeof packet !== "string"));
});
let socket: WebSocket | undefined;
let patience = LONGEST_SILENCE_MS;

function open(url: string, protocols: string[]): void {
  const opened = new WebSocket(url, protocols);
  opened.binaryType = "arraybuffer";
  opened.onopen = () => report({ kind: "opened" });
  opened.onmessage = (event: MessageEvent<Packet>) => mailbox.put(event.data);
  opened.onclose = () => {
    socket = undefined;
    patience = LONGEST_SILENCE_MS;
    mailbox.clear();
    report({ kind: "closed" });
  };
  socket = opened;
}

self.onmessage = ({ data: order }: MessageEvent<Order>) => {
  if (order.kind === "open") open(order.url, order.protocols);
  else if (order.kind === "taken") mailbox.taken();
  else if (order.kind === "patience") patience = order.milliseconds;
  else if (order.kind === "close") socket?.close(NORMAL_CLOSURE);
  else if (socket?.readyState === WebSocket.OPEN) socket.send(order.packet);
};

setInterval(() => {
  if (socket?.readyState !== WebSocket.OPEN) return;
  if (mailbox.ask() > patience / SIGN_OF_LIFE_MS) socket.close(PAGE_STANDS_STILL, "the page does not respond");
  else socket.send(SIGN_OF_LIFE);
}, SIGN_OF_LIFE_MS);
