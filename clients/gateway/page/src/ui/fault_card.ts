// SPDX-License-Identifier: Apache-2.0
// Why an axis faulted: the windows of its bench's black box, newest first. They exist even if nobody was watching.

import { FAULT, scaleOf, strip, WINDOWS, windowsOf, type Fault, type FaultSeries, type KeptWindow } from "../data/faults";
import { timeText } from "../data/times";
import { formatHex, formatPermille, formatUnits } from "../data/units";
import { t, type TextKey } from "../i18n";
import { addressOf, type AxisRef, type Model } from "../model";
import { checked } from "../protocol/checked";
import type { Recording } from "../recording";
import type { Trace } from "../trace";
import { recordingOfWindow } from "../window";
import { button, h, mark, put, s, select, type View } from "./dom";

const ASK_EVERY_MS = 2_000;
const WIDTH = 640; // [px] of a strip
const HEIGHT = 44;
const MOST_WRITES = 12;

/** The strips of the picture. */
const STRIPS: { series: FaultSeries; text: TextKey; unit: "position" | "velocity" | "torque"; demand?: FaultSeries }[] = [
  { series: "load_position_actual_value", text: "position", unit: "position", demand: "position_demand_value" },
  { series: "load_position_error_value", text: "error", unit: "position" },
  { series: "load_velocity_actual_value", text: "velocity", unit: "velocity" },
  { series: "torque_actual_value", text: "torque", unit: "torque" },
];

export class FaultCard implements View {
  readonly root: HTMLDetailsElement;
  private readonly summary = h("summary");
  private readonly body = h("div", { class: "fault-body" });
  private readonly choice = h("div", { class: "tools" });
  private readonly state = h("p", { class: "hint" });
  private readonly resetButton: HTMLButtonElement;
  private asking = false;
  private askedAt = -Infinity;
  private known = "";
  private shown?: number;
  private newest = "";
  private wasFaulted = false;

  constructor(
    private readonly model: Model,
    private readonly ref: AxisRef,
    private readonly trace: Trace,
    private readonly openInScope: (recording: Recording) => void,
  ) {
    const reset = () => void model.command("/reset", { axes: [addressOf(ref)] });
    this.resetButton = button(t("reset"), reset, { attributes: { "data-test": "reset-fault" } });
    this.root = h("details", { class: "panel fault-card" }, this.summary, this.choice, this.state, this.body);
    this.root.hidden = true;
    this.root.addEventListener("toggle", () => void this.show(this.shown));
  }

  update(now: number): void {
    const isFaulted = (this.trace.last["error_code"] ?? 0) !== 0;
    mark(this.root, "faulted", isFaulted);
    put(this.summary, `${t(isFaulted ? "fault" : "last_fault")}: ${this.newest}`);
    if (isFaulted && !this.wasFaulted) this.root.open = true;
    this.wasFaulted = isFaulted;
    this.resetButton.hidden = !isFaulted;
    this.resetButton.disabled = this.model.whyDisabled([this.ref], now) !== "";
    this.resetButton.title = this.model.whyDisabled([this.ref], now);
    if (this.asking || !this.model.connected || now - this.askedAt < ASK_EVERY_MS) return;
    this.askedAt = now;
    void this.ask();
  }

  private async ask(): Promise<void> {
    if (!this.model.connection.hasService("/faults")) return;
    this.asking = true;
    const answer = await this.model.connection.call("/faults", { bench: this.ref.bench.number });
    this.asking = false;
    if (!answer.ok) return; // the bench has no black box
    const windows = windowsOf(checked(WINDOWS, answer, "/faults").windows, this.ref.axis.axis);
    const known = windows.map(({ window, is_open }) => `${window}${is_open ? "+" : ""}`).join();
    if (known === this.known) return;
    this.known = known;
    this.list(windows);
  }

  private list(windows: KeptWindow[]): void {
    this.root.hidden = windows.length === 0;
    const newest = windows.find(({ is_open }) => !is_open);
    if (windows.length === 0 || newest === undefined) return;
    this.newest = this.nameOf(windows[0]);
    const options = windows.filter(({ is_open }) => !is_open).map((window) => ({ value: String(window.window), text: this.nameOf(window) }));
    const chosen = select(t("faults"), options, String(newest.window), (value) => void this.show(Number(value)));
    const open = button(t("open_in_scope"), () => void this.open(), { attributes: { "data-test": "fault-scope" } });
    this.choice.replaceChildren(chosen, open, this.resetButton);
    this.body.replaceChildren();
    void this.show(newest.window);
  }

