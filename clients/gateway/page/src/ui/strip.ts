// SPDX-License-Identifier: Apache-2.0
// One strip of a scope: signals of one axis in one plot, with one scale.

import uPlot from "uplot";
import { labelDecimals, niceRange, type Points } from "../data/history";
import type { Samples } from "../data/samples";
import { isDemand, type Quantity } from "../data/signals";
import { formatTime } from "../data/times";
import { formatNumber, toShown } from "../data/units";
import { t } from "../i18n";
import { colour, h, put } from "./dom";

export const AXIS_WIDTH = 78;
export const RIGHT_MARGIN = 14;
export const TIME_AXIS_HEIGHT = 22;
const LINE_DASH = [5, 4];
const SYNC = "scope";
/** [s] between the lines of the time axis, as on a clock */
const TIME_STEPS = [
  ...[1e-4, 1e-3, 1e-2, 0.1].flatMap((power) => [power, 2 * power, 5 * power]),
  1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 1_200, 3_600,
];
const TIME_SPACE = 76; // [px] for 14:03:27.250
const LAST_RUN_ALPHA = 0.4;
const LEGEND_LINE = 19; // [px] for two dashes
const LEGEND_GAP = 14; // [px]

/** Settings shared by all strips of a scope. */
export interface Shown {
  /** [s] of drive time */
  from: number;
  to: number;
  /** [s] of drive time at time 0 of the plots: a full hour, so that round times of the plots are round drive times */
  origin: number;
  columns: number;
  /** [s] between the last run and the present one; undefined while the last run is not shown */
  lastRun: number | undefined;
}

export interface Signal {
  member: string;
  title: string;
}

interface Line extends Signal {
  colour: string;
  dashed: boolean;
  reading: HTMLElement;
}

/** Colours of signals that are not demands, assigned from the last such signal to the first. If there are more signals
 *  than colours, the remaining signals share the last colour. */
const COLOURS = ["line-1", "line-3", "line-4"];

function linesOf(signals: readonly Signal[]): Line[] {
  const actual = signals.filter(({ member }) => !isDemand(member)).reverse();
  return signals.map((signal) => {
    const dashed = isDemand(signal.member);
    const named = dashed ? "line-2" : COLOURS[Math.min(actual.indexOf(signal), COLOURS.length - 1)];
    return { ...signal, dashed, colour: named, reading: h("span", { class: "number" }, "–") };
  });
}

/** The scope of a strip, as the strip sees it. */
export interface Listener {
  draw(strip: PlotStrip, isFirst: boolean): void;
  cursor(plot: uPlot): void;
  select(plot: uPlot): void;
  made(plot: uPlot): void;
  origin(): number;
}

export class PlotStrip {
  readonly root: HTMLElement;
  readonly plot: uPlot;
  readonly lines: Line[];
  private readonly problem = h("p", { class: "problem" });
  private scaleRange: [number, number] = [0, 0];
  /** of the last run */
  private shadow?: Points;

  /** @param head shown before the signals: the axis
   *  @param tools shown after them */
  constructor(
    readonly samples: Samples,
    signals: readonly Signal[],
    private readonly quantity: Quantity,
    /** isFirst: first plot of its axis; isLast: last plot of the scope */
    place: { isFirst: boolean; isLast: boolean },
    head: Node[],
    tools: Node[],
    private readonly listener: Listener,
  ) {
    this.lines = linesOf(signals);
    const canvas = h("div", { class: "canvas", attributes: { role: "img", "aria-label": signals.map(({ title }) => title).join(", ") } });
    const readings = this.lines.map((line) =>
      h("span", { class: "reading" }, h("i", { class: `sample ${line.colour}${line.dashed ? " dashed" : ""}` }), line.title, line.reading),
    );
    readings.at(-1)?.append(h("span", { class: "unit" }, quantity.unit)); // not on a separate line
    this.root = h("div", { class: "plot" }, h("div", { class: "plot-head" }, ...head, ...readings, ...tools), canvas, this.problem);
    this.problem.hidden = true;
    this.plot = this.make(canvas, place);
  }

  get unit(): string {
    return this.quantity.unit;
  }

  close(): void {
    this.plot.destroy();
  }

  draw({ from, to, origin, columns, lastRun }: Shown): void {
    const missing = this.lines.filter(({ member }) => this.series(member) === undefined).map(({ member }) => member);
    const isKnown = this.samples.members.length > 0;
    put(this.problem, isKnown && missing.length > 0 ? `${this.samples.axis.address} ${t("no_signal")} ${missing.join(", ")}` : "");
    this.problem.hidden = this.problem.textContent === "";
    const points = this.points(from, to, columns, 0);
    this.shadow = lastRun === undefined ? undefined : this.points(from - lastRun, to - lastRun, columns, lastRun);
    const shift = this.samples.origin - origin;
    for (const moved of [points, this.shadow]) if (moved !== undefined && shift !== 0) moved.x = moved.x.map((time) => time + shift);
    this.fitScale(points);
    this.plot.batch(() => {
      this.plot.setData([points.x, ...points.y] as uPlot.AlignedData, false);
      this.plot.setScale("x", { min: from - origin, max: to - origin });
      this.plot.setScale("y", { min: this.scaleRange[0], max: this.scaleRange[1] });
    });
  }

  /** @param time [s] of drive time */
  show(time: number): void {
    const { history, origin } = this.samples;
    const number = history.nearest(time - origin);
    for (const { member, reading } of this.lines) {
      const series = this.series(member);
      const isThere = number !== undefined && series !== undefined && number >= history.first;
      put(reading, isThere ? this.text(history.value(series, number)) : "–");
    }
  }

