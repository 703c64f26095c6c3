// SPDX-License-Identifier: Apache-2.0
// The controls of axes. Each calls a service of the gateway, whose answer is shown at the bottom of the page.

import { nameMatches } from "../data/rows";
import { parseNumber, whyNoNumber } from "../data/units";
import { clockName, isTextKey, t, type TextKey } from "../i18n";
import { addressOf, listed, type AxisRef, type Disturbance, type Model } from "../model";
import { attempt, button, field, h, put, select, type View } from "./dom";
import { Homing, HOMING_METHOD } from "./homing";
import { PolledObjects } from "./polled";
import { KeptCheckbox, QuantityField } from "./quantity";
import { askingButton } from "./question";
import { ABORT_OPTION_CODE, Silence } from "./silence";

const JOG_EVERY_MS = 100;
/** Jog speed of a linear axis [units/s] */
const LINEAR_JOG = 5;
const INPUTS_EVERY_MS = 1_000;

type Axes = () => AxisRef[];

function addresses(axes: Axes): string[] {
  return axes().map(addressOf);
}

function group(title: TextKey, ...children: Node[]): HTMLFieldSetElement {
  return h("fieldset", {}, h("legend", {}, t(title)), ...children);
}

function serviceButton(model: Model, axes: Axes, service: string, text: TextKey, asks = false): HTMLElement {
  const name = service.slice(1);
  const press = (chosen: string[]) => void model.command(service, { axes: chosen });
  if (asks) {
    let asked: string[] = []; // named in the question: axes chosen later are left out
    const question = () => `${t(text)}: ${listed((asked = addresses(axes)))}?`;
    return askingButton(t(text), name, question, () => press(asked));
  }
  return button(t(text), () => press(addresses(axes)), { attributes: { "data-test": name } });
}

/** @return the typed number, undefined for an empty field.
 *  @throws Error if the text is not a number. */
function typed(input: HTMLInputElement): number | undefined {
  if (input.value.trim() === "") return undefined;
  const value = parseNumber(input.value);
  if (value === undefined) throw new Error(`"${input.value}" ${t(whyNoNumber(input.value))}`);
  return value;
}

/** @throws Error if the text is not an integer. */
function typedWhole(input: HTMLInputElement): number | undefined {
  const value = typed(input);
  if (value !== undefined && !Number.isInteger(value)) throw new Error(`"${input.value}" ${t("fraction")}`);
  return value;
}

class Ramps {
  readonly root: HTMLElement;
  private readonly fields: [name: string, field: QuantityField][];

  constructor(model: Model) {
    const as_set = { placeholder: t("as_set") };
    this.fields = [
      ["velocity", new QuantityField(model, t("velocity"), "/s", as_set)],
      ["acceleration", new QuantityField(model, t("acceleration"), "/s²", as_set)],
      ["deceleration", new QuantityField(model, t("deceleration"), "/s²", as_set)],
    ];
    this.root = h("div", { class: "fields" }, ...this.fields.map(([, made]) => made.root));
  }

  bind(key: string, ref: AxisRef): void {
    for (const [name, made] of this.fields) made.bind(`${key} ${name}`, ref);
  }

  read(notes: string[]): object {
    return Object.fromEntries(this.fields.map(([name, made]) => [name, made.read(notes)]));
  }
}

/** Moves one axis. */
class MoveForm {
  readonly root: HTMLElement;
  private readonly target: QuantityField;
  private readonly ramps: Ramps;
  private readonly relative: KeptCheckbox;
  private readonly queue: KeptCheckbox;

