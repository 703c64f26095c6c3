// SPDX-License-Identifier: Apache-2.0
// Signals of axes in strips over one time axis: live, or of a recording.

import type uPlot from "uplot";
import type { LogEvent } from "../data/events";
import { marksOf, type Mark, type MarkKind } from "../data/moments";
import type { Samples } from "../data/samples";
import { formatScope, parseScope, SET_POINTS, type ScopeState, type StripState } from "../data/scope_link";
import { quantityOf, type Quantity } from "../data/signals";
import { timeText } from "../data/times";
import { TriggerRun, type Trigger } from "../data/trigger";
import { formatHex } from "../data/units";
import { signalName, stateName, t } from "../i18n";
import type { Dictionary, Model } from "../model";
import type { Source } from "../source";
import { LONGEST_WINDOW_S } from "../trace";
import { MOST_TRACES } from "../traces";
import { BitStrip } from "./bit_strip";
import { Cursors } from "./cursors";
import { button, colour, download, h, mark, put, select, type View } from "./dom";
import { ErrorWindow } from "./error_window";
import { csvOf, fileName, pictureOf, titleOf } from "./scope_files";
import { AXIS_WIDTH, PlotStrip, RIGHT_MARGIN, TIME_AXIS_HEIGHT, type Shown } from "./strip";
import { TriggerPanel } from "./trigger";

/** The initial signals of an axis. */
const PRESET = [
  ["position_demand_value", "load_position_actual_value"],
  ["motor_velocity_actual_value", "load_velocity_actual_value", "velocity_demand_value"],
  ["load_position_error_value"],
  ["current_actual_value", "torque_actual_value", "torque_demand"],
  [SET_POINTS],
];
/** Its strip also has the field for its window (6065h). */
const FOLLOWING_ERROR = "load_position_error_value";
const WINDOWS = [1, 2, 5, 10, 30, 60, 120, 300, LONGEST_WINDOW_S];
const LEAST_WINDOW_S = 0.005;
const ORIGIN_S = 3_600;
const LEAST_HEIGHT = 92; // [px] of a plot: with less, nothing can be seen
const MARGIN = 10; // [px] of the window around the plots
const PRINT_SIZE = { width: 980, height: 130 }; // [px] of a plot on paper
/** Kinds can also be distinguished without colours. */
const MARK_DASHES: Record<MarkKind, number[]> = { fault: [], state: [2, 3], event: [7, 4] };
const MARK_KINDS: readonly MarkKind[] = ["state", "fault", "event"];
/** [px] A mark this near to the pointer is named. */
const MARK_REACH = 6;
const MARK_ROOM = 4; // [px] of a mark that is not a fault
const LABEL_SPACE = 44; // [px] for "8611h"
/** [px] a shorter movement is a click */
const LEAST_DRAG = 4;
/** A browser allows a page to change its address 200 times in 30 s. */
const LINK_EVERY_MS = 300;

function windowText(seconds: number): string {
  return seconds < 60 ? `${seconds} s` : `${seconds / 60} min`;
}

export function presetOf(axis: string): StripState[] {
  return PRESET.map((members) => ({ axis, members }));
}

interface PlacedMark {
  mark: Mark;
  /** [s] of drive time */
  time: number;
  axis: string;
}

export class Scope implements View {
  readonly root: HTMLElement;
  private strips: StripState[];
  /** of the axes in the strips */
  private samples = new Map<string, Samples>();
  private plots: PlotStrip[] = [];
  private bits: BitStrip[] = [];
  private readonly body = h("div", { class: "strips" });
  private readonly cursorText = h("span", { class: "cursor-text" });
  private readonly lostText = h("span", { class: "lost-text" });
  private readonly pauseButton: HTMLButtonElement;
  private readonly resetButton: HTMLButtonElement;
  private readonly cursorButton: HTMLButtonElement;
  private readonly lastRunButton: HTMLButtonElement;
  private readonly everyTick = h("input", { attributes: { type: "checkbox", "data-test": "every_tick" } });
  private readonly addPlace = h("div", { class: "line add-signal" });
  private readonly addButton: HTMLButtonElement;
  private readonly cursors: Cursors;
  private readonly trigger: TriggerPanel;
  private readonly observer: ResizeObserver;
  private errorWindow?: ErrorWindow;
  private run?: TriggerRun;
  /** The run for which every tick was requested from the black box. */
  private captured?: TriggerRun;
  private showsLastRun = true;
  private marks: PlacedMark[] = [];
  /** time of the event that the user went to [s] */
  private wentTo?: number;
  private eventsVersion = -1;
  private width = 0;
  private height = 0;
  private paused = false;
  /** [s] of drive time, shown instead of the newest window */
  private zoomed?: [number, number];
  private pausedAt = 0;
  /** [px] in the plots; the time under it changes while they run */
  private cursorLeft = -1;
  private drawnEnd = -1;
  private drawnAt = 0;
  private dirty = true;
  private builtWith?: Dictionary;
  private builtMembers = "";
  /** path of the address at which this view writes its link */
  private readonly path = location.hash.split("?")[0];
  private link: string;
  private linkAt = -Infinity;

