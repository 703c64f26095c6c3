// SPDX-License-Identifier: Apache-2.0
// The history of one axis as marks on its plots: from the status of each tick, and from events.

import type { LogEvent } from "./events";
import type { PowerState } from "./power";

/** A change in the status of an axis. */
export interface Moment {
  tick: number;
  /** new state of the axis; undefined for a fault */
  state?: PowerState;
  /** new value of 603Fh; undefined for a change of state */
  code?: number;
}

export type MarkKind = "state" | "fault" | "event";

export interface Mark {
  tick: number;
  kind: MarkKind;
  moment?: Moment;
  event?: LogEvent;
}

/** Events of changes that the status of a tick shows too. */
const OF_STATUS: Record<string, MarkKind> = { state_changed: "state", fault: "fault" };
/** On a busy machine there are hundreds of late ticks, which would hide other marks: they are only in the list. */
const UNMARKED = new Set(["tick_overrun"]);
/** [ticks] An event has the tick of its change, or the one after it. */
const SAME_CHANGE = 1;

/** @param moments and events in the order of their ticks; events of this axis, or of its bench
 *  @return each change once: events of changes that the status shows are left out. */
export function marksOf(moments: readonly Moment[], events: readonly LogEvent[]): Mark[] {
  const seen = new Set<string>();
  const marks = moments.map((moment): Mark => {
    const kind = moment.state === undefined ? "fault" : "state";
    for (let tick = moment.tick - SAME_CHANGE; tick <= moment.tick + SAME_CHANGE; ++tick) seen.add(`${kind} ${tick}`);
    return { tick: moment.tick, kind, moment };
  });
  for (const event of events) {
    if (UNMARKED.has(event.kind)) continue;
    const kind = OF_STATUS[event.kind] ?? "event";
    if (kind === "event" || !seen.has(`${kind} ${event.tick}`)) marks.push({ tick: event.tick, kind, event });
  }
  return marks.sort((a, b) => a.tick - b.tick);
}
