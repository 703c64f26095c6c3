// SPDX-License-Identifier: Apache-2.0
// The power state machine of CiA 402 as a statusword shows it.

export type PowerState =
  | "not_ready"
  | "switch_on_disabled"
  | "ready"
  | "switched_on"
  | "enabled"
  | "quick_stop"
  | "fault_reaction"
  | "fault";

/** Masks 004Fh and 006Fh of CiA 402, in the order in which they are compared. */
const STATES: { state: PowerState; mask: number; value: number }[] = [
  { state: "not_ready", mask: 0x4f, value: 0x00 },
  { state: "switch_on_disabled", mask: 0x4f, value: 0x40 },
  { state: "ready", mask: 0x6f, value: 0x21 },
  { state: "switched_on", mask: 0x6f, value: 0x23 },
  { state: "enabled", mask: 0x6f, value: 0x27 },
  { state: "quick_stop", mask: 0x6f, value: 0x07 },
  { state: "fault_reaction", mask: 0x4f, value: 0x0f },
  { state: "fault", mask: 0x4f, value: 0x08 },
];

export const POWER_STATES = STATES.map((row) => row.state);

export const STATUS_BIT = {
  quickStop: 1 << 5,
  warning: 1 << 7,
  targetReached: 1 << 10,
  internalLimit: 1 << 11,
  acknowledge: 1 << 12,
} as const;

export interface Transition {
  number: number;
  from: PowerState;
  to: PowerState;
}

/** Transition 13 starts in any state without a fault. */
export const TRANSITIONS: Transition[] = [
  { number: 1, from: "not_ready", to: "switch_on_disabled" },
  { number: 2, from: "switch_on_disabled", to: "ready" },
  { number: 3, from: "ready", to: "switched_on" },
  { number: 4, from: "switched_on", to: "enabled" },
  { number: 5, from: "enabled", to: "switched_on" },
  { number: 6, from: "switched_on", to: "ready" },
  { number: 7, from: "ready", to: "switch_on_disabled" },
  { number: 8, from: "enabled", to: "ready" },
  { number: 9, from: "enabled", to: "switch_on_disabled" },
  { number: 10, from: "switched_on", to: "switch_on_disabled" },
  { number: 11, from: "enabled", to: "quick_stop" },
  { number: 12, from: "quick_stop", to: "switch_on_disabled" },
  ...(["not_ready", "switch_on_disabled", "ready", "switched_on", "enabled", "quick_stop"] as const).map(
    (from): Transition => ({ number: 13, from, to: "fault_reaction" }),
  ),
  { number: 14, from: "fault_reaction", to: "fault" },
  { number: 15, from: "fault", to: "switch_on_disabled" },
  { number: 16, from: "quick_stop", to: "enabled" },
];

export function decodePowerState(statusword: number): PowerState {
  return STATES.find((row) => (statusword & row.mask) === row.value)?.state ?? "not_ready";
}

/** @return the fewest transitions that lead from one state to the other, in order. Several may
 *          happen within one tick, of which a statusword shows only the end. */
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