  /** @param preset shown unless the link says otherwise
   *  @param query of the link that opened this view
   *  @param isNamed strips show the name of their axis even if there is only one
   *  @param capture shows every tick around a single trigger, from the black box; undefined if it is not offered */
  constructor(
    private readonly model: Model,
    private readonly source: Source,
    private readonly preset: StripState[],
    query: string,
    private readonly isNamed: boolean,
    private readonly capture?: (at: TriggerRun, all: readonly Samples[]) => void,
  ) {
    this.pauseButton = button(t("pause_plots"), () => this.pause(!this.paused), {
      class: "toggle",
      attributes: { "aria-pressed": "false", "data-test": "pause" },
    });
    this.pauseButton.hidden = !source.isLive;
    this.cursorButton = button(t("two_cursors"), () => this.showCursors(this.cursors.times === undefined), {
      class: "toggle",
      title: t("two_cursors_hint"),
      attributes: { "aria-pressed": "false", "data-test": "two_cursors" },
    });
    this.lastRunButton = button(t("last_run"), () => this.toggleLastRun(), { class: "toggle", attributes: { "aria-pressed": "true" } });
    this.addButton = button(t("add_signal"), () => this.toggleAdding(), {
      class: "toggle",
      attributes: { "aria-pressed": "false", "data-test": "add_signal" },
    });
    this.addPlace.hidden = true;
    this.resetButton = button(t("reset_zoom"), () => this.zoom(undefined));
    this.resetButton.disabled = true;
    this.cursors = new Cursors({
      width: () => this.width,
      range: () => this.range(),
      timeAt: (left) => this.timeAt(left),
      changed: () => (this.dirty = true),
    });
    const everyTick = h("label", { class: "choice", title: t("every_tick_hint") }, this.everyTick, t("every_tick"));
    everyTick.hidden = capture === undefined || !source.isLive;
    this.trigger = new TriggerPanel(model, () => [...this.samples.values()], (wanted) => this.arm(wanted), [everyTick, this.lastRunButton]);
    this.link = query === "" ? "" : `?${query}`;
    const asked = this.fromLink(query);
    this.strips = this.known(asked.strips) ?? preset;
    this.root = h("section", { class: "plots panel" }, this.tools(), this.addPlace, this.trigger.root, this.cursors.root, this.body);
    this.open();
    this.apply(asked);
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(this.root);
    document.addEventListener("keydown", this.onKey);
    window.addEventListener("beforeprint", this.onPrint);
    window.addEventListener("afterprint", this.onPrinted);
  }

  redraw(): void {
    this.dirty = true;
  }

  close(): void {
    this.observer.disconnect();
    document.removeEventListener("keydown", this.onKey);
    window.removeEventListener("beforeprint", this.onPrint);
    window.removeEventListener("afterprint", this.onPrinted);
    for (const plot of this.plots) plot.close();
  }

  update(now: number): void {
    const members = [...this.samples.values()].map(({ members: names }) => names.length).join();
    if (this.model.dictionary !== this.builtWith || members !== this.builtMembers) this.build(members);
    this.follow();
    const [from, to] = this.range();
    const columns = Math.max(50, this.width - AXIS_WIDTH - RIGHT_MARGIN);
    // A long window moves by less than a pixel per frame, so it is drawn less often.
    const every = Math.min(250, ((to - from) / columns) * 1000);
    const end = [...this.samples.values()].reduce((sum, { history }) => sum + history.end, 0);
    const isOld = end !== this.drawnEnd || this.source.events.version !== this.eventsVersion;
    const fresh = !this.paused && this.zoomed === undefined && isOld;
    if (this.width > 0 && (this.dirty || (fresh && now - this.drawnAt >= every))) {
      this.dirty = false;
      this.drawnAt = now;
      this.drawnEnd = end;
      this.eventsVersion = this.source.events.version;
      this.draw({ from, to, origin: this.origin(), columns, lastRun: this.lastRun() });
    }
    this.cursors.measure(this.plots, this.samples.size > 1, now);
    this.showReadings();
    this.errorWindow?.update(now);
    this.writeLink(now);
  }