  series(member: string): number | undefined {
    return this.samples.series(member);
  }

  /** @param value in the unit of the drive */
  shown(value: number): number {
    return toShown(value, this.quantity.scale);
  }

  /** @param value in the unit of the drive */
  text(value: number): string {
    return formatNumber(this.shown(value), this.quantity.scale.decimals);
  }

  /** Draws each line with its name. @param bottom of the letters */
  drawLegend(context: CanvasRenderingContext2D, left: number, bottom: number, ratio: number): void {
    context.save();
    context.lineWidth = 2 * ratio;
    for (const line of this.lines) {
      left += LEGEND_GAP * ratio;
      context.strokeStyle = colour(line.colour);
      context.setLineDash(line.dashed ? LINE_DASH.map((length) => length * ratio) : []);
      context.beginPath();
      context.moveTo(left, bottom - 4 * ratio);
      context.lineTo(left + LEGEND_LINE * ratio, bottom - 4 * ratio);
      context.stroke();
      left += (LEGEND_LINE + 6) * ratio;
      context.fillText(line.title, left, bottom);
      left += context.measureText(line.title).width;
    }
    context.restore();
  }

  /** In the unit shown; empty for missing members. @param later [s] by which they are shifted */
  private points(from: number, to: number, columns: number, later: number): Points {
    const { history, origin } = this.samples;
    const places = this.lines.map(({ member }) => this.series(member));
    const found = history.points(from - origin, to - origin, columns, places.filter((place) => place !== undefined));
    let next = 0;
    const y = places.map((place) => {
      if (place === undefined) return found.x.map(() => null);
      return found.y[next++].map((value) => (value === null ? null : this.shown(value)));
    });
    return { x: later === 0 ? found.x : found.x.map((time) => time + later), y };
  }

  /** Keeps a scale that would shrink only a little, so that the picture does not jump. */
  private fitScale(points: Points): void {
    let low = Infinity;
    let high = -Infinity;
    for (const values of [...points.y, ...(this.shadow?.y ?? [])]) {
      for (const value of values) {
        if (value === null) continue;
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    const [bottom, top] = niceRange(low, high, this.quantity.least * this.quantity.scale.factor);
    const [oldBottom, oldTop] = this.scaleRange;
    const keeps = bottom >= oldBottom && top <= oldTop && top - bottom > 0.5 * (oldTop - oldBottom);
    if (!keeps) this.scaleRange = [bottom, top];
  }

  private make(host: HTMLElement, { isFirst, isLast }: { isFirst: boolean; isLast: boolean }): uPlot {
    const axis = {
      stroke: () => colour("muted"),
      grid: { stroke: () => colour("grid"), width: 1 },
      ticks: { stroke: () => colour("grid"), width: 1, size: 4 },
      font: "11px system-ui, sans-serif",
    };
    const time = (value: number, all: number[]) => formatTime(value + this.listener.origin(), labelDecimals(all));
    const options: uPlot.Options = {
      width: 400,
      height: 120,
      padding: [5, RIGHT_MARGIN, isLast ? 0 : 5, 0],
      legend: { show: false },
      cursor: {
        sync: { key: SYNC },
        drag: { x: true, y: false, setScale: false },
        points: { show: false },
        bind: { mousedown: (_plot, _target, select) => (event) => (event.button === 0 && event.shiftKey ? select(event) : null) },
      },
      scales: { x: { time: false, auto: false }, y: { auto: false } },
      axes: [
        {
          ...axis,
          size: isLast ? TIME_AXIS_HEIGHT : 0,
          space: TIME_SPACE,
          incrs: TIME_STEPS,
          values: (_, values) => values.map((value) => (isLast ? time(value, values) : "")),
        },
        { ...axis, size: AXIS_WIDTH, space: 20, gap: 4, values: (_, values) => values.map((v) => formatNumber(v, labelDecimals(values))) },
      ],
      series: [
        {},
        ...this.lines.map((line) => ({
          stroke: () => colour(line.colour),
          width: 1.25,
          dash: line.dashed ? LINE_DASH : undefined,
          points: { show: false },
        })),
      ],
      hooks: {
        setCursor: [(plot) => this.listener.cursor(plot)],
        setSelect: [(plot) => this.listener.select(plot)],
        draw: [
          (plot) => this.drawShadow(plot),
          () => this.listener.draw(this, isFirst),
        ],
      },
    };
    const plot = new uPlot(options, [[], ...this.lines.map(() => [])], host);
    this.listener.made(plot);
    return plot;
  }

  /** The last run, with the same scale. */
  private drawShadow({ ctx, bbox, valToPos }: uPlot): void {
    const { shadow } = this;
    if (shadow === undefined) return;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.globalAlpha = LAST_RUN_ALPHA;
    ctx.lineWidth = 1.25 * (window.devicePixelRatio || 1);
    this.lines.forEach((line, i) => {
      ctx.strokeStyle = colour(line.colour);
      ctx.beginPath();
      let isDown = false;
      shadow.x.forEach((time, at) => {
        const value = shadow.y[i][at];
        if (value !== null) {
          const [x, y] = [valToPos(time, "x", true), valToPos(value, "y", true)];
          if (isDown) ctx.lineTo(x, y);
          else ctx.moveTo(x, y);
        }
        isDown = value !== null;
      });
      ctx.stroke();
    });
    ctx.restore();
  }
}
