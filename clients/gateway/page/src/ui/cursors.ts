// SPDX-License-Identifier: Apache-2.0
// Two cursors across the strips of a scope, and measurements between them.

import { extentOf, stepResponseOf, type Part } from "../data/measures";
import { formatTime, timeText } from "../data/times";
import { formatNumber } from "../data/units";
import { t } from "../i18n";
import { h } from "./dom";
import { AXIS_WIDTH, RIGHT_MARGIN, type PlotStrip, type Shown } from "./strip";

const NAMES = ["A", "B"] as const;
const STEPS: Record<string, number> = { ArrowLeft: -1, ArrowRight: 1, PageDown: -20, PageUp: 20 };
/** Long parts have a million samples, so they are not measured in each frame of a drag. */
const MEASURE_EVERY_MS = 100;
const TIME_DECIMALS = 4;
const MEASURES = ["minimum", "maximum", "mean", "rise", "overshoot", "settling"] as const;
const NUMBERS = 3 + MEASURES.length;

export interface Axis {
  /** of the window [px] */
  width(): number;
  /** [s] of drive time */
  range(): [number, number];
  /** @param left [px] in the window @return [s] of drive time */
  timeAt(left: number): number;
  changed(): void;
}

export class Cursors {
  readonly handles: HTMLElement[];
  readonly table = h("table", { class: "cursor-table", attributes: { "data-test": "cursors" } });
  /** scroll container of the table */
  readonly root = h("div", { class: "cursor-measures", attributes: { tabindex: "0", role: "region", "aria-label": t("two_cursors") } }, this.table);
  /** [s] of drive time, while they are shown */
  times?: [number, number];
  private measured = "";
  private measuredAt = -Infinity;

  constructor(private readonly axis: Axis) {
    this.handles = NAMES.map((name, which) => this.makeHandle(name, which));
    this.root.hidden = true;
  }

  show(times: [number, number] | undefined): void {
    this.times = times;
    this.root.hidden = times === undefined;
    this.measured = "";
  }

  /** Moves the nearer cursor to where the user clicked. */
  bring(time: number): void {
    if (this.times === undefined) return;
    const [a, b] = this.times;
    this.move(Math.abs(a - time) <= Math.abs(b - time) ? 0 : 1, time);
  }

  place({ from, to }: Shown): void {
    const width = this.axis.width() - AXIS_WIDTH - RIGHT_MARGIN;
    this.handles.forEach((handle, which) => {
      const time = this.times?.[which];
      handle.hidden = time === undefined || time < from || time > to;
      if (time === undefined) return;
      handle.style.left = `${AXIS_WIDTH + ((time - from) / (to - from)) * width}px`;
      handle.setAttribute("aria-valuemin", String(from));
      handle.setAttribute("aria-valuemax", String(to));
      handle.setAttribute("aria-valuenow", String(time));
      handle.setAttribute("aria-valuetext", timeText(time));
    });
  }

  /** Shows the samples at A and B, their differences, and measurements between them.
   *  @param named whether the axes must be distinguished */
  measure(strips: readonly PlotStrip[], named: boolean, now: number): void {
    if (this.times === undefined || now - this.measuredAt < MEASURE_EVERY_MS) return;
    const wanted = `${this.times.join()} ${strips.map(({ samples, unit }) => `${samples.history.end} ${unit}`).join()}`;
    if (wanted === this.measured) return;
    this.measured = wanted;
    this.measuredAt = now;
    const [a, b] = this.times;
    const heads = ["A", "B", "B − A", ...MEASURES.map((key) => t(key))].map((text) => h("th", { attributes: { scope: "col" } }, text));
    const times = [formatTime(a, 3), formatTime(b, 3), formatNumber(b - a, TIME_DECIMALS)];
    const rows = [row(t("time"), times, "s"), ...strips.flatMap((strip) => this.rowsOf(strip, named))];
    this.table.replaceChildren(
      h("thead", {}, h("tr", { title: t("measures_hint") }, h("td", {}), ...heads, h("td", {}))),
      h("tbody", {}, ...rows),
    );
  }

  private rowsOf(strip: PlotStrip, named: boolean): HTMLElement[] {
    const { samples } = strip;
    const { history, origin } = samples;
    const [a, b] = (this.times ?? [0, 0]).map((time) => history.nearest(time - origin));
    if (a === undefined || b === undefined) return [];
    return strip.lines.flatMap(({ member, title }) => {
      const series = samples.series(member);
      if (series === undefined) return [];
      const raw = (n: number) => history.value(series, n);
      const part: Part = { begin: Math.min(a, b), end: Math.max(a, b) + 1, time: (n) => history.time(n), value: raw };
      const extent = extentOf(part);
      const step = stepResponseOf(part);
      const level = (value: number | undefined) => (value === undefined ? "–" : strip.text(value));
      const cells = [
        ...[raw(a), raw(b), raw(b) - raw(a), extent?.minimum, extent?.maximum, extent?.mean].map(level),
        step === undefined ? "–" : `${formatNumber(step.rise, TIME_DECIMALS)} s`,
        step === undefined ? "–" : `${formatNumber(step.overshoot * 100, 1)} %`,
        step === undefined ? "–" : `${formatNumber(step.settling, TIME_DECIMALS)} s`,
      ];
      return [row(named ? `${samples.axis.address} ${title}` : title, cells, strip.unit)];
    });
  }

  private move(which: number, time: number): void {
    if (this.times === undefined) return;
    const [from, to] = this.axis.range();
    this.times[which] = Math.min(to, Math.max(from, time));
    this.axis.changed();
  }

  private makeHandle(name: string, which: number): HTMLElement {
    const handle = h("span", {
      class: "cursor-handle",
      attributes: { role: "slider", tabindex: "0", "aria-label": `${t("cursor")} ${name}`, "aria-valuenow": "0", "data-test": `cursor-${name}` },
    }, name);
    handle.hidden = true;
    handle.addEventListener("keydown", (event) => {
      const step = STEPS[event.key];
      if (step === undefined || this.times === undefined) return;
      event.preventDefault();
      const [from, to] = this.axis.range();
      this.move(which, this.times[which] + (step * (to - from)) / Math.max(1, this.axis.width() - AXIS_WIDTH - RIGHT_MARGIN));
    });
    handle.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      handle.focus();
      handle.setPointerCapture(event.pointerId);
    });
    handle.addEventListener("pointermove", (event) => {
      if (handle.hasPointerCapture(event.pointerId)) this.move(which, this.axis.timeAt(event.clientX));
    });
    return handle;
  }
}

function row(head: string, cells: string[], unit: string): HTMLElement {
  const all = [...cells, ...Array<string>(NUMBERS - cells.length).fill("")];
  return h("tr", {}, h("th", { attributes: { scope: "row" } }, head), ...all.map((cell) => h("td", { class: "number" }, cell)), h("td", { class: "unit" }, unit));
}