  /** Shows this moment in the middle of the window. @param time [s] of drive time */
  goTo(time: number): void {
    const isThere = [...this.samples.values()].some(({ begin, end }) => begin !== undefined && end !== undefined && time >= begin && time <= end);
    if (!isThere) {
      this.model.outcome = { ok: false, text: `${timeText(time)}: ${t("no_samples")}` };
      return;
    }
    const half = this.model.settings.window / 2;
    this.zoom([time - half, time + half]);
    this.wentTo = time;
    this.root.scrollIntoView({ block: "nearest" });
  }

  /** Marks a moment with a line, without moving there. @param time [s] of drive time */
  markTime(time: number): void {
    this.wentTo = time;
    this.dirty = true;
  }

  /** @return whether there are samples of any axis */
  get hasSamples(): boolean {
    return [...this.samples.values()].some(({ end }) => end !== undefined);
  }

  private readonly onKey = (event: KeyboardEvent): void => {
    const target = event.target as HTMLElement;
    if (event.key !== " " || !this.source.isLive || /^(INPUT|BUTTON|SELECT|TEXTAREA|A|SUMMARY)$/.test(target.tagName)) return;
    event.preventDefault();
    this.pause(!this.paused);
  };

  // ---- link

  private fromLink(query: string): Partial<ScopeState> {
    const { state, bad } = parseScope(query);
    if (bad.length > 0) this.model.outcome = { ok: false, text: `${t("bad_link")}: ${bad.join(", ")}` };
    if (state.window !== undefined) this.model.settings.window = Math.min(LONGEST_WINDOW_S, state.window);
    return state;
  }

  private apply({ range, cursors, trigger }: Partial<ScopeState>): void {
    if (range !== undefined && (this.source.isLive || this.overlaps(range))) this.zoom(range);
    if (cursors !== undefined && (this.source.isLive || this.overlaps(cursors))) this.setCursors(cursors);
    if (trigger === undefined) return;
    this.trigger.set(trigger);
    if (range === undefined) this.arm(trigger); // otherwise the trigger would lead away from the linked range
  }

  /** @return the strips of a link; for a recording only those of its axes */
  private known(strips: StripState[] | undefined): StripState[] | undefined {
    if (strips === undefined || this.source.isLive) return strips;
    const axes = new Set(this.source.axes().map(({ address }) => address));
    const found = strips.filter(({ axis }) => axes.has(axis));
    return found.length === 0 ? undefined : found;
  }

  private overlaps(times: [number, number]): boolean {
    const [begin, end] = this.whole();
    return Math.min(...times) < end && Math.max(...times) > begin;
  }

  /** Keeps the address of the page as a link to the present content. */
  private writeLink(now: number): void {
    if (now - this.linkAt < LINK_EVERY_MS) return;
    this.linkAt = now;
    const stands = this.paused || this.zoomed !== undefined;
    const { strips } = this;
    const isPreset = JSON.stringify(strips) === JSON.stringify(this.preset);
    const { times: cursors } = this.cursors;
    const trigger = this.run?.trigger;
    const isPlain = isPreset && !stands && cursors === undefined && trigger === undefined;
    const range = stands ? this.range() : undefined;
    const query = isPlain ? "" : `?${formatScope({ strips, window: this.model.settings.window, range, cursors, trigger })}`;
    if (query === this.link || location.hash.split("?")[0] !== this.path) return;
    this.link = query;
    history.replaceState(history.state, "", this.path + query);
  }

  // ---- strips

  /** Starts to receive the axes of the strips, MOST_TRACES at most. */
  private open(): void {
    const axes = [...new Set(this.strips.map(({ axis }) => axis))];
    if (axes.length > MOST_TRACES) {
      this.model.outcome = { ok: false, text: `${t("most_axes")} ${MOST_TRACES}: ${axes.slice(MOST_TRACES).join(", ")}` };
      this.strips = this.strips.filter(({ axis }) => axes.indexOf(axis) < MOST_TRACES);
    }
    this.samples = this.source.open(axes.slice(0, MOST_TRACES));
    this.builtMembers = "?";
  }

  private change(strips: StripState[]): void {
    this.strips = strips;
    this.open();
  }

  private object(member: string) {
    return this.model.dictionary?.objects.find(({ name }) => name === member);
  }

