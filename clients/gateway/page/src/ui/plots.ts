// SPDX-License-Identifier: Apache-2.0
// Live plots of one axis over one time axis, with the handshake of set-points under them.

import uPlot from "uplot";
import { labelDecimals, niceRange, type Points } from "../data/history";
import { marksOf, type Mark, type MarkKind } from "../data/moments";
import { hasHandshake } from "../data/setpoints";
import { formatTime, isoDate, timeText } from "../data/times";
import { formatHex, formatNumber, toShown, USER_UNITS, type Scale } from "../data/units";
import { stateName, t, type TextKey } from "../i18n";
import { addressOf, type Model } from "../model";
import { LONGEST_WINDOW_S, MEMBERS, seriesAt, type Series, type Trace } from "../trace";
import { ErrorWindow } from "./error_window";
import { button, colour, download, fit, h, mark, put, select, type View } from "./dom";

interface Line {
  series: Series;
  text: TextKey;
  part: TextKey;
  colour: string;
  dashed?: boolean;
}

interface PlotKind {
  text: TextKey;
  unit: "position" | "velocity" | "permille";
  lines: Line[];
  /** least height of the scale [UU, UU/s, permille] */
  least: number;
}

const PLOTS: PlotKind[] = [
  {
    text: "position",
    unit: "position",
    least: 20,
    lines: [
      { series: "position_demand_value", text: "position", part: "demand", colour: "line-2", dashed: true },
      { series: "load_position_actual_value", text: "position", part: "actual", colour: "line-1" },
    ],
  },
  {
    text: "velocity",
    unit: "velocity",
    least: 200,
    lines: [
      { series: "motor_velocity_actual_value", text: "velocity", part: "motor", colour: "line-3" },
      { series: "load_velocity_actual_value", text: "velocity", part: "load", colour: "line-1" },
      { series: "velocity_demand_value", text: "velocity", part: "demand", colour: "line-2", dashed: true },
    ],
  },
  {
    text: "following_error",
    unit: "position",
    least: 10,
    lines: [{ series: "load_position_error_value", text: "following_error", part: "actual", colour: "line-1" }],
  },
  {
    text: "torque_and_current",
    unit: "permille",
    least: 100,
    lines: [
      { series: "current_actual_value", text: "current", part: "current", colour: "line-3" },
      { series: "torque_actual_value", text: "torque", part: "torque", colour: "line-1" },
      { series: "torque_demand", text: "torque", part: "demand", colour: "line-2", dashed: true },
    ],
  },
];
const WINDOWS = [1, 2, 5, 10, 30, 60, 120, 300, LONGEST_WINDOW_S];
const LINE_DASH = [5, 4];
const LEGEND_LINE = 19; // [px] two dashes
const LEGEND_GAP = 14; // [px]
const AXIS_WIDTH = 78;
const RIGHT_MARGIN = 14;
const TIME_AXIS_HEIGHT = 22;
const LEAST_HEIGHT = 92; // [px] of a plot: with less nothing is seen
const MARGIN = 10; // [px] of the window around the plots
/** `number`: of a bit that the handshake of set-points uses, and other modes in their own way */
const BITS: { series: Series; text: TextKey; number?: number }[] = [
  { series: "new_set_point", text: "bit4", number: 4 },
  { series: "acknowledge", text: "bit12", number: 12 },
  { series: "reached", text: "bit10" },
];
const STRIP_ROW = 20;
const PERMILLE: Scale = { name: "%", factor: 0.1, decimals: 1 };
const SYNC = "axis";
/** [s] between the lines of the time axis: those that a clock has */
const TIME_STEPS = [
  ...[1e-4, 1e-3, 1e-2, 0.1].flatMap((power) => [power, 2 * power, 5 * power]),
  1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 1_200, 3_600,
];
const TIME_SPACE = 76; // [px] of 14:03:27.250
/** Kinds are told apart without colours, too. */
const MARK_DASHES: Record<MarkKind, number[]> = { fault: [], state: [2, 3], event: [7, 4] };
const MARK_KINDS: readonly MarkKind[] = ["state", "fault", "event"];
/** [px] A mark that is nearer to the pointer is named. */
const MARK_REACH = 6;
const MARK_ROOM = 4; // [px] of a mark that is no fault
const LABEL_SPACE = 44; // [px] of 8611h
const CURSORS = ["A", "B"] as const;
const CURSOR_STEPS: Record<string, number> = { ArrowLeft: -1, ArrowRight: 1, PageDown: -20, PageUp: 20 };
/** [px] a shorter way is a click */
const LEAST_DRAG = 4;