  constructor(
    private readonly model: Model,
    private readonly axis: () => AxisRef | undefined,
  ) {
    this.target = new QuantityField(model, t("target"), "", { id: "move-target" });
    this.ramps = new Ramps(model);
    this.relative = new KeptCheckbox(model, t("relative"));
    this.queue = new KeptCheckbox(model, t("queue"));
    const form = h("form", {}, h("div", { class: "fields" }, this.target.root), this.ramps.root);
    form.append(
      h("div", { class: "line" }, this.relative.root, this.queue.root, h("button", { class: "primary", attributes: { "data-test": "move" } }, t("move"))),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      attempt(model, () => this.move());
    });
    this.root = form;
  }

  update(): void {
    const ref = this.axis();
    if (ref === undefined) return;
    const key = `move ${addressOf(ref)}`;
    this.target.bind(`${key} target`, ref);
    this.ramps.bind(key, ref);
    this.relative.bind(`${key} relative`);
    this.queue.bind(`${key} queue`);
  }

  private move(): void {
    const ref = this.axis();
    if (ref === undefined) return;
    const notes: string[] = [];
    const position = this.target.read(notes);
    if (position === undefined) throw new Error(t("no_target"));
    const request = {
      axis: addressOf(ref),
      position,
      relative: this.relative.input.checked,
      queue: this.queue.input.checked,
      ...this.ramps.read(notes),
    };
    void this.model.command("/move", request, notes);
  }
}

/** Two buttons that move an axis while they are pressed. One press is one jog: once it has ended, the axis moves
 *  again only with a new press. */
class Jog {
  readonly root: HTMLElement;
  private readonly speed: QuantityField;
  private pressed = false;
  private timer = 0;
  private jogged = "";

  constructor(
    private readonly model: Model,
    private readonly axis: () => AxisRef | undefined,
  ) {
    this.speed = new QuantityField(model, t("velocity"), "/s");
    const buttons = ([-1, 1] as const).map((sign) => {
      const made = h("button", {
        class: "jog",
        title: t("jog_hint"),
        attributes: { type: "button", "aria-label": t(sign < 0 ? "jog_minus" : "jog_plus"), "data-test": sign < 0 ? "jog-minus" : "jog-plus" },
      }, sign < 0 ? "◀ −" : "+ ▶");
      made.addEventListener("pointerdown", (event) => {
        made.setPointerCapture(event.pointerId);
        this.start(sign);
      });
      for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur", "keyup"]) {
        made.addEventListener(end, () => this.end());
      }
      made.addEventListener("keydown", (event) => {
        if ((event.key === " " || event.key === "Enter") && !event.repeat) this.start(sign);
      });
      made.addEventListener("contextmenu", (event) => event.preventDefault());
      return made;
    });
    this.root = h("div", { class: "line" }, buttons[0], buttons[1], this.speed.root);
    // A window in the background gets no event when the button is released.
    window.addEventListener("blur", this.onLeave);
    window.addEventListener("pagehide", this.onLeave);
    document.addEventListener("visibilitychange", this.onLeave);
  }

  close(): void {
    this.end();
    window.removeEventListener("blur", this.onLeave);
    window.removeEventListener("pagehide", this.onLeave);
    document.removeEventListener("visibilitychange", this.onLeave);
  }

  private readonly onLeave = (): void => this.end();

  update(): void {
    const ref = this.axis();
    if (ref === undefined) return;
    this.speed.bind(`jog ${addressOf(ref)}`, ref, (scale) => {
      // Half a turn per second is visible, and slow enough for a first try.
      const { kind, per } = ref.axis.unit ?? { kind: "rotary", per: 4096 };
      const slow = kind === "rotary" ? per / 2 : per * LINEAR_JOG;
      return String(Number((slow * scale.factor).toFixed(scale.decimals)));
    });
  }

  end(): void {
    if (!this.pressed) return;
    this.pressed = false;
    // The gateway needs the release before it accepts a new press, even if the jog has already ended. In that case
    // call() is used, because command() would replace the line that shows why the jog ended.
    const release = { axis: this.jogged, velocity: 0 };
    if (this.timer === 0) void this.model.connection.call("/jog", release);
    else void this.model.command("/jog", release);
    this.stopRepeating();
  }

  private stopRepeating(): void {
    window.clearInterval(this.timer);
    this.timer = 0;
  }

  private start(sign: number): void {
    const ref = this.axis();
    if (ref === undefined || this.pressed) return;
    attempt(this.model, () => {
      const speed = this.speed.read([]) ?? 0;
      const velocity = sign * Math.abs(speed);
      const axis = addressOf(ref);
      this.jogged = axis;
      const taken = this.model.whyTaken([axis]);
      if (taken !== undefined) throw new Error(`${t("jog")}: ${taken}`);
      let own = 0; // the answer to an earlier press does not end this one
      const send = async () => {
        if (this.model.whyTaken([axis]) !== undefined) {
          this.stopRepeating(); // the session that took the axis has ended the jog
          return;
        }
        const answer = await this.model.connection.call("/jog", { axis, velocity });
        if (answer.ok || this.timer !== own) return;
        this.stopRepeating();
        this.model.outcome = { ok: false, text: `${t("jog")}: ${answer.message}` };
      };
      this.pressed = true;
      own = this.timer = window.setInterval(() => void send(), JOG_EVERY_MS);
      void send();
    });
  }
}

