// SPDX-License-Identifier: Apache-2.0
// The power state machine of CiA 402, as shown by a statusword.

import { POWER_STATES as ROWS, TRANSITIONS } from "./tables";

export type PowerState = (typeof ROWS)[number]["state"];

export const POWER_STATES: PowerState[] = ROWS.map((row) => row.state);

/** The standard's names. */
export const POWER_STATE_NAMES = Object.fromEntries(ROWS.map((row) => [row.state, row.name])) as Record<
  PowerState,
  string
>;

/** @return whether the drive reacts to a fault or waits for its reset. */
export function isFault(state: PowerState): boolean {
  return state === "fault" || state === "fault_reaction_active";
}

export const STATUS_BIT = {
  quickStop: 1 << 5,
  warning: 1 << 7,
  targetReached: 1 << 10,
  internalLimit: 1 << 11,
  acknowledge: 1 << 12,
  /** following error; in homing mode: homing error */
  modeError: 1 << 13,
} as const;

export function decodePowerState(statusword: number): PowerState {
  // The last row matches every word.
  return ROWS.find((row) => (statusword & row.mask) === row.value)?.state ?? "not_ready_to_switch_on";
}

/** @return the fewest transitions from one state to the other, in order. Several may happen within one tick, and the
 *          statusword shows only the final state. */
export function wayBetween(from: PowerState, to: PowerState): number[] {
  const ways = new Map<PowerState, number[]>([[from, []]]);
  const open: PowerState[] = [from];
  for (let at = open.shift(); at !== undefined && !ways.has(to); at = open.shift()) {
    for (const transition of TRANSITIONS) {
      if (transition.from !== at || ways.has(transition.to)) continue;
      ways.set(transition.to, [...(ways.get(at) ?? []), transition.number]);
      open.push(transition.to);
    }
  }
  return ways.get(to) ?? [];
}