function windowText(seconds: number): string {
  return seconds < 60 ? `${seconds} s` : `${seconds / 60} min`;
}

interface Drawn {
  kind: PlotKind;
  plot: uPlot;
  host: HTMLElement;
  readings: HTMLElement[];
  unit: HTMLElement;
  range: [number, number];
}

export class Plots implements View {
  readonly root: HTMLElement;
  private readonly drawn: Drawn[];
  private readonly strip: HTMLCanvasElement;
  private readonly cursorText: HTMLElement;
  private readonly lostText: HTMLElement;
  private readonly heldText = h("span", { class: "number", attributes: { "data-test": "set-points" } }, "–");
  private readonly pauseButton: HTMLButtonElement;
  private readonly resetButton: HTMLButtonElement;
  private readonly observer: ResizeObserver;
  private readonly errorWindow: ErrorWindow;
  private readonly cursorButton: HTMLButtonElement;
  private readonly handles: HTMLElement[];
  private readonly cursorTable = h("table", { class: "cursor-table", attributes: { "data-test": "cursors" } });
  /** times of A and B, while they are shown */
  private cursors?: [number, number];
  private marks: Mark[] = [];
  /** time of the event that a person went to */
  private wentTo?: number;
  private eventsVersion = -1;
  private width = 0;
  private height = 0;
  private paused = false;
  /** [s] shown instead of the newest window */
  private zoomed?: [number, number];
  private pausedAt = 0;
  /** [px] in the plots; under it another time passes while they run */
  private cursorLeft = -1;
  private drawnEnd = -1;
  private drawnAt = 0;
  private dirty = true;
  private points: Points = { x: [], y: [] };

  constructor(
    private readonly model: Model,
    private readonly trace: Trace,
  ) {
    this.errorWindow = new ErrorWindow(model, trace.ref);
    this.cursorText = h("span", { class: "cursor-text" });
    this.lostText = h("span", { class: "lost-text" });
    this.pauseButton = button(t("pause_plots"), () => this.pause(!this.paused), {
      class: "toggle",
      attributes: { "aria-pressed": "false", "data-test": "pause" },
    });
    this.cursorButton = button(t("two_cursors"), () => this.showCursors(this.cursors === undefined), {
      class: "toggle",
      title: t("two_cursors_hint"),
      attributes: { "aria-pressed": "false", "data-test": "two_cursors" },
    });
    this.handles = CURSORS.map((name, which) => this.makeHandle(name, which));
    this.cursorTable.hidden = true;
    this.resetButton = button(t("reset_zoom"), () => this.zoom(undefined));
    this.resetButton.disabled = true;
    this.strip = h("canvas", { class: "strip", attributes: { role: "img", "aria-label": t("handshake") } });
    const hosts = PLOTS.map((kind) => this.makeHost(kind));
    const stripHost = h("div", { class: "plot strip-host" }, this.stripHead(), this.strip);
    this.root = h(
      "section",
      { class: "plots panel" },
      this.tools(),
      this.cursorTable,
      ...hosts.map((host) => host.host),
      stripHost,
    );
    // Not in the picture of the plot: what is in a picture cannot be reached.
    hosts[0].host.append(...this.handles);
    this.drawn = hosts.map((host, i) => ({ ...host, plot: this.makePlot(host.kind, host.canvas, i === hosts.length - 1) }));
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(this.root);
    document.addEventListener("keydown", this.onKey);
  }

  redraw(): void {
    this.dirty = true;
  }

  close(): void {
    this.observer.disconnect();
    document.removeEventListener("keydown", this.onKey);
    for (const { plot } of this.drawn) plot.destroy();
  }

  update(now: number): void {
    const [from, to] = this.range();
    const columns = Math.max(50, this.width - AXIS_WIDTH - RIGHT_MARGIN);
    // Long windows move by less than a pixel a frame.
    const every = Math.min(250, ((to - from) / columns) * 1000);
    const isOld = this.trace.history.end !== this.drawnEnd || this.model.events.version !== this.eventsVersion;
    const fresh = !this.paused && this.zoomed === undefined && isOld;
    if (this.width > 0 && (this.dirty || (fresh && now - this.drawnAt >= every))) {
      this.dirty = false;
      this.drawnAt = now;
      this.drawnEnd = this.trace.history.end;
      this.eventsVersion = this.model.events.version;
      this.points = this.trace.history.points(from, to, columns);
      this.marks = this.model.settings.marks ? this.marksBetween(from, to) : [];
      for (const drawn of this.drawn) this.draw(drawn, from, to);
      this.drawStrip(from, to);
      this.placeHandles(from, to);
      this.showDifferences();
    }
    this.showReadings();
    this.errorWindow.update(now);
  }