/** The test-bench inputs of axes. */
class TestInputs {
  readonly root: HTMLElement;
  private built?: unknown;
  private readAt = 0;
  /** Increases with each command: values read before it are outdated. */
  private commands = 0;
  private readonly shows = new Map<string, (value: number) => void>();

  constructor(
    private readonly model: Model,
    private readonly axes: Axes,
  ) {
    this.root = h("div", { class: "inputs" });
  }

  update(now: number): void {
    this.build();
    if (now - this.readAt < INPUTS_EVERY_MS || !this.model.connected) return;
    this.readAt = now;
    if (this.axes().length === 1 && this.root.getClientRects().length > 0) void this.read();
  }

  /** Shows the inputs acting on the axis, including those set by other programs. */
  private async read(): Promise<void> {
    const before = this.commands;
    const inputs = this.model.dictionary?.disturbances ?? [];
    const answer = await this.model.connection.call("/read", {
      axis: addresses(this.axes)[0],
      objects: inputs.map((input) => input.object),
    });
    const values = (answer["values"] ?? []) as { value?: number; code?: number }[];
    if (before !== this.commands) return;
    values.forEach(({ value, code }, i) => {
      if (value !== undefined && (code ?? 0) === 0) this.shows.get(inputs[i].name)?.(value);
    });
  }

  private build(): void {
    if (this.built === this.model.dictionary || this.model.dictionary === undefined) return;
    this.built = this.model.dictionary;
    const rows: Node[] = [];
    for (const input of this.model.dictionary.disturbances ?? []) {
      if (input.name === "load_torque") rows.push(this.slider());
      else rows.push(input.kind === "switch" ? this.toggle(input.name) : this.choice(input));
    }
    rows.push(
      button(t("end_disturbances"), () => void this.end(), { attributes: { "data-test": "end_disturbances" } }),
    );
    this.root.replaceChildren(...rows);
  }

  private async end(): Promise<void> {
    ++this.commands;
    const answer = await this.model.command("/end_disturbances", { axes: addresses(this.axes) });
    if (!answer.ok) return;
    for (const show of this.shows.values()) show(0);
  }

  private async disturb(name: string, value: number): Promise<boolean> {
    ++this.commands;
    let ok = true;
    for (const axis of addresses(this.axes)) {
      ok = (await this.model.command("/disturb", { axis, name, value })).ok && ok;
    }
    ++this.commands;
    return ok;
  }

  private toggle(name: string): HTMLElement {
    const input = h("input", { attributes: { type: "checkbox", role: "switch", "data-test": name } });
    input.addEventListener("change", () => {
      const wanted = input.checked;
      void this.disturb(name, wanted ? 1 : 0).then((ok) => {
        if (!ok) input.checked = !wanted;
      });
    });
    this.shows.set(name, (value) => (input.checked = value !== 0));
    return h("label", { class: "switch" }, input, h("span", { class: "knob" }), isTextKey(name) ? t(name) : name);
  }

  /** An input with a few values, of which 0 is off. */
  private choice(input: Disturbance): HTMLElement {
    const label = isTextKey(input.name) ? t(input.name) : input.name;
    const values = Array.from({ length: input.maximum + 1 }, (_, value) => String(value));
    const made = select(
      label,
      values.map((value) => ({ value, text: value })),
      "0",
      (value) => void this.disturb(input.name, Number(value)),
    );
    made.dataset["test"] = input.name;
    this.shows.set(input.name, (value) => (made.value = String(value)));
    return h("label", { class: "choice" }, made, label);
  }

