// SPDX-License-Identifier: Apache-2.0
// Reads the ticks of an axis in an answer of /fault.

import { checked, type Schema } from "../protocol/checked";
import { RecordedAxis } from "./recorded";
import type { SampledAxis } from "./samples";

const NUMBERS = { type: "array", items: { type: "integer" } } as const satisfies Schema;
const TICK = "tick";

/** @param samples a list for the ticks and for each member of the status, with a number for each tick
 *  @throws Error when the lists are of different lengths, or are not lists */
export function recordedAxisOf({ address, name, unit }: SampledAxis, samples: unknown): RecordedAxis {
  const lists = Object.entries(samples ?? {}).map(([member, list]) => [member, checked(NUMBERS, list, `/fault: ${member}`)] as const);
  const columns = new Map(lists.filter(([member]) => member !== TICK));
  const ticks = lists.find(([member]) => member === TICK)?.[1] ?? [];
  for (const [member, list] of columns) {
    if (list.length !== ticks.length) throw new Error(`/fault: ${list.length} values of ${member} for ${ticks.length} ticks`);
  }
  const axis = new RecordedAxis(address, name, new Map([...columns.keys()].map((member) => [member, Float64Array])), unit);
  ticks.forEach((tick, n) => axis.add(tick, (member) => columns.get(member)?.[n] ?? 0, 0));
  return axis;
}