  /** Shows what was then, in the middle of the window. */
  goTo(tick: number): void {
    const { history } = this.trace;
    const time = this.trace.timeOf(tick);
    const begin = history.end === 0 ? Infinity : history.time(history.first);
    if (time === undefined || time < begin || time > this.trace.now) {
      this.model.outcome = { ok: false, text: `${timeText(tick * this.trace.period)}: ${t("no_samples")}` };
      return;
    }
    const half = this.model.settings.window / 2;
    this.zoom([time - half, time + half]);
    this.wentTo = time;
    this.root.scrollIntoView({ block: "nearest" });
  }

  private readonly onKey = (event: KeyboardEvent): void => {
    const target = event.target as HTMLElement;
    if (event.key !== " " || /^(INPUT|BUTTON|SELECT|TEXTAREA|A|SUMMARY)$/.test(target.tagName)) return;
    event.preventDefault();
    this.pause(!this.paused);
  };

  private tools(): HTMLElement {
    const { settings } = this.model;
    const windows = select(
      t("window"),
      WINDOWS.map((seconds) => ({ value: String(seconds), text: windowText(seconds) })),
      String(settings.window),
      (value) => {
        settings.window = Number(value);
        this.model.saveSettings();
        this.zoom(undefined);
      },
    );
    const csv = button(t("csv"), () => this.saveCsv(), { title: "CSV" });
    const png = button(t("png"), () => this.savePng(), { title: "PNG" });
    const marks = button(t("marks"), () => this.toggleMarks(marks), {
      class: "toggle",
      attributes: { "aria-pressed": String(settings.marks), "data-test": "marks" },
    });
    const kinds = MARK_KINDS.map((kind) =>
      h("span", { class: "reading" }, h("i", { class: `mark-sample ${kind}` }), t(`mark_${kind}`)),
    );
    return h(
      "div",
      { class: "tools", title: t("plot_hint") },
      windows,
      this.pauseButton,
      this.resetButton,
      this.cursorButton,
      marks,
      csv,
      png,
      ...kinds,
      this.lostText,
      this.cursorText,
    );
  }

  private makeHost(kind: PlotKind) {
    const what = `${t(kind.text)}: ${kind.lines.map((line) => t(line.part)).join(", ")}`;
    const canvas = h("div", { class: "canvas", attributes: { role: "img", "aria-label": what } });
    const readings: HTMLElement[] = [];
    const unit = h("span", { class: "unit" });
    const head = h("div", { class: "plot-head" }, h("b", {}, t(kind.text)), unit);
    for (const line of kind.lines) {
      const value = h("span", { class: "number" }, "–");
      readings.push(value);
      const sample = h("i", { class: `sample ${line.colour}${line.dashed === true ? " dashed" : ""}` });
      head.append(h("span", { class: "reading" }, sample, t(line.part).toLowerCase(), value));
    }
    if (kind.text === "following_error") head.append(this.errorWindow.root);
    const host = h("div", { class: "plot" }, head, canvas);
    return { kind, host, canvas, readings, unit, range: [0, 0] as [number, number] };
  }

  private stripHead(): HTMLElement {
    const kinds = (["accepted", "ignored", "reached"] as const).map((kind) =>
      h("span", { class: "reading" }, h("i", { class: `dot ${kind}` }), t(kind)),
    );
    const held = h("span", { class: "reading", title: t("held_hint") }, t("held"), this.heldText);
    return h("div", { class: "plot-head", title: t("handshake_hint") }, h("b", {}, t("handshake")), held, ...kinds);
  }