  /** Signals of one strip share a scale; if those of a link do not, they get separate strips. */
  private split(strip: StripState, samples: Samples): { members: string[]; quantity: Quantity }[] {
    const groups: { members: string[]; quantity: Quantity }[] = [];
    for (const member of strip.members) {
      const quantity = quantityOf(this.object(member), this.model.scale(samples.axis));
      const group = groups.find((candidate) => candidate.quantity.kind === quantity.kind);
      if (group === undefined) groups.push({ members: [member], quantity });
      else group.members.push(member);
    }
    return groups;
  }

  private build(members: string): void {
    this.builtWith = this.model.dictionary;
    this.builtMembers = members;
    for (const plot of this.plots) plot.close();
    this.plots = [];
    this.bits = [];
    this.errorWindow = undefined;
    const named = this.isNamed || new Set(this.strips.map(({ axis }) => axis)).size > 1;
    const parts = this.strips.flatMap((strip, place) => {
      const samples = this.samples.get(strip.axis);
      const isBits = strip.members.includes(SET_POINTS);
      const groups = samples === undefined || isBits ? [undefined] : this.split(strip, samples);
      return groups.map((group, i) => ({ strip, place, samples, group, tools: i === 0 ? this.stripTools(place) : [] }));
    });
    const lastPlot = parts.map(({ group }) => group !== undefined).lastIndexOf(true);
    const seen = new Set<string>();
    const roots = parts.map(({ strip, samples, group, tools }, i) => {
      const head = named || samples === undefined ? [h("b", {}, `${strip.axis} ${samples?.axis.name ?? ""}`.trim())] : [];
      if (samples === undefined) {
        return h("div", { class: "plot" }, h("div", { class: "plot-head" }, ...head, ...tools), h("p", { class: "problem" }, `${t("no_axis")} ${strip.axis}.`));
      }
      if (group === undefined) {
        const made = new BitStrip(samples, head, tools);
        this.bits.push(made);
        return made.root;
      }
      const place = { isFirst: !seen.has(strip.axis), isLast: i === lastPlot };
      seen.add(strip.axis);
      return this.plotStrip(samples, group, place, head, tools);
    });
    if (roots.length === 0) roots.push(h("p", { class: "nothing" }, t("no_signals")));
    this.body.replaceChildren(...roots);
    // The handles are outside the role=img element of the plot, because its content cannot be reached.
    this.plots[0]?.root.append(...this.cursors.handles);
    if (!this.trigger.root.hidden) this.trigger.build();
    if (!this.addPlace.hidden) this.buildAdding();
    this.width = 0;
    this.resize();
  }

  private plotStrip(
    samples: Samples,
    group: { members: string[]; quantity: Quantity },
    place: { isFirst: boolean; isLast: boolean },
    head: Node[],
    tools: Node[],
  ): HTMLElement {
    const signals = group.members.map((member) => ({ member, title: signalName(member, this.object(member)) }));
    const ref = group.members.includes(FOLLOWING_ERROR) ? this.source.ref(samples.axis.address) : undefined;
    const extra: Node[] = [];
    if (ref !== undefined && this.errorWindow === undefined) {
      this.errorWindow = new ErrorWindow(this.model, ref);
      extra.push(this.errorWindow.root);
    }
    const made = new PlotStrip(samples, signals, group.quantity, place, head, [...extra, ...tools], {
      draw: (strip, isFirst) => this.drawMarks(strip, isFirst),
      cursor: (plot) => (this.cursorLeft = plot.cursor.left ?? -1),
      select: (plot) => this.onSelect(plot),
      made: (plot) => this.listen(plot),
      origin: () => this.origin(),
    });
    this.plots.push(made);
    return made.root;
  }

  /** Buttons for up, down, remove. @param place index of the strip */
  private stripTools(place: number): Node[] {
    const move = (by: number) => () => {
      const strips = [...this.strips];
      const [moved] = strips.splice(place, 1);
      strips.splice(place + by, 0, moved);
      this.change(strips);
    };
    const made = (text: string, label: "move_up" | "move_down" | "remove", press: () => void, isOff: boolean) => {
      const tool = button(text, press, { class: "quiet", title: t(label), attributes: { "aria-label": `${t(label)} ${place + 1}` } });
      tool.disabled = isOff;
      return tool;
    };
    const tools = [
      made("▴", "move_up", move(-1), place === 0),
      made("▾", "move_down", move(1), place === this.strips.length - 1),
      made("×", "remove", () => this.change(this.strips.filter((_, i) => i !== place)), false),
    ];
    return [h("span", { class: "strip-tools" }, ...tools)];
  }

