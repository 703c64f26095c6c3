// SPDX-License-Identifier: Apache-2.0
// The last minutes of one axis, every tick, reduced to a plot of any width without hiding an extreme value.

/** Samples per block. The extremes of each block are kept, so that long windows read blocks instead of samples. */
export const BLOCK = 64;
const MOST_DECIMALS = 6;

type Column = Int8Array | Uint8Array | Int16Array | Uint16Array | Int32Array | Uint32Array | Float32Array | Float64Array;
/** The array type of a series. */
export type Kind = new (length: number) => Column;

/** Points of a plot: x ascending; null is a gap. Each y is one of the requested series. */
export interface Points {
  x: number[];
  y: (number | null)[][];
}

interface Extremes {
  minimum: number;
  maximum: number;
  minimumFirst: boolean;
}

export class History {
  readonly capacity: number;
  private readonly times: Float64Array;
  private readonly values: Column[];
  private readonly blockMinimum: Column[];
  private readonly blockMaximum: Column[];
  private total = 0;
  /** numbers of the samples that follow lost ones, ascending */
  private readonly gaps = new Set<number>();

  /** @param kinds of its series
   *  @param capacity [samples], rounded up to full blocks */
  constructor(
    private readonly kinds: readonly Kind[],
    capacity: number,
  ) {
    this.capacity = Math.max(2, Math.ceil(capacity / BLOCK)) * BLOCK;
    const blocks = this.capacity / BLOCK;
    this.times = new Float64Array(this.capacity);
    const make = (length: number) => kinds.map((Values) => new Values(length));
    this.values = make(this.capacity);
    this.blockMinimum = make(blocks);
    this.blockMaximum = make(blocks);
  }

  /** Number of the oldest sample kept; counted from 0 since `clear`. */
  get first(): number {
    if (this.total <= this.capacity) return 0;
    return Math.ceil((this.total - this.capacity) / BLOCK) * BLOCK;
  }

  /** Number of the next sample. */
  get end(): number {
    return this.total;
  }

  clear(): void {
    this.total = 0;
    this.gaps.clear();
  }

  /** Samples before the next one were lost. */
  markGap(): void {
    this.gaps.add(this.total);
    for (const gap of this.gaps) {
      if (gap >= this.first) break;
      this.gaps.delete(gap);
    }
  }

  /** @param time [s], not before that of the previous sample */
  append(time: number, sample: ArrayLike<number>): void {
    const slot = this.total % this.capacity;
    const block = Math.floor(slot / BLOCK);
    const starts = slot % BLOCK === 0;
    this.times[slot] = time;
    for (let s = 0; s < this.kinds.length; ++s) {
      const value = sample[s];
      this.values[s][slot] = value;
      if (starts || value < this.blockMinimum[s][block]) this.blockMinimum[s][block] = value;
      if (starts || value > this.blockMaximum[s][block]) this.blockMaximum[s][block] = value;
    }
    ++this.total;
  }

  time(number: number): number {
    return this.times[number % this.capacity];
  }

  value(series: number, number: number): number {
    return this.values[series][number % this.capacity];
  }

