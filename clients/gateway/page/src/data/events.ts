// SPDX-License-Identifier: Apache-2.0
// What benches report, from their topics and from the history that the gateway keeps.

import type { Of } from "../protocol/checked";
import { isWallTime } from "./times";

export interface LogEvent {
  bench: number;
  /** number on the bench; 0 = the bench, or several axes */
  axis: number;
  tick: number;
  /** [s] of drive time */
  time: number;
  /** of foxglove.Log: 2 info, 3 warning, 4 error */
  level: number;
  /** as the core names it, such as "fault_reset" */
  kind: string;
  message: string;
}

/** The answer of the service /events. */
export const EVENT_HISTORY = {
  type: "object",
  properties: {
    events: {
      type: "array",
      items: {
        type: "object",
        properties: {
          tick: { type: "integer" },
          axis: { type: "integer" },
          kind: { type: "string" },
          level: { type: "integer" },
          message: { type: "string" },
        },
        required: ["tick", "axis", "kind", "level", "message"],
      },
    },
  },
  required: ["events"],
} as const;

export type EventHistory = Of<typeof EVENT_HISTORY>;

function keyOf({ bench, axis, tick, kind, message }: LogEvent): string {
  return `${bench} ${axis} ${tick} ${kind} ${message}`;
}

/** The events of all benches, bounded, in the order in which they came. */
export class EventList {
  private list: LogEvent[] = [];
  /** Grows with each change. */
  version = 0;

  constructor(private readonly most: number) {}

  get events(): readonly LogEvent[] {
    return this.list;
  }

  add(event: LogEvent): void {
    this.list.push(event);
    this.trim();
  }

  /** Another run of the bench has begun: its ticks may count anew. */
  forget(bench: number): void {
    this.list = this.list.filter((event) => event.bench !== bench);
    ++this.version;
  }

  /** Puts in what came before, in the order of time; what is there already is left out. Times of
   *  benches that do not count from the epoch are not compared with those of others: they stand first. */
  merge(history: LogEvent[]): void {
    const known = new Set(this.list.map(keyOf));
    const place = ({ time }: LogEvent) => (isWallTime(time) ? time : 0);
    const all = [...history.filter((event) => !known.has(keyOf(event))), ...this.list];
    this.list = all.sort((a, b) => place(a) - place(b) || (a.bench === b.bench ? a.time - b.time : a.bench - b.bench));
    this.trim();
  }

  /** Of too many the oldest of the most frequent kind go: a bench with late ticks keeps its faults. */
  private trim(): void {
    ++this.version;
    if (this.list.length <= this.most) return;
    const counts = new Map<string, number>();
    for (const { kind } of this.list) counts.set(kind, (counts.get(kind) ?? 0) + 1);
    while (this.list.length > this.most) {
      const [kind, count] = [...counts].reduce((most, entry) => (entry[1] > most[1] ? entry : most));
      counts.set(kind, count - 1);
      this.list.splice(this.list.findIndex((event) => event.kind === kind), 1);
    }
  }
}
