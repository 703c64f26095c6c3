// SPDX-License-Identifier: Apache-2.0
// Live plots of one axis over one time axis, with the handshake of set-points under them.

import uPlot from "uplot";
import { niceRange, type Points } from "../data/history";
import { formatNumber, toShown, type Scale } from "../data/units";
import { t, type TextKey } from "../i18n";
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
const AXIS_WIDTH = 78;
const RIGHT_MARGIN = 14;
const TIME_AXIS_HEIGHT = 22;
const BITS: { series: Series; text: TextKey }[] = [
  { series: "new_set_point", text: "bit4" },
  { series: "acknowledge", text: "bit12" },
  { series: "reached", text: "bit10" },
];
const STRIP_ROW = 20;
const PERMILLE: Scale = { name: "%", factor: 0.1, decimals: 1 };
const SYNC = "axis";
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
  private width = 0;
  private paused = false;
  /** [s] shown instead of the newest window */
  private zoomed?: [number, number];
  private pausedAt = 0;
  private cursorTime?: number;
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
    this.resetButton = button(t("reset_zoom"), () => this.zoom(undefined));
    this.resetButton.disabled = true;
    this.strip = h("canvas", { class: "strip", attributes: { role: "img", "aria-label": t("handshake") } });
    const hosts = PLOTS.map((kind) => this.makeHost(kind));
    const stripHost = h("div", { class: "plot strip-host" }, this.stripHead(), this.strip);
    this.root = h(
      "section",
      { class: "plots panel" },
      this.tools(),
      ...hosts.map((host) => host.host),
      stripHost,
    );
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
    const fresh = !this.paused && this.zoomed === undefined && this.trace.history.end !== this.drawnEnd;
    if (this.width > 0 && (this.dirty || (fresh && now - this.drawnAt >= every))) {
      this.dirty = false;
      this.drawnAt = now;
      this.drawnEnd = this.trace.history.end;
      this.points = this.trace.history.points(from, to, columns);
      for (const drawn of this.drawn) this.draw(drawn, from, to);
      this.drawStrip(from, to);
    }
    this.showReadings();
    this.errorWindow.update(now);
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
    return h("div", { class: "tools", title: t("plot_hint") }, windows, this.pauseButton, this.resetButton, csv, png, this.lostText, this.cursorText);
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
          values: (_, values) => values.map((v) => (isLast ? formatNumber(v, decimalsOf(values)) : "")),
        },
        { ...axis, size: AXIS_WIDTH, space: 20, gap: 4, values: (_, values) => values.map((v) => formatNumber(v, decimalsOf(values))) },
      ],
      series: [
        {},
        ...kind.lines.map((line) => ({
          stroke: () => colour(line.colour),
          width: 1.25,
          dash: line.dashed === true ? [5, 4] : undefined,
          points: { show: false },
        })),
      ],
      hooks: {
        setCursor: [(plot) => this.onCursor(plot)],
        setSelect: [(plot) => this.onSelect(plot)],
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
    if (!on) this.zoomed = undefined;
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
    const left = plot.cursor.left ?? -1;
    this.cursorTime = left < 0 ? undefined : plot.posToVal(left, "x");
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
    const width = this.root.clientWidth - 2;
    if (width === this.width || width < 100) return;
    this.width = width;
    const height = width < 500 ? 92 : 104;
    this.drawn.forEach(({ plot }, i) => {
      plot.setSize({ width, height: i === this.drawn.length - 1 ? height + TIME_AXIS_HEIGHT : height });
    });
    this.dirty = true;
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
    const unit = drawn.kind.unit === "velocity" ? `${scale.name}/s` : scale.name;
    put(drawn.unit, unit);
  }

  private drawStrip(from: number, to: number): void {
    const height = BITS.length * STRIP_ROW + 14;
    const context = fit(this.strip, this.width, height);
    const right = this.width - RIGHT_MARGIN;
    const place = (time: number) => AXIS_WIDTH + ((time - from) / (to - from)) * (right - AXIS_WIDTH);
    context.font = "11px system-ui, sans-serif";
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
      context.fillText(t(bit.text), AXIS_WIDTH - 8, bottom - 1);
    });
    for (const { time, kind } of this.trace.marks) {
      if (time < from || time > to) continue;
      context.fillStyle = colour(kind === "ignored" ? "bad" : kind === "accepted" ? "line-2" : "good");
      context.beginPath();
      context.arc(place(time), 6, 3.5, 0, 2 * Math.PI);
      context.fill();
    }
  }

  private showReadings(): void {
    const { history } = this.trace;
    const asked = this.cursorTime;
    const number = asked === undefined ? history.end - 1 : history.nearest(asked);
    if (number === undefined || number < history.first) return;
    for (const drawn of this.drawn) {
      const scale = this.scaleOf(drawn.kind);
      drawn.kind.lines.forEach((line, i) => {
        const value = toShown(history.value(seriesAt(line.series), number), scale);
        put(drawn.readings[i], formatNumber(value, scale.decimals));
      });
    }
    const held = this.trace.setPoints;
    put(this.heldText, held === undefined ? "–" : `${held.active} + ${held.waiting ?? "?"}`);
    const time = history.time(number);
    put(this.cursorText, `${asked === undefined ? "" : t("cursor") + " "}${formatNumber(time, 3)} s, ${t("tick")} ${this.trace.tickAt(time)}`);
    put(this.lostText, this.trace.lost === 0 ? "" : `${this.trace.lost} ${t("missed")}`);
    mark(this.lostText, "bad", this.trace.lost > 0);
  }

  /** Every sample of the window, not only the points that are drawn. */
  private saveCsv(): void {
    const { history } = this.trace;
    const [from, to] = this.range();
    const parts = [`tick,time_s,${MEMBERS.join(",")}\n`];
    for (let n = history.lowerBound(from); n < history.end && history.time(n) <= to; ++n) {
      const time = history.time(n);
      const values = MEMBERS.map((_, series) => history.value(series, n));
      parts.push(`${this.trace.tickAt(time)},${time.toFixed(6)},${values.join(",")}\n`);
    }
    download(`${this.fileName()}.csv`, new Blob(parts, { type: "text/csv" }));
  }

  private savePng(): void {
    const ratio = window.devicePixelRatio || 1;
    const pictures: { head: string; canvas: HTMLCanvasElement }[] = this.drawn.map((drawn) => ({
      head: `${t(drawn.kind.text)} [${drawn.unit.textContent ?? ""}]: ${drawn.kind.lines.map((l) => t(l.part)).join(", ")}`,
      canvas: drawn.plot.ctx.canvas,
    }));
    pictures.push({ head: t("handshake"), canvas: this.strip });
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
    context.fillText(`${addressOf(this.trace.ref)} ${this.trace.ref.axis.name}`, 8 * ratio, 15 * ratio);
    let top = head;
    for (const { head: text, canvas } of pictures) {
      context.fillText(text, 8 * ratio, top + 15 * ratio);
      context.drawImage(canvas, 0, top + head);
      top += canvas.height + head;
    }
    whole.toBlob((blob) => blob !== null && download(`${this.fileName()}.png`, blob));
  }

  private fileName(): string {
    return `${this.trace.ref.axis.name}_${this.trace.tickAt(this.range()[1])}`.replace(/[^\w.-]/g, "_");
  }
}

/** Decimals with which the values of neighbouring grid lines differ. */
function decimalsOf(values: number[]): number {
  if (values.length < 2) return 0;
  const step = Math.abs(values[1] - values[0]);
  return step >= 1 ? 0 : Math.min(6, Math.ceil(-Math.log10(step)));
}

