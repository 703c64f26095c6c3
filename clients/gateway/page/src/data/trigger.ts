// SPDX-License-Identifier: Apache-2.0
// The condition of a trigger, and the search for it in the samples.

import type { LogEvent } from "./events";
import type { Samples } from "./samples";

/** Level crossings, levels, and edges of a bit. */
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
  /** must occur in the kind or the text of the event; "" = any event */
  text: string;
  /** share of the window before the trigger, 0 to 1 */
  before: number;
}

type SignalCondition = (typeof SIGNAL_CONDITIONS)[number];

/** Whether a value and its predecessor meet the condition. */
const IS_MET: Record<SignalCondition, (before: number, now: number, value: number) => boolean> = {
  rising: (before, now, level) => before < level && now >= level,
  falling: (before, now, level) => before > level && now <= level,
  above: (_, now, level) => now >= level,
  below: (_, now, level) => now <= level,
  bit_set: (before, now, bit) => ((now >> bit) & 1) === 1 && ((before >> bit) & 1) === 0,
  bit_cleared: (before, now, bit) => ((now >> bit) & 1) === 0 && ((before >> bit) & 1) === 1,
};

/** @param value of a sample
 *  @param begin the first sample to compare with its predecessor
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

/** @return whether the event matches the trigger. An event of the bench counts for each of its axes. */
export function isTriggerEvent({ axis, text }: Trigger, event: LogEvent): boolean {
  const [bench, number] = axis.split(".").map(Number);
  const isOfAxis = event.bench === bench && (event.axis === number || event.axis === 0);
  return isOfAxis && `${event.kind} ${event.message}`.toLowerCase().includes(text.toLowerCase());
}

export function isSignalCondition(condition: Condition): condition is SignalCondition {
  return condition !== "event";
}

/** An armed trigger. A run is the window of samples around one occurrence; runs are found one after the other. */
export class TriggerRun {
  /** [s] of drive time, of the latest complete run; undefined before the first one */
  at?: number;
  /** of the previous run */
  last?: number;
  private pending?: number;
  private next: number;

  /** @param since [s] of drive time: earlier samples are ignored */
  constructor(
    readonly trigger: Trigger,
    private readonly samples: Samples,
    private readonly events: () => readonly LogEvent[],
    private since: number,
  ) {
    this.next = samples.history.lowerBound(since - samples.origin);
  }

  /** A run has been triggered, but the samples after the trigger are not complete. */
  get isFilling(): boolean {
    return this.pending !== undefined;
  }

  /** [s] of drive time, of the newest trigger, even while its run is incomplete */
  get found(): number | undefined {
    return this.pending ?? this.at;
  }

  /** @return whether the signal does not exist, so that nothing will ever be found */
  get isWithoutSignal(): boolean {
    const { condition, member } = this.trigger;
    return isSignalCondition(condition) && this.samples.members.length > 0 && this.samples.series(member) === undefined;
  }

  /** Examines the samples since the last call.
   *  @param window [s]
   *  @param end [s] of drive time of the newest sample
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
    if (this.next > history.end) this.next = history.first; // the bench has been restarted
    const begin = Math.max(this.next, history.first + 1);
    const found = findTrigger((n) => history.value(series, n), begin, history.end, condition, value);
    this.next = Math.max(this.next, found === undefined ? history.end : found + 1);
    return found === undefined ? undefined : origin + history.time(found);
  }
}
