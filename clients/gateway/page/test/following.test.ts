// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";

import { USER_UNITS } from "../src/data/units";
import type { Model } from "../src/model";

Object.defineProperty(globalThis, "navigator", { value: { language: "en", userAgent: "" } });
const { Motions } = await import("../src/motions");

const OWN = 7n;
type Handler = (message: object) => void;

/** A gateway whose axes have accepted a move to 5,000 UU; 607Bh is 0 to 3,600. */
class FakeGateway {
  readonly subscribed = new Map<string, Handler>();
  readonly motions = new Motions({
    find: (address: string) => ({ bench: { number: 1, topic: "bench1" }, axis: { axis: Number(address.slice(2)), topic: address } }),
    scale: () => USER_UNITS,
    connection: {
      subscribe: (topic: string, handler: Handler) => {
        this.subscribed.set(topic, handler);
        return () => this.subscribed.delete(topic);
      },
      call: (_service: string, { objects }: { objects: string[] }) => {
        const values: Record<string, number> = { "0x6040": 0x0f, "0x6061": 1, "0x607A": 5000, "0x6064": 1000, "0x607B:01": 0, "0x607B:02": 3600 };
        return Promise.resolve({ tick: 100, values: objects.map((object) => ({ value: values[object] })) });
      },
    },
  } as unknown as Model);
}

/** @return a group move of this many axes to 5,000 UU */
const moveOf = (count: number, first: number) => ({ moves: Array.from({ length: count }, (_, i) => ({ axis: `1.${first + i}`, position: 5000 })) });

test("32 axes are followed at most, of all commands, also of those that come at the same time", async () => {
  const { motions, subscribed } = new FakeGateway();
  await motions.follow(moveOf(20, 1), OWN);
  await motions.follow(moveOf(20, 101), OWN);
  assert.equal(motions.lines().length, 32);
  assert.equal(subscribed.size, 32);
  await motions.follow(moveOf(20, 1), OWN);
  assert.equal(motions.lines().length, 32, "the places of their motions before are free");
  const busy = new FakeGateway();
  await Promise.all([busy.motions.follow(moveOf(32, 1), OWN), busy.motions.follow(moveOf(32, 101), OWN)]);
  assert.equal(busy.subscribed.size, 32);
});

test("a move to a target beyond the range of a modulo axis ends where the range shows it", async () => {
  const { motions, subscribed } = new FakeGateway();
  await motions.follow({ axis: "1.1", position: 5000 }, OWN);
  subscribed.get("bench1/1.1/status")?.({
    tick: 300n,
    owner_session: OWN,
    ds402_statusword: 0x0637,
    op_mode_actual: 1,
    error_code: 0,
    digital_inputs: 0,
    load_position_actual_value: 1400,
    position_demand_value: 1400,
    velocity_demand_value: 0,
  });
  await new Promise(setImmediate);
  assert.match(motions.lines()[0].text, /^1\.1: Move to 5.000 UU: reached, 1.400 UU$/);
});