  /** @return the number of the first sample at or after `time`; `end` if there is none. */
  lowerBound(time: number): number {
    let low = this.first;
    let high = this.total;
    while (low < high) {
      const middle = Math.floor((low + high) / 2);
      if (this.time(middle) < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** @return the number of the sample nearest to `time`, or undefined without samples. */
  nearest(time: number): number | undefined {
    if (this.first === this.total) return undefined;
    const after = this.lowerBound(time);
    if (after === this.first) return after;
    if (after === this.total) return after - 1;
    return time - this.time(after - 1) <= this.time(after) - time ? after - 1 : after;
  }

  /** The samples from `from` to `to` [s] with at most two points per column: if a column has more samples, the
   *  minimum and maximum of each series, in their order. Columns are at fixed times, so that a scrolling plot does
   *  not flicker.
   *  @param wanted series */
  points(from: number, to: number, columns: number, wanted: readonly number[]): Points {
    const start = Math.max(this.first, this.lowerBound(from) - 1);
    const end = Math.min(this.total, this.lowerBound(to) + 1);
    const count = end - start;
    if (count <= 3 * columns) return this.samples(start, end, wanted);
    const width = (to - from) / columns;
    return this.columns(start, end, width, count / columns >= 2 * BLOCK ? BLOCK : 1, wanted);
  }

  private samples(start: number, end: number, wanted: readonly number[]): Points {
    const points: Points = { x: [], y: wanted.map(() => []) };
    for (let n = start; n < end; ++n) {
      if (n > start && this.gaps.has(n)) this.addGap(points, (this.time(n - 1) + this.time(n)) / 2);
      points.x.push(this.time(n));
      wanted.forEach((s, i) => points.y[i].push(this.value(s, n)));
    }
    return points;
  }

  private columns(start: number, end: number, width: number, step: number, wanted: readonly number[]): Points {
    const points: Points = { x: [], y: wanted.map(() => []) };
    const columnOf = (n: number) => Math.floor(this.time(n) / width);
    let n = step === 1 ? start : Math.floor(start / step) * step;
    if (n < this.first) n = this.first;
    let before = 0;
    while (n < end) {
      const column = columnOf(n);
      const begin = n;
      while (n < end && columnOf(n) === column) n += step;
      // Here each column has several samples, so an empty one means that samples were lost.
      if (begin > start && column > before + 1) this.addGap(points, (before + 1) * width);
      before = column;
      points.x.push((column + 0.25) * width, (column + 0.75) * width);
      wanted.forEach((s, i) => {
        const found = this.extremes(s, begin, Math.min(n, this.total), step);
        if (found.minimumFirst) points.y[i].push(found.minimum, found.maximum);
        else points.y[i].push(found.maximum, found.minimum);
      });
    }
    return points;
  }

  private extremes(series: number, begin: number, end: number, step: number): Extremes {
    const low = step === 1 ? this.values[series] : this.blockMinimum[series];
    const high = step === 1 ? this.values[series] : this.blockMaximum[series];
    const places = this.capacity / step;
    const count = Math.ceil((end - begin) / step);
    let at = Math.floor((begin % this.capacity) / step);
    let lowAt = 0;
    let highAt = 0;
    let minimum = Infinity;
    let maximum = -Infinity;
    for (let i = 0; i < count; ++i) {
      if (low[at] < minimum) {
        minimum = low[at];
        lowAt = i;
      }
      if (high[at] > maximum) {
        maximum = high[at];
        highAt = i;
      }
      if (++at === places) at = 0;
    }
    return { minimum, maximum, minimumFirst: lowAt <= highAt };
  }

  private addGap(points: Points, time: number): void {
    points.x.push(time);
    for (const line of points.y) line.push(null);
  }
}

/** @return limits of an axis around the values: round, and at least `least` apart. */
export function niceRange(minimum: number, maximum: number, least: number): [number, number] {
  if (!Number.isFinite(minimum) || !Number.isFinite(maximum)) return [-least / 2, least / 2];
  const middle = (minimum + maximum) / 2;
  const span = Math.max(maximum - minimum, least) * 1.1;
  const power = Math.pow(10, Math.floor(Math.log10(span / 4)));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => span / size <= 8) ?? 10 * power;
  return [
    Math.floor((middle - span / 2) / step) * step,
    Math.ceil((middle + span / 2) / step) * step,
  ];
}

/** The decimals needed to show neighbouring labels of an axis without rounding: 1 for steps of 2.5. */
export function labelDecimals(labels: number[]): number {
  const step = labels.length < 2 ? 1 : Math.abs(labels[1] - labels[0]);
  const isWhole = (value: number) => Math.abs(value - Math.round(value)) < 1e-6 * value;
  let decimals = 0;
  while (decimals < MOST_DECIMALS && !isWhole(step * 10 ** decimals)) ++decimals;
  return decimals;
}
