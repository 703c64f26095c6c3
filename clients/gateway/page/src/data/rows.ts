// SPDX-License-Identifier: Apache-2.0
// The filter and order of the axes in the overview.

import { isFault, type PowerState } from "./power";

/** The values used by filters and orders. */
export interface Row {
  bench: number;
  axis: number;
  name: string;
  state: PowerState;
  mode: number;
  /** [UU] */
  position: number;
  /** [UU/s] */
  velocity: number;
  /** [permille of the rated torque] */
  torque: number;
  /** [UU] */
  error: number;
  /** "" = none */
  owner: string;
  fault: number;
  moving: boolean;
  /** [ms] */
  age: number;
}

export interface Filter {
  text: string;
  bench: number | undefined;
  faulted: boolean;
  moving: boolean;
  owned: boolean;
}

export type SortKey =
  | "address"
  | "name"
  | "state"
  | "mode"
  | "position"
  | "velocity"
  | "torque"
  | "error"
  | "owner"
  | "fault"
  | "age";

export interface Order {
  key: SortKey;
  descending: boolean;
}

const SEVERITY: Record<PowerState, number> = {
  fault: 0,
  fault_reaction_active: 1,
  quick_stop_active: 2,
  operation_enabled: 3,
  switched_on: 4,
  ready_to_switch_on: 5,
  switch_on_disabled: 6,
  not_ready_to_switch_on: 7,
};

/** @return the words of a search, in lower case. */
export function wordsOf(text: string): string[] {
  return text.toLowerCase().split(/\s+/).filter((word) => word !== "");
}

/** Each word must occur in the name, or be a prefix of the address. */
export function nameMatches(address: string, name: string, words: string[]): boolean {
  const lower = name.toLowerCase();
  return words.every((word) => lower.includes(word) || address.startsWith(word));
}

export function matches(row: Row, filter: Filter): boolean {
  if (filter.bench !== undefined && row.bench !== filter.bench) return false;
  const faulted = isFault(row.state);
  if (filter.faulted && !faulted) return false;
  if (filter.moving && !row.moving) return false;
  if (filter.owned && row.owner === "") return false;
  return nameMatches(`${row.bench}.${row.axis}`, row.name, wordsOf(filter.text));
}

function compareBy(key: SortKey, a: Row, b: Row): number {
  switch (key) {
    case "address":
      return 0;
    case "name":
      return a.name.localeCompare(b.name, undefined, { numeric: true });
    case "owner":
      return a.owner < b.owner ? -1 : a.owner > b.owner ? 1 : 0;
    case "state":
      return SEVERITY[a.state] - SEVERITY[b.state];
    case "velocity":
    case "torque":
    case "error":
      return Math.abs(a[key]) - Math.abs(b[key]);
    default:
      return a[key] - b[key];
  }
}

/** @return the rows in order; equal ones in the order of their addresses. Speeds, torques and errors are ordered by
 *          magnitude. */
export function sorted<T extends Row>(rows: readonly T[], order: Order): T[] {
  const sign = order.descending ? -1 : 1;
  return [...rows].sort(
    (a, b) =>
      sign * compareBy(order.key, a, b) ||
      (order.key === "address" ? sign : 1) * (a.bench - b.bench || a.axis - b.axis),
  );
}
