// SPDX-License-Identifier: Apache-2.0
// A window of a bench's black box as a recording: every tick, whatever this page has received.

import type { RecordedAxis } from "./data/recorded";
import { recordedAxisOf } from "./data/recorded_window";
import type { SampledAxis } from "./data/samples";
import type { Model } from "./model";
import { checked, type Schema } from "./protocol/checked";
import { Recording } from "./recording";

const FROZEN = { type: "object", properties: { window: { type: "integer" } }, required: ["window"] } as const satisfies Schema;

interface Sampled {
  axis: SampledAxis;
  /** [s] of a tick */
  period: number;
}

async function ask(model: Model, service: string, request: object) {
  const answer = await model.connection.call(service, request);
  if (!answer.ok) throw new Error(String(answer["message"] ?? service));
  return answer;
}

/** Makes the bench keep a window around the present: from 2 s before to 0.5 s after.
 *  @return the number of the window
 *  @throws Error with the reason of the gateway */
export async function freeze(model: Model, bench: number): Promise<number> {
  return checked(FROZEN, await ask(model, "/freeze", { bench }), "/freeze").window;
}

/** @param all axes of one bench, at least one
 *  @throws Error with the reason of the gateway */
export async function recordingOfWindow(model: Model, window: number, all: readonly Sampled[]): Promise<Recording> {
  const axes: RecordedAxis[] = [];
  for (const { axis } of all) {
    const answer = await ask(model, "/fault", { window, axis: axis.address });
    axes.push(recordedAxisOf(axis, answer["samples"]));
  }
  const [{ axis, period }] = all;
  const events = model.events.events.filter(({ bench, tick }) => bench === axis.bench && axes.some(({ first, last }) => tick >= first && tick <= last));
  return new Recording(`${axis.bench}.window-${window}`, { axes, events, period, cut: "" }, "");
}
