// SPDX-License-Identifier: Apache-2.0
// Events of the benches, from their topics and from the history that the gateway keeps.

import type { Of } from "../protocol/checked";
import { nameMatches, wordsOf } from "./rows";
import { isoDate, isWallTime } from "./times";

export interface LogEvent {
  bench: number;
  /** number on the bench; 0 = the bench, or several axes */
  axis: number;
  tick: number;
  /** [s] of drive time */
  time: number;
  /** of foxglove.Log: 2 info, 3 warning, 4 error */
  level: number;
  /** name in the core, such as "fault_reset" */
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

/** The events of a view. */
export interface EventFeed {
  readonly events: readonly LogEvent[];
  /** Increases with each change. */
  readonly version: number;
}

const SESSION = /session 0x([0-9a-f]{16})/g;
const FAULT = /\bfault 0x([0-9A-Fa-f]{4})\b/g;

/** @return the sessions named in a message, in hex as the gateway writes them */
export function sessionsIn(message: string): string[] {
  return [...message.matchAll(SESSION)].map(([, session]) => session);
}

/** @param nameOf name of a session, if known
 *  @param errorOf name of a code of 603Fh; "" if it has none
 *  @return the message with names instead of numbers, without the leading axis, which is shown separately */
export function eventText({ axis, message }: LogEvent, nameOf: (session: string) => string | undefined, errorOf: (code: number) => string): string {
  const prefix = `axis ${axis}: `;
  const bare = axis !== 0 && message.startsWith(prefix) ? message.slice(prefix.length) : message;
  return bare
    .replace(SESSION, (number, session: string) => nameOf(session) ?? number)
    .replace(FAULT, (number, code: string) => `${number} ${errorOf(parseInt(code, 16))}`.trim());
}

export interface EventFilter {
  /** of foxglove.Log: this one and above */
  level: number;
  text: string;
  /** "" = all */
  session: string;
}

/** @param shown the text of the event with its source, which must contain each word of the filter */
export function matchesEvent(event: LogEvent, shown: string, { level, text, session }: EventFilter): boolean {
  const isOfSession = session === "" || sessionsIn(event.message).includes(session);
  return event.level >= level && isOfSession && nameMatches("", shown, wordsOf(text));
}

function quoted(text: string): string {
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** @param rows each event with its source and its text */
export function eventsCsv(rows: readonly { event: LogEvent; source: string; text: string }[]): string {
  const lines = rows.map(({ event, source, text }) =>
    [source, event.tick, event.time.toFixed(6), isoDate(event.time), event.level, event.kind, text].map(String).map(quoted).join(","),
  );
  return ["source,tick,time [s],date,level,kind,text", ...lines, ""].join("\n");
}

/** The events of all benches in the order of arrival, up to a limit. */
export class EventList implements EventFeed {
  private list: LogEvent[] = [];
  /** Increases with each change. */
  version = 0;

  constructor(private readonly most: number) {}

  get events(): readonly LogEvent[] {
    return this.list;
  }

  add(event: LogEvent): void {
    this.list.push(event);
    this.trim();
  }

  /** Another run of the bench has begun, which may count ticks from 0 again. */
  forget(bench: number): void {
    this.list = this.list.filter((event) => event.bench !== bench);
    ++this.version;
  }

  /** Inserts earlier events by time, without duplicates. Times of a bench that does not count from 1970 cannot be
   *  compared with those of other benches: its events come first. */
  merge(history: LogEvent[]): void {
    const known = new Set(this.list.map(keyOf));
    const place = ({ time }: LogEvent) => (isWallTime(time) ? time : 0);
    const all = [...history.filter((event) => !known.has(keyOf(event))), ...this.list];
    this.list = all.sort((a, b) => place(a) - place(b) || (a.bench === b.bench ? a.time - b.time : a.bench - b.bench));
    this.trim();
  }

  /** Drops the oldest events of the most frequent kind when there are too many, so that a bench with late ticks
   *  keeps its faults. */
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
