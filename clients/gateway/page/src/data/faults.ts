// SPDX-License-Identifier: Apache-2.0
// The answers of the services /faults and /fault.

import type { Of, Schema } from "../protocol/checked";

const INTEGERS = { type: "array", items: { type: "integer" } } as const;

const WINDOW = {
  type: "object",
  properties: {
    window: { type: "integer" },
    first_tick: { type: "integer" },
    last_tick: { type: "integer" },
    is_open: { type: "boolean" },
    causes: {
      type: "array",
      items: {
        type: "object",
        properties: { kind: { type: "string" }, axis: { type: "integer" }, code: { type: "integer" }, tick: { type: "integer" } },
        required: ["kind", "axis", "code", "tick"],
      },
    },
  },
  required: ["window", "first_tick", "last_tick", "is_open", "causes"],
} as const satisfies Schema;

export const WINDOWS = {
  type: "object",
  properties: { windows: { type: "array", items: WINDOW } },
  required: ["windows"],
} as const;

export const FAULT = {
  type: "object",
  properties: {
    kept: WINDOW,
    stories: {
      type: "array",
      items: {
        type: "object",
        properties: { title: { type: "string" }, lines: { type: "array", items: { type: "string" } }, remedy: { type: "string" } },
        required: ["title", "lines", "remedy"],
      },
    },
    writes: {
      type: "array",
      items: {
        type: "object",
        properties: {
          tick: { type: "integer" },
          text: { type: "string" },
          refused: { type: "boolean" },
          by: { type: "string" },
        },
        required: ["tick", "text", "refused", "by"],
      },
    },
    samples: {
      type: "object",
      properties: {
        tick: INTEGERS,
        position_demand_value: INTEGERS,
        load_position_actual_value: INTEGERS,
        load_position_error_value: INTEGERS,
        load_velocity_actual_value: INTEGERS,
        torque_actual_value: INTEGERS,
      },
      required: [
        "tick",
        "position_demand_value",
        "load_position_actual_value",
        "load_position_error_value",
        "load_velocity_actual_value",
        "torque_actual_value",
      ],
    },
  },
  required: ["kept", "stories", "writes", "samples"],
} as const;

export type KeptWindow = Of<typeof WINDOW>;
export type Fault = Of<typeof FAULT>;
export type FaultSeries = Exclude<keyof Fault["samples"], "tick">;

/** @return the windows with this axis among their causes, newest first. */
export function windowsOf(windows: KeptWindow[], axis: number): KeptWindow[] {
  return windows.filter(({ causes }) => causes.some((cause) => cause.axis === axis)).reverse();
}

/** The lowest and the highest value that a strip shows. */
export interface Scale {
  low: number;
  high: number;
}

/** @return the scale that contains all of these values. */
export function scaleOf(...lines: number[][]): Scale {
  let low = Infinity;
  let high = -Infinity;
  for (const values of lines) {
    for (const value of values) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  return { low, high };
}

/**
 * The curve of a value with one point per pixel: the lowest and highest value of the ticks that share a pixel.
 * @param values one per tick
 * @return the points of an SVG polyline: x from 0 to `width`, y from 0 at the top to `height`
 */
export function strip(values: number[], { low, high }: Scale, width: number, height: number): string {
  const span = high === low ? 1 : high - low;
  const y = (value: number) => (high === low ? height / 2 : height - ((value - low) / span) * height).toFixed(1);
  const points: string[] = [];
  const columns = Math.min(width, values.length);
  for (let column = 0; column < columns; ++column) {
    const first = Math.floor((column * values.length) / columns);
    const last = Math.max(first + 1, Math.floor(((column + 1) * values.length) / columns));
    const part = values.slice(first, last);
    const x = columns === 1 ? 0 : ((column * width) / (columns - 1)).toFixed(1);
    points.push(`${x},${y(part[0])}`);
    if (part.length > 2) points.push(`${x},${y(Math.min(...part))}`, `${x},${y(Math.max(...part))}`);
  }
  return points.join(" ");
}
