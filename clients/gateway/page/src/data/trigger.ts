// SPDX-License-Identifier: Apache-2.0
// What a trigger waits for, and where it is in the samples.

import type { LogEvent } from "./events";
import type { Samples } from "./samples";

/** Edges across a level, levels, and edges of a bit. */
export const SIGNAL_CONDITIONS = ["rising", "falling", "above", "below", "bit_set", "bit_cleared"] as const;
export const CONDITIONS = [...SIGNAL_CONDITIONS, "event"] as const;
export type Condition = (typeof CONDITIONS)[number];
export const MODES = ["single", "normal"] as const;
export type TriggerMode = (typeof MODES)[number];

export interface Trigger {
  mode: TriggerMode;
  /** address */
  axis: string;
  /** of the status; "" for an event */
  member: string;
  condition: Condition;
  /** level in the unit of the drive, or number of a bit */
  value: number;
  /** The event has it in its kind or its text; "" = any event. */
  text: string;
  /** share of the window that lies before the trigger, 0 to 1 */
  before: number;
}

type SignalCondition = (typeof SIGNAL_CONDITIONS)[number];

/** Whether it is met by a value and the one before it. */
const IS_MET: Record<SignalCondition, (before: number, now: number, value: number) => boolean> = {
  rising: (before, now, level) => before < level && now >= level,
  falling: (before, now, level) => before > level && now <= level,
  above: (_, now, level) => now >= level,
  below: (_, now, level) => now <= level,
  bit_set: (before, now, bit) => ((now >> bit) & 1) === 1 && ((before >> bit) & 1) === 0,
  bit_cleared: (before, now, bit) => ((now >> bit) & 1) === 0 && ((before >> bit) & 1) === 1,
};

/** @param value of a sample
 *  @param begin The sample before it is the first one that is compared.
 *  @return the first sample from `begin` on, before `end`, that meets the condition */
export function findTrigger(
  value: (sample: number) => number,
  begin: number,
  end: number,
  condition: SignalCondition,
  wanted: number,
): number | undefined {
  const isMet = IS_MET[condition];
  if (begin >= end) return undefined;
  let before = value(begin - 1);
  for (let n = begin; n < end; ++n) {
    const now = value(n);
    if (isMet(before, now, wanted)) return n;
    before = now;
  }
  return undefined;
}

/** @return whether the event is what the trigger waits for. An event of the bench is one of each of its axes. */
export function isTriggerEvent({ axis, text }: Trigger, event: LogEvent): boolean {
  const [bench, number] = axis.split(".").map(Number);
  const isOfAxis = event.bench === bench && (event.axis === number || event.axis === 0);
  return isOfAxis && `${event.kind} ${event.message}`.toLowerCase().includes(text.toLowerCase());
}

export function isSignalCondition(condition: Condition): condition is SignalCondition {
  return condition !== "event";
}

/** A trigger at work: it finds one run after the other. */
export class TriggerRun {
  /** [s] of drive time, of the run that is complete; undefined before the first one */
  at?: number;
  /** of the run before it */
  last?: number;
  private pending?: number;
  private next: number;

  /** @param since [s] of drive time: what was before is not looked at */
  constructor(
    readonly trigger: Trigger,
    private readonly samples: Samples,
    private readonly events: () => readonly LogEvent[],
    private since: number,
  ) {
    this.next = samples.history.lowerBound(since - samples.origin);
  }

  /** A run is under way: what comes after the trigger is still missing. */
  get isFilling(): boolean {
    return this.pending !== undefined;
  }

  /** @return why nothing will ever be found; nothing where it can */
  get isWithoutSignal(): boolean {
    const { condition, member } = this.trigger;
    return isSignalCondition(condition) && this.samples.members.length > 0 && this.samples.series(member) === undefined;
  }

  /** Looks at what has come since the last call.
   *  @param window [s]
   *  @param end [s] of drive time up to which there are samples
   *  @return whether another run is complete */
  advance(window: number, end: number): boolean {
    this.pending ??= this.search();
    const after = (1 - this.trigger.before) * window;
    if (this.pending === undefined || end < this.pending + after) return false;
    this.last = this.at;
    this.at = this.pending;
    this.pending = undefined;
    this.since = this.at + after;
    this.next = Math.max(this.next, this.samples.history.lowerBound(this.since - this.samples.origin));
    return true;
  }

  private search(): number | undefined {
    const { condition, member, value } = this.trigger;
    if (!isSignalCondition(condition)) {
      return this.events().find((event) => event.time > this.since && isTriggerEvent(this.trigger, event))?.time;
    }
    const { history, origin } = this.samples;
    const series = this.samples.series(member);
    if (series === undefined) return undefined;
    if (this.next > history.end) this.next = history.first; // the bench has started again
    const begin = Math.max(this.next, history.first + 1);
    const found = findTrigger((n) => history.value(series, n), begin, history.end, condition, value);
    this.next = Math.max(this.next, found === undefined ? history.end : found + 1);
    return found === undefined ? undefined : origin + history.time(found);
  }
}