  private slider(): HTMLElement {
    const input = h("input", {
      attributes: { type: "range", min: "-9", max: "9", step: "0.1", value: "0", "aria-label": t("load_torque") },
    });
    const value = h("span", { class: "number" }, "0.0 N·m");
    const show = () => put(value, `${Number(input.value).toFixed(1).replace("-", "−")} N·m`);
    input.addEventListener("input", () => {
      ++this.commands; // so that a read does not move the slider while it is dragged
      show();
    });
    this.shows.set("load_torque", (torque) => {
      input.value = String(torque / 1000);
      show();
    });
    input.addEventListener("change", () => void this.disturb("load_torque", Math.round(Number(input.value) * 1000)));
    return h("label", { class: "slider" }, h("span", {}, t("load_torque")), input, value);
  }
}

/** All controls of some axes. Controls that move a single axis are shown only if there is just one. */
export class Commands implements View {
  readonly root: HTMLElement;
  private readonly needText = h("p", { class: "need" });
  private readonly read: PolledObjects;
  private readonly silence: Silence;
  private readonly homing: Homing;
  private readonly move: MoveForm;
  private readonly jog: Jog;
  private readonly inputs: TestInputs;
  private readonly jogGroup: HTMLFieldSetElement;
  private readonly groups: HTMLFieldSetElement[];

  constructor(
    private readonly model: Model,
    private readonly axes: Axes,
  ) {
    const one = () => axes()[0];
    this.read = new PolledObjects(model, axes, [ABORT_OPTION_CODE, HOMING_METHOD]);
    this.silence = new Silence(model, axes, this.read);
    this.homing = new Homing(model, axes, this.read);
    this.move = new MoveForm(model, one);
    this.jog = new Jog(model, one);
    this.inputs = new TestInputs(model, axes);
    const services = (names: [string, TextKey][], asks = false) =>
      h("div", { class: "line" }, ...names.map(([service, text]) => serviceButton(model, axes, service, text, asks)));
    const motion = services([["/halt", "halt"], ["/resume", "resume"], ["/quick_stop", "quick_stop"]]);
    this.jogGroup = group("jog", this.jog.root);
    this.groups = [
      group("power", services([["/enable", "enable"], ["/disable", "disable"], ["/reset", "reset"]])),
      group("motion", this.move.root, motion, this.homing.root),
      this.jogGroup,
      group("test_inputs", this.inputs.root),
      group("memory", services([["/store", "store"], ["/restore", "restore"], ["/power_cycle", "power_cycle"]], true)),
    ];
    this.root = h("section", { class: "panel commands" }, h("h3", {}, t("control")), this.needText, this.silence.root, ...this.groups);
  }

  update(now: number): void {
    const need = this.model.whyDisabled(this.axes(), now);
    const able = need === "";
    // A disabled button reports no release.
    if (!able) this.jog.end();
    for (const group of this.groups) if (group.disabled === able) group.disabled = !able;
    put(this.needText, need);
    const single = this.axes().length === 1; // several axes move as a group
    this.move.root.hidden = !single;
    this.jogGroup.hidden = !single;
    this.move.update();
    this.jog.update();
    this.inputs.update(now);
    this.read.update(now, this.root);
    this.silence.update();
    this.homing.update();
  }

  close(): void {
    this.jog.close();
  }
}

/** Targets of several axes, which arrive at the same time. */
export class GroupMove implements View {
  readonly root: HTMLElement;
  private readonly list = h("div", { class: "targets" });
  private readonly ramps: Ramps;
  private readonly fields = new Map<string, QuantityField>();
  private readonly fieldset: HTMLFieldSetElement;
  private shownAxes: AxisRef[] = [];
  private shown = "";
  private words: string[] = [];