  private toggleAdding(): void {
    this.addPlace.hidden = !this.addPlace.hidden;
    this.addButton.setAttribute("aria-pressed", String(!this.addPlace.hidden));
    if (!this.addPlace.hidden) this.buildAdding();
  }

  /** Offers any axis of the bench shown, and any signal that one of the axes is known to have. */
  private buildAdding(): void {
    const shown = this.strips[0]?.axis ?? this.preset[0]?.axis ?? "";
    const [bench] = shown.split(".").map(Number);
    const axes = this.source.axes().filter((axis) => shown === "" || axis.bench === bench);
    const known = [...this.samples.values()].map(({ members }) => members).find((members) => members.length > 0) ?? PRESET.flat();
    const names = [...new Set([...known, SET_POINTS])];
    const axis = select(t("axis"), axes.map(({ address, name }) => ({ value: address, text: `${address} ${name}` })), shown, () => undefined);
    const signals = names.map((member) => ({ value: member, text: member === SET_POINTS ? t("handshake") : signalName(member, this.object(member)) }));
    const signal = select(t("signal"), signals, names[0], () => undefined);
    const add = button(t("add"), () => this.change([...this.strips, { axis: axis.value, members: [signal.value] }]), { class: "primary" });
    const reset = button(t("preset"), () => this.change(this.preset));
    axis.dataset["test"] = "add_axis";
    signal.dataset["test"] = "add_member";
    add.dataset["test"] = "add";
    this.addPlace.replaceChildren(axis, signal, add, reset);
  }

  // ---- tools

  private tools(): HTMLElement {
    const { settings } = this.model;
    const windows = select(
      t("window"),
      [...new Set([...WINDOWS, settings.window])].map((seconds) => ({ value: String(seconds), text: windowText(seconds) })),
      String(settings.window),
      (value) => {
        settings.window = Number(value);
        this.model.saveSettings();
        this.zoom(undefined);
      },
    );
    const csv = button(t("csv"), () => this.saveCsv(), { title: "CSV", attributes: { "data-test": "csv" } });
    const png = button(t("png"), () => this.savePng(), { title: "PNG" });
    const print = button(t("print"), () => window.print());
    const marks = button(t("marks"), () => this.toggleMarks(marks), {
      class: "toggle",
      attributes: { "aria-pressed": String(settings.marks), "data-test": "marks" },
    });
    const kinds = MARK_KINDS.map((kind) =>
      h("span", { class: "reading" }, h("i", { class: `mark-sample ${kind}` }), t(`mark_${kind}`)),
    );
    const [buttons, texts] = [[windows, this.pauseButton, this.resetButton, this.cursorButton, this.trigger.toggle, this.addButton, marks], [csv, png, print]];
    return h("div", { class: "tools", title: t("plot_hint") }, ...buttons, ...texts, ...kinds, this.lostText, this.cursorText);
  }

  private saveCsv(): void {
    const all = [...this.samples.values()];
    const [from, to] = this.range();
    const parts = csvOf(all, this.model.dictionary?.objects ?? [], from, to, this.model.settings.axisUnits);
    download(`${fileName(all, to)}.csv`, new Blob(parts, { type: "text/csv" }));
  }

  private savePng(): void {
    const all = [...this.samples.values()];
    const [from, to] = this.range();
    const picture = pictureOf(titleOf(all, from, to), [...this.plots, ...this.bits], this.width);
    picture.toBlob((blob) => blob !== null && download(`${fileName(all, to)}.png`, blob));
  }

  /** Paper is white and has a fixed width. */
  private readonly onPrint = (): void => {
    document.documentElement.dataset["printing"] = "";
    const { width, height } = PRINT_SIZE;
    this.fitPlots(width, height);
    const [from, to] = this.range();
    this.body.dataset["title"] = titleOf([...this.samples.values()], from, to);
    this.draw({ from, to, origin: this.origin(), columns: width, lastRun: this.lastRun() });
  };

  private readonly onPrinted = (): void => {
    delete document.documentElement.dataset["printing"];
    this.width = 0;
    this.resize();
  };

  // ---- time

  private whole(): [number, number] {
    const all = [...this.samples.values()];
    const begins = all.flatMap(({ begin }) => begin ?? []);
    const ends = all.flatMap(({ end }) => end ?? []);
    return ends.length === 0 ? [0, 1] : [Math.min(...begins), Math.max(...ends)];
  }

