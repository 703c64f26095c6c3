// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { Mailbox, type Batch } from "../src/protocol/mailbox";

/** A message of a channel: its first byte is 1. */
function data(number: number): ArrayBuffer {
  return new Uint8Array([1, number]).buffer;
}

/** An answer of a service: its first byte is 3. */
function answer(number: number): ArrayBuffer {
  return new Uint8Array([3, number]).buffer;
}

function start(most: number) {
  const batches: Batch[] = [];
  return { batches, mailbox: new Mailbox((batch) => batches.push(batch), most) };
}

test("messages that arrive while the page is busy are one batch, in order", () => {
  const { batches, mailbox } = start(1000);
  for (const text of ["a", "b", "c"]) mailbox.put(text);
  assert.deepEqual(batches.map((batch) => batch.packets), [["a"]]);
  mailbox.taken();
  mailbox.taken();
  assert.deepEqual(batches.map((batch) => batch.packets), [["a"], ["b", "c"]]);
  mailbox.put("d");
  assert.deepEqual(batches[2].packets, ["d"]);
});

test("beyond the limit the oldest messages of channels are left out and counted, answers never", () => {
  const { batches, mailbox } = start(6); // [bytes]: three messages of two bytes
  mailbox.put("first"); // being delivered: does not wait
  for (let i = 1; i <= 4; ++i) mailbox.put(i === 1 ? answer(i) : data(i));
  mailbox.put("ab");
  mailbox.taken();
  // Of answer 1, data 2, 3, 4 and a text, each two bytes, the limit has room for three.
  assert.equal(batches[1].dropped, 2);
  assert.deepEqual(batches[1].packets, [answer(1), data(4), "ab"]);
  mailbox.put(data(5));
  mailbox.taken();
  assert.equal(batches[2].dropped, 0);
});

test("answers beyond the limit all stay", () => {
  const { batches, mailbox } = start(2);
  mailbox.put("first");
  for (let i = 0; i < 5; ++i) mailbox.put(answer(i));
  mailbox.taken();
  assert.equal(batches[1].packets.length, 5);
});

test("a page with a pending answer gets no second request, and each is counted", () => {
  const { batches, mailbox } = start(1000);
  assert.equal(mailbox.ask(), 0);
  assert.deepEqual(batches, [{ packets: [], dropped: 0 }]);
  assert.equal(mailbox.ask(), 1);
  assert.equal(mailbox.ask(), 2);
  assert.equal(batches.length, 1);
  mailbox.taken();
  assert.equal(mailbox.ask(), 0);
});

test("messages that wait for the page end with its connection", () => {
  const { batches, mailbox } = start(1000);
  for (const text of ["a", "b"]) mailbox.put(text);
  mailbox.clear();
  mailbox.taken();
  assert.equal(batches.length, 1);
});
