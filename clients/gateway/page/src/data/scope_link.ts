// SPDX-License-Identifier: Apache-2.0
// The contents of a scope as the query of a link, such as
// s=1.1:position_demand_value,load_position_actual_value;1.2:torque_demand&w=10&t=100,110&c=103,106

import { CONDITIONS, MODES, type Trigger } from "./trigger";

/** Signals of one axis in one strip, with one scale. */
export interface StripState {
  /** address */
  axis: string;
  /** of the status, or only SET_POINTS */
  members: string[];
}

/** The bits of the set-point handshake */
export const SET_POINTS = "set_points";

export interface ScopeState {
  strips: StripState[];
  /** [s] */
  window?: number;
  /** [s] of drive time, shown instead of the newest samples */
  range?: [number, number];
  /** [s] of drive time */
  cursors?: [number, number];
  trigger?: Trigger;
}

const DECIMALS = 6;

function seconds(value: number): string {
  return String(Number(value.toFixed(DECIMALS)));
}

function pair(text: string): [number, number] | undefined {
  const [first, second, ...more] = text.split(",").map(Number);
  return more.length === 0 && Number.isFinite(first) && Number.isFinite(second) ? [first, second] : undefined;
}

function strips(text: string): StripState[] | undefined {
  const read = text.split(";").map((strip) => /^(\d+\.\d+):(\w+(?:,\w+)*)$/.exec(strip));
  return read.every((match) => match !== null) ? read.map(([, axis, members]) => ({ axis, members: members.split(",") })) : undefined;
}

function trigger(text: string): Trigger | undefined {
  const [mode, axis = "", member = "", condition, value, before, ...words] = text.split(",");
  const found = { mode: MODES.find((name) => name === mode), condition: CONDITIONS.find((name) => name === condition) };
  const isAxis = /^\d+\.\d+$/.test(axis) && Number(before) >= 0 && Number(before) <= 1 && Number.isFinite(Number(value));
  if (found.mode === undefined || found.condition === undefined || !isAxis) return undefined;
  return { mode: found.mode, axis, member, condition: found.condition, value: Number(value), before: Number(before), text: words.join(",") };
}

/** @return the query, without its "?" */
export function formatScope(state: ScopeState): string {
  const { window, range, cursors } = state;
  const parts = [`s=${state.strips.map(({ axis, members }) => `${axis}:${members.join(",")}`).join(";")}`];
  if (window !== undefined) parts.push(`w=${window}`);
  if (range !== undefined) parts.push(`t=${range.map(seconds).join(",")}`);
  if (cursors !== undefined) parts.push(`c=${cursors.map(seconds).join(",")}`);
  if (state.trigger !== undefined) {
    const { mode, axis, member, condition, value, before, text } = state.trigger;
    parts.push(`g=${[mode, axis, member, condition, value, before, encodeURIComponent(text)].join(",")}`);
  }
  return parts.join("&");
}

function decoded(text: string): string | undefined {
  try {
    return decodeURIComponent(text);
  } catch {
    return undefined;
  }
}

/** @return the state in the query; `bad` contains the parts that cannot be parsed and are ignored */
export function parseScope(query: string): { state: Partial<ScopeState>; bad: string[] } {
  const state: Partial<ScopeState> = {};
  const bad: string[] = [];
  const readers: Record<string, (text: string) => unknown> = {
    s: (text) => (state.strips = text === "" ? [] : strips(text)),
    w: (text) => (state.window = Number(text) > 0 ? Number(text) : undefined),
    t: (text) => {
      const range = pair(text);
      return (state.range = range !== undefined && range[0] < range[1] ? range : undefined);
    },
    c: (text) => (state.cursors = pair(text)),
    g: (text) => (state.trigger = trigger(text)),
  };
  for (const part of query.split("&").filter((text) => text !== "")) {
    const [name, ...value] = part.split("=");
    const text = decoded(value.join("="));
    if (text === undefined || readers[name]?.(text) === undefined) bad.push(part);
  }
  return { state, bad };
}
