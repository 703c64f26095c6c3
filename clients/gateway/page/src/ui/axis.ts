// SPDX-License-Identifier: Apache-2.0
// The view of one axis: figures, plots, words, state machine, controls, events, objects.

import type { LogEvent } from "../data/events";
import { INPUT_BIT } from "../data/motions";
import { decodePowerState, STATUS_BIT } from "../data/power";
import { formatTime } from "../data/times";
import { formatAge, formatHex, formatPermille, formatUnits } from "../data/units";
import { modeName, stateName, t, type TextKey } from "../i18n";
import { addressOf, type Model } from "../model";
import type { Recording } from "../recording";
import type { Source } from "../source";
import type { Trace } from "../trace";
import { Commands } from "./commands";
import { FOCUS, h, mark, put, type View } from "./dom";
import { PowerMachine, Words } from "./drive";
import { Events } from "./events";
import { FaultCard } from "./fault_card";
import { Findings } from "./findings";
import { Modes } from "./modes";
import { Objects } from "./objects";
import { presetOf, Scope } from "./scope";

const FIGURES: { key: string; text: TextKey; wide?: boolean }[] = [
  { key: "state", text: "state", wide: true },
  { key: "mode", text: "mode", wide: true },
  { key: "enabled", text: "enabled" },
  { key: "homed", text: "homed" },
  { key: "limits", text: "limits" },
  { key: "position", text: "position" },
  { key: "velocity", text: "velocity" },
  { key: "torque", text: "torque" },
  { key: "error", text: "error" },
  { key: "owner", text: "owner" },
  { key: "fault", text: "fault", wide: true },
  { key: "age", text: "age" },
];
const FIGURES_EVERY_MS = 66;
const OLD_FROM_MS = 500;

/** The line of figures above the plots. */
class Figures implements View {
  readonly root = h("dl", { class: "figures panel" });
  private readonly cells = new Map<string, HTMLElement>();
  private readonly lamp = h("span", { class: "lamp" });
  private readonly state = h("span");
  private readonly lamps = new Map<string, { lamp: HTMLElement; text: HTMLElement }>();
  private shownAt = 0;

  constructor(
    private readonly model: Model,
    private readonly trace: Trace,
  ) {
    for (const { key, text, wide } of FIGURES) {
      const value = h("dd", { class: wide === true ? "" : "number", attributes: { "data-figure": key } });
      this.cells.set(key, value);
      this.root.append(h("div", { class: wide === true ? "wide" : "" }, h("dt", {}, t(text)), value));
    }
    this.cells.get("state")?.append(this.lamp, this.state);
    for (const key of ["enabled", "homed", "limits"] as const) {
      const made = { lamp: h("span", { class: "lamp" }), text: h("span") };
      this.lamps.set(key, made);
      const cell = this.cells.get(key);
      cell?.append(made.lamp, made.text);
      if (cell !== undefined) cell.title = t(`${key}_hint`);
    }
  }

  update(now: number): void {
    if (now - this.shownAt < FIGURES_EVERY_MS) return;
    this.shownAt = now;
    const { last } = this.trace;
    const age = this.model.age(this.trace.ref.bench, now);
    this.set("age", formatAge(age));
    mark(this.root, "old", age > OLD_FROM_MS);
    if (last["ds402_statusword"] === undefined) return;
    const scale = this.model.scale(this.trace.ref.axis);
    const state = decodePowerState(last["ds402_statusword"]);
    const lamp = `lamp ${state}`;
    if (this.lamp.className !== lamp) this.lamp.className = lamp;
    put(this.state, stateName(state));
    this.showLamps(state === "operation_enabled");
    this.set("mode", modeName(last["op_mode_actual"]));
    this.set("position", `${formatUnits(last["load_position_actual_value"], scale)} ${scale.name}`);
    this.set("velocity", `${formatUnits(last["load_velocity_actual_value"], scale)} ${scale.name}/s`);
    this.set("torque", `${formatPermille(last["torque_actual_value"])} %`);
    this.set("error", `${formatUnits(last["load_position_error_value"], scale)} ${scale.name}`);
    const owner = this.model.ownerName(this.trace.owner);
    this.set("owner", owner === "" ? t("free") : owner === "@" ? t("this_page") : owner);
    const fault = last["error_code"];
    this.set("fault", fault === 0 ? "–" : `${formatHex(fault)} ${this.model.errorName(fault)}`);
    mark(this.root, "faulted", fault !== 0);
  }