  private now(): number {
    return this.whole()[1];
  }

  private range(): [number, number] {
    if (this.zoomed !== undefined) return this.zoomed;
    const { window } = this.model.settings;
    if (this.run?.at !== undefined) return this.runRange(this.run.at);
    if (!this.source.isLive) return this.whole();
    const end = this.paused ? this.pausedAt : this.now();
    return [end - window, end];
  }

  private origin(): number {
    return Math.floor(this.range()[0] / ORIGIN_S) * ORIGIN_S;
  }

  private pause(on: boolean): void {
    this.pausedAt = this.now();
    this.paused = on;
    if (!on) {
      this.zoomed = undefined;
      this.wentTo = undefined;
      this.showCursors(false); // the plots move away from them
      if (this.run?.trigger.mode === "single") this.arm(undefined);
    }
    this.dirty = true;
    this.resetButton.disabled = this.zoomed === undefined;
    put(this.pauseButton, on ? t("go_on") : t("pause_plots"));
    this.pauseButton.setAttribute("aria-pressed", String(on));
  }

  private zoom(range: [number, number] | undefined): void {
    if (range !== undefined && !this.paused && this.source.isLive) this.pause(true);
    this.zoomed = range;
    this.resetButton.disabled = range === undefined;
    this.dirty = true;
  }

  /** @param left [px] in the window */
  private timeAt(left: number): number {
    const [first] = this.plots;
    if (first === undefined) return 0;
    return first.plot.posToVal(left - first.plot.over.getBoundingClientRect().left, "x") + this.origin();
  }

  /** @return the time under the cursor; undefined without one */
  private cursorTime(): number | undefined {
    return this.cursorLeft < 0 || this.plots.length === 0 ? undefined : this.plots[0].plot.posToVal(this.cursorLeft, "x") + this.origin();
  }

  private listen(plot: uPlot): void {
    plot.over.addEventListener("dblclick", () => this.zoom(undefined));
    plot.over.addEventListener("wheel", (event) => this.onWheel(plot, event), { passive: false });
    plot.over.addEventListener("pointerdown", (event) => this.beginPan(plot, event));
  }

  private onSelect(plot: uPlot): void {
    const { left, width } = plot.select;
    if (width < LEAST_DRAG) return;
    const origin = this.origin();
    this.zoom([plot.posToVal(left, "x") + origin, plot.posToVal(left + width, "x") + origin]);
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  }