  private makePlot(kind: PlotKind, host: HTMLElement, isLast: boolean): uPlot {
    const axis = {
      stroke: () => colour("muted"),
      grid: { stroke: () => colour("grid"), width: 1 },
      ticks: { stroke: () => colour("grid"), width: 1, size: 4 },
      font: "11px system-ui, sans-serif",
    };
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
          values: (_, values) => values.map((v) => (isLast ? formatTime(this.trace.driveTime(v), labelDecimals(values)) : "")),
        },
        { ...axis, size: AXIS_WIDTH, space: 20, gap: 4, values: (_, values) => values.map((v) => formatNumber(v, labelDecimals(values))) },
      ],
      series: [
        {},
        ...kind.lines.map((line) => ({
          stroke: () => colour(line.colour),
          width: 1.25,
          dash: line.dashed === true ? LINE_DASH : undefined,
          points: { show: false },
        })),
      ],
      hooks: {
        setCursor: [(plot) => this.onCursor(plot)],
        setSelect: [(plot) => this.onSelect(plot)],
        draw: [(plot) => this.drawMarks(plot, kind === PLOTS[0])],
      },
    };
    const empty: uPlot.AlignedData = [[], ...kind.lines.map(() => [])];
    const plot = new uPlot(options, empty, host);
    plot.over.addEventListener("dblclick", () => this.zoom(undefined));
    plot.over.addEventListener("wheel", (event) => this.onWheel(plot, event), { passive: false });
    plot.over.addEventListener("pointerdown", (event) => this.beginPan(plot, event));
    return plot;
  }

  private scaleOf(kind: PlotKind): Scale {
    return kind.unit === "permille" ? PERMILLE : this.model.scale(this.trace.ref.axis);
  }

  private range(): [number, number] {
    if (this.zoomed !== undefined) return this.zoomed;
    const end = this.paused ? this.pausedAt : this.trace.now;
    return [end - this.model.settings.window, end];
  }

  private pause(on: boolean): void {
    this.paused = on;
    this.pausedAt = this.trace.now;
    if (!on) {
      this.zoomed = undefined;
      this.wentTo = undefined;
      this.showCursors(false); // what they stand on moves away
    }
    this.dirty = true;
    this.resetButton.disabled = this.zoomed === undefined;
    put(this.pauseButton, on ? t("go_on") : t("pause_plots"));
    this.pauseButton.setAttribute("aria-pressed", String(on));
  }

  private zoom(range: [number, number] | undefined): void {
    if (range !== undefined && !this.paused) this.pause(true);
    this.zoomed = range;
    this.resetButton.disabled = range === undefined;
    this.dirty = true;
  }

  private onCursor(plot: uPlot): void {
    this.cursorLeft = plot.cursor.left ?? -1;
  }

  /** @return the time under the cursor; undefined without one */
  private cursorTime(): number | undefined {
    return this.cursorLeft < 0 ? undefined : this.drawn[0].plot.posToVal(this.cursorLeft, "x");
  }

  private onSelect(plot: uPlot): void {
    const { left, width } = plot.select;
    if (width < LEAST_DRAG) return;
    this.zoom([plot.posToVal(left, "x"), plot.posToVal(left + width, "x")]);
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  }

  /** Shows earlier and later times while the plot is dragged. A touch upwards scrolls the page. */
  private beginPan(plot: uPlot, down: PointerEvent): void {
    if (down.button !== 0 || down.shiftKey) return;
    const [from, to] = this.range();
    const perPixel = (to - from) / plot.over.clientWidth;
    let moves = false;
    const move = (event: PointerEvent) => {
      const way = event.clientX - down.clientX;
      moves ||= Math.abs(way) >= LEAST_DRAG;
      if (moves) this.zoom([from - way * perPixel, to - way * perPixel]);
    };
    const end = () => {
      plot.over.removeEventListener("pointermove", move);
      plot.over.removeEventListener("lostpointercapture", end);
      if (!moves) this.bringCursor(from + (down.clientX - plot.over.getBoundingClientRect().left) * perPixel);
    };
    plot.over.setPointerCapture(down.pointerId);
    plot.over.addEventListener("pointermove", move);
    plot.over.addEventListener("lostpointercapture", end);
  }

  /** Without Ctrl the wheel scrolls the page, as everywhere. */
  private onWheel(plot: uPlot, event: WheelEvent): void {
    if (!event.ctrlKey) return;
    event.preventDefault();
    const [from, to] = this.range();
    const middle = plot.posToVal(event.offsetX, "x");
    const factor = event.deltaY < 0 ? 0.8 : 1.25;
    const span = Math.min(LONGEST_WINDOW_S, Math.max(0.005, (to - from) * factor));
    const share = (middle - from) / (to - from);
    this.zoom([middle - span * share, middle + span * (1 - share)]);
  }

  private resize(): void {
    const main = this.root.closest("main");
    const width = this.root.clientWidth - 2;
    if (main === null || width < 100) return;
    this.observer.observe(main);
    const height = this.heightIn(main);
    if (width === this.width && height === this.height) return;
    this.width = width;
    this.height = height;
    this.drawn.forEach(({ plot }, i) => {
      plot.setSize({ width, height: i === this.drawn.length - 1 ? height + TIME_AXIS_HEIGHT : height });
    });
    this.dirty = true;
  }

  /** @return of a plot, so that all of them fill the window below what stands above them [px]; where the controls
   *          stand above them, a window of their own */
  private heightIn(main: HTMLElement): number {
    const others = this.root.offsetHeight - this.drawn.reduce((sum, { plot }) => sum + plot.height, 0);
    const top = this.root.getBoundingClientRect().top - main.getBoundingClientRect().top + main.scrollTop;
    const above = top < main.clientHeight / 2 ? top : MARGIN;
    const room = main.clientHeight - above - MARGIN - others - TIME_AXIS_HEIGHT;
    return Math.max(LEAST_HEIGHT, Math.floor(room / this.drawn.length));
  }

  private draw(drawn: Drawn, from: number, to: number): void {
    const scale = this.scaleOf(drawn.kind);
    let low = Infinity;
    let high = -Infinity;
    const data = drawn.kind.lines.map((line) =>
      this.points.y[seriesAt(line.series)].map((value) => {
        if (value === null) return null;
        const shown = toShown(value, scale);
        if (shown < low) low = shown;
        if (shown > high) high = shown;
        return shown;
      }),
    );
    const [bottom, top] = niceRange(low, high, drawn.kind.least * scale.factor);
    // A scale that would shrink a little stays: the picture does not jump.
    const [oldBottom, oldTop] = drawn.range;
    const keeps = bottom >= oldBottom && top <= oldTop && top - bottom > 0.5 * (oldTop - oldBottom);
    if (!keeps) drawn.range = [bottom, top];
    drawn.plot.batch(() => {
      drawn.plot.setData([this.points.x, ...data] as uPlot.AlignedData, false);
      drawn.plot.setScale("x", { min: from, max: to });
      drawn.plot.setScale("y", { min: drawn.range[0], max: drawn.range[1] });
    });
    put(drawn.unit, unitOf(drawn.kind, scale));
  }

  private drawStrip(from: number, to: number): void {
    const height = BITS.length * STRIP_ROW + 14;
    const context = fit(this.strip, this.width, height);
    const right = this.width - RIGHT_MARGIN;
    const place = (time: number) => AXIS_WIDTH + ((time - from) / (to - from)) * (right - AXIS_WIDTH);
    context.font = "11px system-ui, sans-serif";
    const handshake = hasHandshake(this.trace.last["op_mode_actual"]);
    BITS.forEach((bit, row) => {
      const bottom = (row + 1) * STRIP_ROW - 4 + 12;
      context.strokeStyle = colour("grid");
      context.strokeRect(AXIS_WIDTH, bottom + 0.5, right - AXIS_WIDTH, 0);
      context.strokeStyle = colour(row === 0 ? "line-2" : "line-1");
      context.lineWidth = 1.25;
      context.beginPath();
      let level = 0;
      this.points.x.forEach((time, i) => {
        const value = this.points.y[seriesAt(bit.series)][i];
        if (value === null) return;
        const x = Math.max(AXIS_WIDTH, place(time));
        if (i === 0) context.moveTo(x, bottom - value * 11);
        else {
          context.lineTo(x, bottom - level * 11);
          context.lineTo(x, bottom - value * 11);
        }
        level = value;
      });
      context.stroke();
      context.fillStyle = colour("muted");
      context.textAlign = "right";
      const text = handshake || bit.number === undefined ? t(bit.text) : `${t("bit")} ${bit.number}`;
      context.fillText(text, AXIS_WIDTH - 8, bottom - 1);
    });
    for (const { time, kind } of this.trace.marks) {
      if (time < from || time > to) continue;
      context.fillStyle = colour(kind === "ignored" ? "bad" : kind === "accepted" ? "line-2" : "good");
      context.beginPath();
      context.arc(place(time), 6, 3.5, 0, 2 * Math.PI);
      context.fill();
    }
  }

  /** What is under the cursor, else at the right edge. */
  private showReadings(): void {
    const { history } = this.trace;
    const asked = this.cursorTime();
    const number = history.nearest(asked ?? this.range()[1]);
    if (number === undefined || number < history.first) return;
    for (const drawn of this.drawn) {
      const scale = this.scaleOf(drawn.kind);
      drawn.kind.lines.forEach((line, i) => {
        const value = toShown(history.value(seriesAt(line.series), number), scale);
        put(drawn.readings[i], formatNumber(value, scale.decimals));
      });
    }
    // No history has it, and the present value does not belong to a paused plot.
    const held = this.paused ? undefined : this.trace.setPoints;
    put(this.heldText, held === undefined ? "–" : `${held.active} + ${held.waiting ?? "?"}`);
    const time = history.time(number);
    const named = asked === undefined ? "" : this.nameMark(asked);
    const what = asked === undefined ? "" : `${t("cursor")} `;
    put(this.cursorText, `${what}${timeText(this.trace.driveTime(time))}, ${t("tick")} ${this.trace.tickAt(time)}${named}`);
    put(this.lostText, this.trace.lost === 0 ? "" : `${this.trace.lost} ${t("missed")}`);
    mark(this.lostText, "bad", this.trace.lost > 0);
  }

  /** Every sample of the window, not only the points that are drawn. */
  private saveCsv(): void {
    const { history } = this.trace;
    const [from, to] = this.range();
    const { axis } = this.trace.ref;
    const scale = this.model.scale(axis);
    const unitName = scale === USER_UNITS ? scale.name : (axis.unit?.name ?? scale.name);
    const scales = MEMBERS.map(({ unit }) => (unit.startsWith(USER_UNITS.name) ? scale : USER_UNITS));
    const heads = MEMBERS.map(({ name, unit }) => (unit === "" ? name : `${name} [${unit.replace(/^UU/, unitName)}]`));
    const parts = [`tick,time [s],date,${heads.join(",")}\n`];
    for (let n = history.lowerBound(from); n < history.end && history.time(n) <= to; ++n) {
      const time = history.time(n);
      const driveTime = this.trace.driveTime(time);
      const values = scales.map((shown, series) => toShown(history.value(series, n), shown).toFixed(shown.decimals));
      parts.push(`${this.trace.tickAt(time)},${driveTime.toFixed(6)},${isoDate(driveTime)},${values.join(",")}\n`);
    }
    download(`${this.fileName()}.csv`, new Blob(parts, { type: "text/csv" }));
  }

  private savePng(): void {
    const ratio = window.devicePixelRatio || 1;
    const pictures: { head: string; lines: Line[]; canvas: HTMLCanvasElement }[] = this.drawn.map(({ kind, unit, plot }) => ({
      head: `${t(kind.text)} [${unit.textContent ?? ""}]`,
      lines: kind.lines,
      canvas: plot.ctx.canvas,
    }));
    pictures.push({ head: t("handshake"), lines: [], canvas: this.strip });
    const head = 22 * ratio;
    const whole = h("canvas");
    whole.width = this.width * ratio;
    whole.height = pictures.reduce((sum, { canvas }) => sum + canvas.height + head, head);
    const context = whole.getContext("2d");
    if (context === null) return;
    context.fillStyle = colour("panel");
    context.fillRect(0, 0, whole.width, whole.height);
    context.fillStyle = colour("text");
    context.font = `${12 * ratio}px system-ui, sans-serif`;
    context.fillText(this.pictureTitle(), 8 * ratio, 15 * ratio);
    let top = head;
    for (const { head: text, lines, canvas } of pictures) {
      context.fillText(text, 8 * ratio, top + 15 * ratio);
      drawLegend(context, lines, 8 * ratio + context.measureText(text).width, top + 15 * ratio, ratio);
      context.drawImage(canvas, 0, top + head);
      top += canvas.height + head;
    }
    whole.toBlob((blob) => blob !== null && download(`${this.fileName()}.png`, blob));
  }

  private fileName(): string {
    const date = this.dateOf(this.range()[1]).slice(0, "2026-01-01T00:00:00".length);
    return `${addressOf(this.trace.ref)}_${this.trace.ref.axis.name}_${date}`.replace(/[^\w.-]/g, "_");
  }

  /** Of drive time; of now where that has none. */
  private dateOf(time: number): string {
    const date = isoDate(this.trace.driveTime(time));
    return date === "" ? new Date().toISOString() : date;
  }

  /** What the picture shows: which axis, when, and in which state it was at the end. */
  private pictureTitle(): string {
    const { history, ref } = this.trace;
    const [from, to] = this.range();
    const day = this.dateOf(to).slice(0, "2026-01-01".length);
    const times = [from, to].map((time) => timeText(Math.max(0, this.trace.driveTime(time)))).join(" – ");
    const number = history.nearest(to);
    const hex = (series: Series) => (number === undefined ? "–" : formatHex(history.value(seriesAt(series), number)));
    return `${addressOf(ref)} ${ref.axis.name}, ${day}, ${times}, 6041h = ${hex("ds402_statusword")}, 603Fh = ${hex("error_code")}`;
  }

  // ---- marks

  private toggleMarks(pressed: HTMLButtonElement): void {
    const { settings } = this.model;
    settings.marks = !settings.marks;
    this.model.saveSettings();
    pressed.setAttribute("aria-pressed", String(settings.marks));
    this.dirty = true;
  }

  /** What happened to the axis and to its bench. */
  private marksBetween(from: number, to: number): Mark[] {
    const { ref, moments } = this.trace;
    const [first, last] = [this.trace.tickAt(from), this.trace.tickAt(to)];
    const inside = ({ tick }: { tick: number }) => tick >= first && tick <= last;
    const events = this.model.events.events.filter(
      (event) => event.bench === ref.bench.number && (event.axis === ref.axis.axis || event.axis === 0) && inside(event),
    );
    return marksOf(moments.filter(inside), events);
  }

  private drawMarks(plot: uPlot, hasLabels: boolean): void {
    const { ctx, bbox } = plot;
    const ratio = window.devicePixelRatio || 1;
    const colours = { state: colour("accent"), fault: colour("bad"), event: colour("warn") } satisfies Record<MarkKind, string>;
    const line = (time: number, stroke: string, dash: number[], width: number) => {
      const x = plot.valToPos(time, "x", true);
      if (x < bbox.left || x > bbox.left + bbox.width) return undefined;
      ctx.strokeStyle = stroke;
      ctx.lineWidth = width * ratio;
      ctx.setLineDash(dash.map((length) => length * ratio));
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      return x;
    };
    ctx.save();
    ctx.font = `${10 * ratio}px system-ui, sans-serif`;
    let labelled = -Infinity;
    const drawn = new Set<string>();
    for (const { tick, kind, moment } of this.marks) {
      const time = this.trace.timeOf(tick) ?? NaN;
      const room = kind === "fault" ? 1 : MARK_ROOM;
      const place = `${kind} ${Math.round(plot.valToPos(time, "x", true) / (room * ratio))}`;
      if (drawn.has(place)) continue; // many marks must not cover the lines
      drawn.add(place);
      const x = line(time, colours[kind], MARK_DASHES[kind], 1);
      if (!hasLabels || x === undefined || moment?.code === undefined || x - labelled < LABEL_SPACE * ratio) continue;
      labelled = x;
      ctx.fillStyle = colours[kind];
      ctx.textAlign = "left";
      ctx.fillText(formatHex(moment.code), x + 3 * ratio, bbox.top + 10 * ratio);
    }
    if (this.wentTo !== undefined) line(this.wentTo, colour("text"), [1, 2], 2);
    for (const time of this.cursors ?? []) line(time, colour("text"), [], 1);
    ctx.restore();
  }

  /** @return the mark under the pointer, in words. */
  private nameMark(time: number): string {
    const [from, to] = this.range();
    const reach = (MARK_REACH * (to - from)) / Math.max(1, this.width - AXIS_WIDTH - RIGHT_MARGIN);
    const away = (mark: Mark) => Math.abs((this.trace.timeOf(mark.tick) ?? Infinity) - time);
    const near = this.marks.filter((mark) => away(mark) <= reach).sort((a, b) => away(a) - away(b));
    return near.length === 0 ? "" : `: ${near.slice(0, 2).map((mark) => this.markText(mark)).join("; ")}`;
  }

  private markText({ moment, event }: Mark): string {
    if (moment?.state !== undefined) return stateName(moment.state);
    if (moment?.code !== undefined) return `${formatHex(moment.code)} ${this.model.errorName(moment.code)}`;
    return event?.message ?? "";
  }

  // ---- two cursors

  /** They stand still, and so do the plots. */
  private showCursors(on: boolean): void {
    if (on && !this.paused) this.pause(true);
    const [from, to] = this.range();
    this.cursors = on ? [from + (to - from) / 3, from + ((to - from) * 2) / 3] : undefined;
    this.cursorButton.setAttribute("aria-pressed", String(on));
    this.cursorTable.hidden = !on;
    this.dirty = true;
  }

  private moveCursor(which: number, time: number): void {
    if (this.cursors === undefined) return;
    const [from, to] = this.range();
    this.cursors[which] = Math.min(to, Math.max(from, time));
    this.dirty = true;
  }

  /** The nearer one comes to where a person clicked. */
  private bringCursor(time: number): void {
    if (this.cursors === undefined) return;
    const [a, b] = this.cursors;
    this.moveCursor(Math.abs(a - time) <= Math.abs(b - time) ? 0 : 1, time);
  }

  private makeHandle(name: string, which: number): HTMLElement {
    const handle = h("span", {
      class: "cursor-handle",
      attributes: { role: "slider", tabindex: "0", "aria-label": `${t("cursor")} ${name}`, "aria-valuenow": "0", "data-test": `cursor-${name}` },
    }, name);
    handle.hidden = true;
    handle.addEventListener("keydown", (event) => {
      const step = CURSOR_STEPS[event.key];
      if (step === undefined || this.cursors === undefined) return;
      event.preventDefault();
      const [from, to] = this.range();
      this.moveCursor(which, this.cursors[which] + (step * (to - from)) / Math.max(1, this.width - AXIS_WIDTH - RIGHT_MARGIN));
    });
    handle.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      handle.focus();
      handle.setPointerCapture(event.pointerId);
    });
    handle.addEventListener("pointermove", (event) => {
      if (!handle.hasPointerCapture(event.pointerId)) return;
      const { plot } = this.drawn[0];
      this.moveCursor(which, plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x"));
    });
    return handle;
  }

  private placeHandles(from: number, to: number): void {
    const width = this.width - AXIS_WIDTH - RIGHT_MARGIN;
    this.handles.forEach((handle, which) => {
      const time = this.cursors?.[which];
      handle.hidden = time === undefined || time < from || time > to;
      if (time === undefined) return;
      handle.style.left = `${AXIS_WIDTH + ((time - from) / (to - from)) * width}px`;
      handle.setAttribute("aria-valuemin", String(from));
      handle.setAttribute("aria-valuemax", String(to));
      handle.setAttribute("aria-valuenow", String(time));
      handle.setAttribute("aria-valuetext", timeText(this.trace.driveTime(time)));
    });
  }

  /** What the samples under A and B are, and by how much they differ. */
  private showDifferences(): void {
    if (this.cursors === undefined) return;
    const { history } = this.trace;
    const [a, b] = this.cursors.map((time) => history.nearest(time));
    if (a === undefined || b === undefined) return;
    const [from, to] = [history.time(a), history.time(b)];
    const row = (head: string, cells: string[], unit: string) =>
      h("tr", {}, h("th", { attributes: { scope: "row" } }, head), ...cells.map((cell) => h("td", { class: "number" }, cell)), h("td", { class: "unit" }, unit));
    const heads = ["A", "B", "B − A"].map((text) => h("th", { attributes: { scope: "col" } }, text));
    const times = [from, to].map((time) => formatTime(this.trace.driveTime(time), 3));
    const rows = [row(t("time"), [...times, formatNumber(to - from, 4)], "s")];
    for (const { kind } of this.drawn) {
      const scale = this.scaleOf(kind);
      for (const line of kind.lines) {
        const values = [a, b].map((number) => toShown(history.value(seriesAt(line.series), number), scale));
        const texts = [...values, values[1] - values[0]].map((value) => formatNumber(value, scale.decimals));
        rows.push(row(`${t(kind.text)}, ${t(line.part).toLowerCase()}`, texts, unitOf(kind, scale)));
      }
    }
    this.cursorTable.replaceChildren(
      h("thead", {}, h("tr", {}, h("td", {}), ...heads, h("td", {}))),
      h("tbody", {}, ...rows),
    );
  }
}

/** Each line as it is drawn, and its name. @param bottom of the letters */
function drawLegend(context: CanvasRenderingContext2D, lines: Line[], left: number, bottom: number, ratio: number): void {
  context.save();
  context.lineWidth = 2 * ratio;
  for (const line of lines) {
    left += LEGEND_GAP * ratio;
    context.strokeStyle = colour(line.colour);
    context.setLineDash(line.dashed === true ? LINE_DASH.map((length) => length * ratio) : []);
    context.beginPath();
    context.moveTo(left, bottom - 4 * ratio);
    context.lineTo(left + LEGEND_LINE * ratio, bottom - 4 * ratio);
    context.stroke();
    left += (LEGEND_LINE + 6) * ratio;
    const name = t(line.part).toLowerCase();
    context.fillText(name, left, bottom);
    left += context.measureText(name).width;
  }
  context.restore();
}

function unitOf(kind: PlotKind, scale: Scale): string {
  return kind.unit === "velocity" ? `${scale.name}/s` : scale.name;
}