  /** Names a window by the cause that belongs to this axis. */
  private nameOf({ causes }: KeptWindow): string {
    const cause = causes.find(({ axis }) => axis === this.ref.axis.axis) ?? causes[0];
    const what = cause.code === 0 ? cause.kind : `${formatHex(cause.code)} ${this.model.errorName(cause.code)}`;
    return `${what}, ${this.timeOf(cause.tick)}`;
  }

  private timeOf(tick: number): string {
    return timeText(tick * this.trace.period);
  }

  /** Opens every signal of the axis in the window that is shown. */
  private async open(): Promise<void> {
    if (this.shown === undefined) return;
    try {
      this.openInScope(await recordingOfWindow(this.model, this.shown, [this.trace]));
    } catch (error) {
      this.model.outcome = { ok: false, text: (error as Error).message };
    }
  }

  private async show(window?: number): Promise<void> {
    const isShown = window === this.shown && this.body.childElementCount > 0;
    this.shown = window;
    if (window === undefined || isShown || !this.root.open) return;
    put(this.state, t("fault_waits"));
    const answer = await this.model.connection.call("/fault", { window, axis: addressOf(this.ref) });
    if (window !== this.shown) return; // another one was chosen
    if (!answer.ok) {
      put(this.state, String(answer["message"] ?? ""));
      return;
    }
    put(this.state, "");
    const fault = checked(FAULT, answer, "/fault");
    this.body.replaceChildren(...this.stories(fault), this.picture(fault), this.writes(fault));
  }

  private stories({ stories }: Fault): HTMLElement[] {
    return stories.map(({ title, lines, remedy }) =>
      h(
        "div",
        { class: "story" },
        h("strong", {}, title),
        h("ul", {}, ...lines.map((line) => h("li", {}, line))),
        remedy !== "" && h("p", { class: "remedy" }, `→ ${remedy}`),
      ),
    );
  }

  /** A strip for each value, with a line at the fault and at each write. */
  private picture(fault: Fault): HTMLElement {
    const { tick } = fault.samples;
    const first = tick[0];
    const span = Math.max(1, tick[tick.length - 1] - first);
    const at = (of: number) => (((of - first) / span) * WIDTH).toFixed(1);
    const line = (of: number, name: string) => s("line", { class: name, x1: at(of), x2: at(of), y1: 0, y2: HEIGHT });
    const cause = fault.kept.causes.find(({ axis }) => axis === this.ref.axis.axis);
    const strips = STRIPS.map(({ series, text, unit, demand }) => {
      const actual = fault.samples[series];
      const wanted = demand === undefined ? [] : fault.samples[demand];
      const scale = scaleOf(actual, wanted);
      const lines = fault.writes.map((write) => line(write.tick, "written"));
      if (cause !== undefined) lines.push(line(cause.tick, "cause"));
      return h(
        "figure",
        {},
        h("figcaption", {}, `${t(text)}: ${this.valueText(scale.low, unit)} … ${this.valueText(scale.high, unit)}`),
        s(
          "svg",
          { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", role: "img", "aria-label": t(text) },
          ...lines,
          ...(wanted.length > 0 ? [s("polyline", { class: "demand", points: strip(wanted, scale, WIDTH, HEIGHT) })] : []),
          s("polyline", { class: "actual", points: strip(actual, scale, WIDTH, HEIGHT) }),
        ) as unknown as HTMLElement,
      );
    });
    const ends = h("p", { class: "hint" }, `${this.timeOf(first)} – ${this.timeOf(tick[tick.length - 1])}`);
    return h("div", { class: "fault-picture" }, ...strips, ends);
  }

  private valueText(value: number, unit: "position" | "velocity" | "torque"): string {
    if (unit === "torque") return `${formatPermille(value)} %`;
    const scale = this.model.scale(this.ref.axis);
    return `${formatUnits(value, scale)} ${scale.name}${unit === "velocity" ? "/s" : ""}`;
  }

  private writes({ kept, writes }: Fault): HTMLElement {
    const cause = kept.causes[0].tick;
    const rows = writes.slice(-MOST_WRITES).map(({ tick, text, refused, by }) =>
      h(
        "li",
        {},
        h("span", { class: "number time" }, `${((tick - cause) * this.trace.period * 1e3).toFixed(1)} ms`),
        h("span", { class: "message" }, `${text}${refused ? ` (${t("refused")})` : ""}`),
        h("span", { class: "source" }, by),
      ),
    );
    const more = writes.length - rows.length;
    return h("div", {}, h("h4", {}, more > 0 ? `${t("writes")} (+${more})` : t("writes")), h("ol", { class: "fault-writes" }, ...rows));
  }
}