  /** Shows earlier and later times while the plot is dragged. A vertical touch scrolls the page. */
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
      if (moves) return;
      this.cursors.bring(from + (down.clientX - plot.over.getBoundingClientRect().left) * perPixel);
      this.dirty = true;
    };
    plot.over.setPointerCapture(down.pointerId);
    plot.over.addEventListener("pointermove", move);
    plot.over.addEventListener("lostpointercapture", end);
  }

  /** Without Ctrl, the wheel scrolls the page as usual. */
  private onWheel(plot: uPlot, event: WheelEvent): void {
    if (!event.ctrlKey) return;
    event.preventDefault();
    const [from, to] = this.range();
    const middle = plot.posToVal(event.offsetX, "x") + this.origin();
    const factor = event.deltaY < 0 ? 0.8 : 1.25;
    const [begin, end] = this.whole();
    const longest = Math.max(LONGEST_WINDOW_S, this.source.isLive ? 0 : end - begin);
    const span = Math.min(longest, Math.max(LEAST_WINDOW_S, (to - from) * factor));
    const share = (middle - from) / (to - from);
    this.zoom([middle - span * share, middle + span * (1 - share)]);
  }

  // ---- trigger

  private arm(trigger: Trigger | undefined): void {
    const samples = trigger === undefined ? undefined : this.samples.get(trigger.axis);
    const before = this.run?.at;
    this.run = undefined;
    this.dirty = true;
    if (trigger !== undefined && samples === undefined) {
      this.model.outcome = { ok: false, text: `${t("trigger")}: ${t("no_axis")} ${trigger.axis}` };
      return;
    }
    if (trigger === undefined || samples === undefined) return;
    if (this.source.isLive) {
      if (this.zoomed !== undefined || this.paused) this.pause(false);
      this.run = new TriggerRun(trigger, samples, () => this.source.events.events, this.now());
      return;
    }
    // In a recording, each press finds the next trigger.
    this.run = new TriggerRun(trigger, samples, () => this.source.events.events, before ?? this.whole()[0]);
    this.zoom(undefined);
  }

  private runRange(at: number): [number, number] {
    const { window } = this.model.settings;
    const before = (this.run?.trigger.before ?? 0) * window;
    return [at - before, at - before + window];
  }

  /** Searches for the trigger in the new samples. */
  private follow(): void {
    const { run } = this;
    if (run === undefined) {
      this.trigger.show("", false);
      return;
    }
    const { trigger } = run;
    const { isLive } = this.source;
    const isHeld = run.at !== undefined && (trigger.mode === "single" || !isLive);
    const end = isLive ? this.now() : Infinity;
    if (!this.paused && !isHeld && run.advance(this.model.settings.window, end)) this.hold(run);
    this.captureEveryTick(run);
    if (run.isWithoutSignal) {
      this.run = undefined;
      this.model.outcome = { ok: false, text: `${t("trigger")}: ${trigger.axis} ${t("no_signal")} ${trigger.member}` };
      return;
    }
    const found = run.at === undefined ? "" : `${t("triggered")} ${timeText(run.at)}`;
    const waits = isHeld ? "" : t(run.isFilling ? "trigger_fills" : isLive ? "trigger_waits" : "trigger_finds_none");
    this.trigger.show([found, waits].filter((text) => text !== "").join("; "), isLive && !isHeld);
    const hasLast = run.last !== undefined;
    if (this.lastRunButton.disabled === hasLast) this.lastRunButton.disabled = !hasLast;
  }

  /** A run is complete. A single run remains shown. */
  private hold(run: TriggerRun): void {
    this.dirty = true;
    if (run.at === undefined || run.trigger.mode === "normal") return;
    this.zoom(this.runRange(run.at));
  }

  /** Called as soon as the trigger is found, because the black box keeps a fixed time before the request. */
  private captureEveryTick(run: TriggerRun): void {
    if (!this.everyTick.checked || this.captured === run || run.trigger.mode !== "single" || run.found === undefined) return;
    this.captured = run;
    this.capture?.(run, [...this.samples.values()]);
  }

  private lastRun(): number | undefined {
    const { at, last } = this.run ?? {};
    return this.showsLastRun && at !== undefined && last !== undefined ? at - last : undefined;
  }

  private toggleLastRun(): void {
    this.showsLastRun = !this.showsLastRun;
    this.lastRunButton.setAttribute("aria-pressed", String(this.showsLastRun));
    this.dirty = true;
  }

  // ---- drawing

  private resize(): void {
    const main = this.root.closest("main");
    const width = this.root.clientWidth - 2;
    if (main === null || width < 100 || "printing" in document.documentElement.dataset) return;
    this.observer.observe(main);
    const height = this.heightIn(main);
    if (width !== this.width || height !== this.height) this.fitPlots(width, height);
  }

  private fitPlots(width: number, height: number): void {
    this.width = width;
    this.height = height;
    this.plots.forEach(({ plot }, i) => {
      plot.setSize({ width, height: i === this.plots.length - 1 ? height + TIME_AXIS_HEIGHT : height });
    });
    this.dirty = true;
  }

  /** All plots together fill the window from the top of the scope down. If the scope begins in the lower half of the
   *  window (on a narrow screen it is below the controls), they fill a whole window.
   *  @return the height [px] of each plot */
  private heightIn(main: HTMLElement): number {
    const others = this.root.offsetHeight - this.plots.reduce((sum, { plot }) => sum + plot.height, 0);
    const top = this.root.getBoundingClientRect().top - main.getBoundingClientRect().top + main.scrollTop;
    const above = top < main.clientHeight / 2 ? top : MARGIN;
    const room = main.clientHeight - above - MARGIN - others - TIME_AXIS_HEIGHT;
    return Math.max(LEAST_HEIGHT, Math.floor(room / Math.max(1, this.plots.length)));
  }

  private draw(shown: Shown): void {
    this.marks = this.model.settings.marks ? this.marksIn(shown) : [];
    for (const plot of this.plots) plot.draw(shown);
    for (const bits of this.bits) bits.draw(shown, this.width);
    this.cursors.place(shown);
  }

  /** Shows the values under the cursor, or else at the right edge. */
  private showReadings(): void {
    const asked = this.cursorTime();
    const time = asked ?? this.range()[1];
    for (const plot of this.plots) plot.show(time);
    for (const bits of this.bits) bits.show(!this.paused);
    const [first] = this.samples.values();
    const number = first?.history.nearest(time - first.origin);
    if (number !== undefined) {
      const there = first.origin + first.history.time(number);
      const named = asked === undefined ? "" : this.nameMark(asked);
      const what = asked === undefined ? "" : `${t("cursor")} `;
      put(this.cursorText, `${what}${timeText(there)}, ${t("tick")} ${first.tickAt(there)}${named}`);
    }
    const lost = [...this.samples.values()].reduce((sum, samples) => sum + samples.lost, 0);
    put(this.lostText, lost === 0 ? "" : `${lost} ${t("missed")}`);
    mark(this.lostText, "bad", lost > 0);
  }

  // ---- marks

  private toggleMarks(pressed: HTMLButtonElement): void {
    const { settings } = this.model;
    settings.marks = !settings.marks;
    this.model.saveSettings();
    pressed.setAttribute("aria-pressed", String(settings.marks));
    this.dirty = true;
  }

  /** The events of the axes and of their benches. */
  private marksIn({ from, to }: Shown): PlacedMark[] {
    return [...this.samples.values()].flatMap((samples) => {
      const { bench, axis, address } = samples.axis;
      const [first, last] = [samples.tickAt(from), samples.tickAt(to)];
      const inside = ({ tick }: { tick: number }) => tick >= first && tick <= last;
      const isOf = (event: LogEvent) => event.bench === bench && (event.axis === axis || event.axis === 0) && inside(event);
      const marks = marksOf(samples.moments.filter(inside), this.source.events.events.filter(isOf));
      return marks.map((made) => ({ mark: made, time: samples.timeOf(made.tick), axis: address }));
    });
  }

  private drawMarks({ plot, samples }: PlotStrip, hasLabels: boolean): void {
    const { ctx, bbox } = plot;
    const ratio = window.devicePixelRatio || 1;
    const origin = this.origin();
    const colours = { state: colour("accent"), fault: colour("bad"), event: colour("warn") } satisfies Record<MarkKind, string>;
    const line = (time: number, stroke: string, dash: number[], width: number) => {
      const x = plot.valToPos(time - origin, "x", true);
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
    for (const { mark: { kind, moment }, time, axis } of this.marks) {
      if (axis !== samples.axis.address) continue;
      const room = kind === "fault" ? 1 : MARK_ROOM;
      const place = `${kind} ${Math.round(plot.valToPos(time - origin, "x", true) / (room * ratio))}`;
      if (drawn.has(place)) continue; // many marks must not cover the lines
      drawn.add(place);
      const x = line(time, colours[kind], MARK_DASHES[kind], 1);
      if (!hasLabels || x === undefined || moment?.code === undefined || x - labelled < LABEL_SPACE * ratio) continue;
      labelled = x;
      ctx.fillStyle = colours[kind];
      ctx.textAlign = "left";
      ctx.fillText(formatHex(moment.code), x + 3 * ratio, bbox.top + 10 * ratio);
    }
    for (const time of [this.wentTo, this.run?.at]) if (time !== undefined) line(time, colour("text"), [1, 2], 2);
    for (const time of this.cursors.times ?? []) line(time, colour("text"), [], 1);
    ctx.restore();
  }

  /** @return the mark under the pointer, in words. */
  private nameMark(time: number): string {
    const [from, to] = this.range();
    const reach = (MARK_REACH * (to - from)) / Math.max(1, this.width - AXIS_WIDTH - RIGHT_MARGIN);
    const away = (placed: PlacedMark) => Math.abs(placed.time - time);
    const near = this.marks.filter((placed) => away(placed) <= reach).sort((a, b) => away(a) - away(b));
    const named = this.samples.size > 1;
    const texts = near.slice(0, 2).map(({ mark: made, axis }) => (named ? `${axis} ` : "") + this.markText(made));
    return texts.length === 0 ? "" : `: ${texts.join("; ")}`;
  }

  private markText({ moment, event }: Mark): string {
    if (moment?.state !== undefined) return stateName(moment.state);
    if (moment?.code !== undefined) return `${formatHex(moment.code)} ${this.model.errorName(moment.code)}`;
    return event?.message ?? "";
  }

  // ---- two cursors

  /** Pauses the plots too, because the cursors stand still. */
  private showCursors(on: boolean): void {
    if (on && !this.paused && this.source.isLive) this.pause(true);
    const [from, to] = this.range();
    this.setCursors(on ? [from + (to - from) / 3, from + ((to - from) * 2) / 3] : undefined);
  }

  private setCursors(times: [number, number] | undefined): void {
    this.cursors.show(times);
    this.cursorButton.setAttribute("aria-pressed", String(times !== undefined));
    this.dirty = true;
  }
}