  private showLamps(isEnabled: boolean): void {
    const { last, homedAt, period } = this.trace;
    this.light("enabled", isEnabled ? "operation_enabled" : "", t(isEnabled ? "yes" : "no"));
    const homed = homedAt === undefined ? "?" : homedAt === false ? t("no") : formatTime(homedAt * period, 0);
    this.light("homed", typeof homedAt === "number" ? "operation_enabled" : "", homed);
    const inputs = last["digital_inputs"] ?? 0;
    const limits = [
      inputs & INPUT_BIT.negativeLimit && "−",
      inputs & INPUT_BIT.positiveLimit && "+",
      last["ds402_statusword"] & STATUS_BIT.internalLimit && t("bit_11"),
    ].filter((limit) => limit !== 0);
    this.light("limits", limits.length > 0 ? "quick_stop_active" : "", limits.length > 0 ? limits.join(" ") : t("none"));
  }

  private light(key: string, colour: string, text: string): void {
    const made = this.lamps.get(key);
    if (made === undefined) return;
    const wanted = `lamp ${colour}`.trim();
    if (made.lamp.className !== wanted) made.lamp.className = wanted;
    put(made.text, text);
  }

  private set(key: string, text: string): void {
    const cell = this.cells.get(key);
    if (cell !== undefined) put(cell, text);
  }
}

export class AxisView implements View {
  readonly root: HTMLElement;
  private readonly parts: View[];
  private readonly scope: Scope;

  /** @param query of the link that opened this view, for the plots */
  constructor(
    private readonly model: Model,
    private readonly trace: Trace,
    source: Source,
    query: string,
    openInScope: (recording: Recording) => void,
  ) {
    const { ref } = trace;
    const address = addressOf(ref);
    const figures = new Figures(model, this.trace);
    const scope = new Scope(model, source, presetOf(address), query, false);
    this.scope = scope;
    const commands = new Commands(model, () => [ref]);
    const modes = new Modes(model, this.trace);
    const machine = new PowerMachine(this.trace);
    const words = new Words(model, this.trace);
    const isOwn = ({ bench, axis }: LogEvent) => bench === ref.bench.number && (axis === ref.axis.axis || axis === 0);
    const events = new Events(model, model.events, isOwn, ({ time }) => scope.goTo(time));
    const findings = new Findings(model, ref, (tick) => scope.goTo(trace.timeOf(tick)));
    const objects = new Objects(model, ref);
    const faultCard = new FaultCard(model, ref, this.trace, openInScope);
    this.parts = [faultCard, figures, scope, commands, modes, machine, words, events, findings, objects];
    const title = h(
      "div",
      { class: "title" },
      h("a", { attributes: { href: "#/", "aria-label": t("back") } }, "‹"),
      h("h2", { attributes: FOCUS }, `${address} `, h("span", { class: "axis-name" }, ref.axis.name)),
    );
    this.root = h(
      "div",
      { class: "axis-view" },
      h("div", { class: "head" }, title, faultCard.root),
      figures.root,
      // The keyboard order is that of a narrow screen, where the controls are above the plots.
      h("div", { class: "control-column" }, commands.root, modes.root),
      h("div", { class: "main-column" }, scope.root, objects.root),
      h("div", { class: "side-column" }, machine.root, words.root, events.root, findings.root),
    );
  }

  update(now: number): void {
    for (const part of this.parts) part.update(now);
    this.goToWanted();
  }

  /** Goes to the event that was chosen in another view. */
  private goToWanted(): void {
    const { wantedMoment } = this.model;
    if (wantedMoment === undefined) return;
    const isHere = wantedMoment.address === addressOf(this.trace.ref);
    if (isHere && this.trace.history.end === 0) return;
    this.model.wantedMoment = undefined;
    if (isHere) this.scope.goTo(this.trace.timeOf(wantedMoment.tick));
  }

  redraw(): void {
    for (const part of this.parts) part.redraw?.();
  }

  close(): void {
    for (const part of this.parts) part.close?.();
  }
}