  constructor(
    private readonly model: Model,
    private readonly axes: Axes,
  ) {
    this.ramps = new Ramps(model);
    const form = h(
      "form",
      {},
      this.list,
      this.ramps.root,
      h("div", { class: "line" }, h("button", { class: "primary", attributes: { "data-test": "move_group" } }, t("move"))),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      attempt(model, () => this.go());
    });
    this.fieldset = group("group_move", h("p", { class: "hint" }, t("group_hint")), form);
    this.root = h("section", { class: "panel" }, this.fieldset);
  }

  update(now: number): void {
    const axes = this.axes();
    this.root.hidden = axes.length < 2;
    const may = this.model.whyDisabled(axes, now) === "";
    if (this.fieldset.disabled === may) this.fieldset.disabled = !may;
    const wanted = axes.map(addressOf).join(" ");
    if (wanted !== this.shown) this.build(axes, wanted);
  }

  /** Hides the empty fields of axes that do not match; an axis with a target will move, so it remains. */
  filter(words: string[]): void {
    this.words = words;
    for (const ref of this.shownAxes) {
      const made = this.fields.get(addressOf(ref));
      if (made === undefined) continue;
      made.root.hidden = made.isEmpty() && !nameMatches(addressOf(ref), ref.axis.name, words);
    }
  }

  /** The text typed for an axis that is still chosen is kept. */
  private build(axes: AxisRef[], wanted: string): void {
    this.shown = wanted;
    this.shownAxes = axes;
    const before = new Map(this.fields);
    this.fields.clear();
    for (const ref of axes) {
      const address = addressOf(ref);
      const made = before.get(address) ?? new QuantityField(this.model, `${address} ${ref.axis.name}`);
      made.bind(`group ${address} target`, ref);
      this.fields.set(address, made);
    }
    if (axes.length > 0) this.ramps.bind("group", axes[0]);
    this.list.replaceChildren(...[...this.fields.values()].map((made) => made.root));
    this.filter(this.words);
  }

  private go(): void {
    const notes: string[] = [];
    const moves = this.axes().flatMap((ref) => {
      const position = this.fields.get(addressOf(ref))?.read(notes);
      return position === undefined ? [] : [{ axis: addressOf(ref), position }];
    });
    if (moves.length === 0) throw new Error(t("no_target"));
    void this.model.command("/move_group", { moves, ...this.ramps.read(notes) }, notes);
  }
}

/** Pause, rate and steps of one bench. */
export class BenchClock implements View {
  readonly root: HTMLElement;
  private readonly text = h("p", { class: "clock-text" });
  private readonly fieldset: HTMLFieldSetElement;
  private readonly rateLine: HTMLElement;
  private readonly stepLine: HTMLElement;

  constructor(
    private readonly model: Model,
    private readonly bench: number,
  ) {
    const rate = field(t("rate"), { value: "1" });
    put(rate.unit, "×");
    const ticks = field(t("step"), { value: "100" });
    put(ticks.unit, t("ticks"));
    const call = (service: string, more: object = {}) => void model.command(service, { bench, ...more });
    this.stepLine = h(
      "div",
      { class: "line", title: t("step_hint") },
      ticks.root,
      button(t("step"), () => attempt(model, () => call("/step", { ticks: typedWhole(ticks.input) ?? 1 })), { attributes: { "data-test": "step" } }),
    );
    this.rateLine = h(
      "div",
      { class: "line" },
      button(t("pause_clock"), () => call("/pause"), { attributes: { "data-test": "pause_clock" } }),
      button(t("run_clock"), () => call("/rate", { rate: 1 })),
      rate.root,
      button(t("set"), () => attempt(model, () => call("/rate", { rate: typed(rate.input) ?? 1 }))),
    );
    this.fieldset = h(
      "fieldset",
      {},
      h("legend", {}, `${t("clock")} ${bench}`),
      this.text,
      this.rateLine,
      this.stepLine,
    );
    this.root = h("section", { class: "panel" }, this.fieldset);
  }

  update(): void {
    const { control, connected } = this.model;
    const may = control.enabled && control.you && connected;
    if (this.fieldset.disabled === may) this.fieldset.disabled = !may;
    const state = this.model.benches.get(this.bench)?.state;
    if (state === undefined) return;
    const steps = state.clock_mode === "lockstep";
    const rate = steps ? "" : state.rate === 0 ? `${t("paused")}, ` : `× ${state.rate}, `;
    put(this.text, `${clockName(state.clock_mode)}, ${rate}${t("tick")} ${state.tick}`);
    this.stepLine.hidden = !steps;
    this.rateLine.hidden = steps;
  }
}
