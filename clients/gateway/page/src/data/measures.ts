// SPDX-License-Identifier: Apache-2.0
// Measurements of a part of a signal, between two cursors.

/** Samples `begin` to `end`, excluding `end`. */
export interface Part {
  begin: number;
  end: number;
  /** [s] */
  time: (sample: number) => number;
  value: (sample: number) => number;
}

export interface Extent {
  minimum: number;
  maximum: number;
  mean: number;
}

/** A signal that moves from its first value to another one and stays there. */
export interface StepResponse {
  /** [s] from 10 % to 90 % of the step */
  rise: number;
  /** fraction of the step, 0 = none */
  overshoot: number;
  /** [s] from the first sample until the signal stays within SETTLED of its final value */
  settling: number;
}

/** fraction of the step */
const SETTLED = 0.02;
/** The mean of the last samples is the final value. */
const END_SHARE = 0.05;
const FEWEST_SAMPLES = 20;
/** An overshoot of more than the height of the step means that it is not a step. */
const MOST_OVERSHOOT = 1;

/** @return undefined if there are no samples */
export function extentOf({ begin, end, value }: Part): Extent | undefined {
  if (end <= begin) return undefined;
  let minimum = Infinity;
  let maximum = -Infinity;
  let sum = 0;
  for (let n = begin; n < end; ++n) {
    const here = value(n);
    if (here < minimum) minimum = here;
    if (here > maximum) maximum = here;
    sum += here;
  }
  return { minimum, maximum, mean: sum / (end - begin) };
}

/** @return undefined if the signal is not a step */
export function stepResponseOf(part: Part): StepResponse | undefined {
  const { begin, end, time, value } = part;
  if (end - begin < FEWEST_SAMPLES) return undefined;
  const tail = Math.max(1, Math.floor((end - begin) * END_SHARE));
  const first = value(begin);
  const last = extentOf({ ...part, begin: end - tail })?.mean ?? first;
  if (last === first) return undefined;
  const share = (n: number): number => (value(n) - first) / (last - first);
  let peak = 0;
  let lowest = 0;
  let settled = begin;
  for (let n = begin; n < end; ++n) {
    const here = share(n);
    peak = Math.max(peak, here);
    lowest = Math.min(lowest, here);
    if (Math.abs(here - 1) > SETTLED) settled = n + 1;
  }
  const isStep = settled <= end - tail && peak - 1 <= MOST_OVERSHOOT && lowest >= -MOST_OVERSHOOT;
  if (!isStep) return undefined;
  /** interpolated between the samples on both sides of the crossing */
  const crossing = (level: number): number => {
    let n = begin;
    while (n < end - 1 && share(n) < level) ++n;
    if (n === begin) return time(n);
    const before = share(n - 1);
    return time(n - 1) + ((level - before) / (share(n) - before)) * (time(n) - time(n - 1));
  };
  return { rise: crossing(0.9) - crossing(0.1), overshoot: Math.max(0, peak - 1), settling: time(settled) - time(begin) };
}
