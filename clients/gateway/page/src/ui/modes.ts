// SPDX-License-Identifier: Apache-2.0
// The operating modes of a drive (6502h), and the objects of each.

import { HOMING, homingState, PROFILE_POSITION } from "../data/setpoints";
import { quantityOf, type Quantity } from "../data/signals";
import { formatNumber, retyped, toShown } from "../data/units";
import { modeName, signalName, t, type TextKey } from "../i18n";
import type { AxisDescription, Dictionary, Model, ObjectRow } from "../model";
import type { Trace } from "../trace";
import { attempt, button, h, put, select, type View } from "./dom";
import { methodText } from "./homing";
import { objectAddress } from "./objects";
import { PolledObjects } from "./polled";
import { valueTyped } from "./quantity";

const MODE_COMMAND = "op_mode_cmd";
/** Objects that CiA 402-2 defines for each mode, by their names in the dictionary. The cyclic modes have none: a
 *  program streams their set-points. */
const OBJECTS: ReadonlyMap<number, string[]> = new Map([
  [PROFILE_POSITION, ["profile_velocity", "profile_acc", "profile_dec", "motion_profile_type", "profile_jerk_use", "profile_jerk_1", "profile_jerk_2"]],
  [
    2,
    [
      "vl_target_velocity", "vl_velocity_demand", "vl_velocity_actual_value",
      "vl_acceleration_delta_speed", "vl_acceleration_delta_time", "vl_deceleration_delta_speed", "vl_deceleration_delta_time",
    ],
  ],
  [3, ["target_velocity", "velocity_demand_value", "profile_acc", "profile_dec", "motion_profile_type", "profile_jerk_use", "profile_jerk_1", "profile_jerk_2"]],
  [4, ["target_torque", "torque_demand", "torque_slope", "max_torque"]],
  [HOMING, ["homing_method", "homing_speed_search", "homing_speed_creep", "homing_acceleration", "home_offset"]],
]);
/** Values of 6086h that the drive supports. */
const PROFILE_TYPES: [number, TextKey][] = [[0, "trapezoidal"], [3, "limited_jerk"]];

/** @return the values of an object that has only a few, with their meanings; undefined for other objects */
function choicesOf(object: ObjectRow, dictionary: Dictionary | undefined): ReadonlyMap<number, string> | undefined {
  if (object.name === "motion_profile_type") return new Map(PROFILE_TYPES.map(([value, text]) => [value, `${value}: ${t(text)}`]));
  if (object.name === "homing_method") return new Map(dictionary?.homing_methods.map((row) => [row.method, methodText(row)]));
  return undefined;
}

export function hasMode({ supported_drive_modes }: AxisDescription, mode: number): boolean {
  return mode > 0 && ((supported_drive_modes >> (mode - 1)) & 1) === 1;
}

/** One object: the current value, and a field for a new one. */
class ModeRow {
  readonly root: HTMLElement;
  private readonly value = h("span", { class: "number" }, "–");
  private readonly choices: ReadonlyMap<number, string> | undefined;

  /** @param write sends a value in the unit of the drive */
  constructor(
    private readonly model: Model,
    private readonly trace: Trace,
    private readonly object: ObjectRow,
    private readonly write: (value: number, notes: string[]) => void,
  ) {
    const title = signalName(object.name, object);
    this.choices = choicesOf(object, model.dictionary);
    const isWritable = /w/i.test(object.access);
    const unit = h("span", { class: "unit" }, this.quantity().unit);
    const setter = !isWritable ? [] : this.choices === undefined ? [this.form(title)] : [this.choice(title, this.choices)];
    const label = h("span", { class: "label", title: objectAddress(object) }, title);
    this.root = h("div", { class: "mode-row", attributes: { "data-mode-object": object.name } }, label, this.value, unit, ...setter);
  }

  show(value: number | undefined): void {
    const { scale } = this.quantity();
    const text = value === undefined ? "–" : (this.choices?.get(value) ?? formatNumber(toShown(value, scale), scale.decimals));
    put(this.value, text);
  }

  private quantity(): Quantity {
    return quantityOf(this.object, this.model.scale(this.trace.axis));
  }

  private choice(title: string, choices: ReadonlyMap<number, string>): HTMLElement {
    const options = [...choices].map(([value, text]) => ({ value: String(value), text }));
    const made = select(title, [{ value: "", text: "" }, ...options], "", (value) => {
      if (value !== "") this.write(Number(value), []);
      made.value = ""; // the value in force is next to it
    });
    return made;
  }

  /** Typed text is kept when the panel is rebuilt, and is converted when the unit changes. */
  private form(title: string): HTMLElement {
    const key = `mode ${this.trace.axis.address} ${this.object.name}`;
    const quantity = this.quantity();
    const typed = this.model.typed.get(key);
    const input = h("input", { attributes: { type: "text", inputmode: "decimal", autocomplete: "off", "aria-label": title } });
    input.value = typed === undefined ? "" : retyped(typed.text, typed.scale, quantity.scale);
    input.addEventListener("input", () => {
      input.removeAttribute("aria-invalid");
      this.model.typed.set(key, { text: input.value, scale: quantity.scale });
    });
    const form = h("form", {}, input, h("button", { attributes: { "aria-label": `${t("set")} ${title}` } }, t("set")));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      attempt(this.model, () => {
        const notes: string[] = [];
        try {
          if (input.value.trim() === "") throw new Error(t("no_value"));
          this.write(valueTyped(input.value.trim(), quantity, this.trace.axis.unit, notes), notes);
        } catch (error) {
          input.setAttribute("aria-invalid", "true");
          throw error;
        }
      });
    });
    return form;
  }
}

export class Modes implements View {
  readonly root: HTMLElement;
  private readonly fieldset = h("fieldset");
  private readonly now = h("span", { attributes: { "data-test": "mode_now" } });
  private readonly homing = h("p", { class: "hint", attributes: { "data-test": "homing_state" } });
  private readonly choicePlace = h("span");
  private readonly rowPlace = h("div", { class: "mode-rows" });
  private rows = new Map<string, ModeRow>();
  private read?: PolledObjects;
  /** chosen by the user; undefined = show the mode in force */
  private chosen?: number;
  private shown = "";

  constructor(
    private readonly model: Model,
    private readonly trace: Trace,
  ) {
    const set = button(t("set_mode"), () => void this.write(MODE_COMMAND, this.mode(), []), { attributes: { "data-test": "set_mode" } });
    this.fieldset.append(h("div", { class: "line" }, this.choicePlace, set, this.now), this.homing, this.rowPlace);
    this.root = h("section", { class: "panel modes" }, h("h3", {}, t("modes")), this.fieldset);
  }

  update(now: number): void {
    const { trace, model } = this;
    const able = model.whyDisabled([trace.ref], now) === "";
    const scale = model.scale(trace.axis);
    const mode = this.mode();
    const wanted = `${mode} ${able} ${model.dictionary?.version} ${scale.name} ${trace.ref.axis.supported_drive_modes}`;
    if (wanted !== this.shown && model.dictionary !== undefined) {
      this.shown = wanted;
      this.build(mode, able);
    }
    const inForce = trace.last["op_mode_actual"];
    put(this.now, inForce === undefined ? "" : `${t("mode_now")}: ${inForce} ${modeName(inForce)}`);
    const status = trace.last["ds402_statusword"] ?? 0;
    put(this.homing, mode !== HOMING ? "" : `${t("homing_state")}: ${t(inForce === HOMING ? `homing_${homingState(status)}` : "homing_other_mode")}`);
    this.homing.hidden = mode !== HOMING;
    this.read?.update(now, this.root);
    for (const [object, row] of this.rows) row.show(this.read?.value(trace.axis.address, object));
  }

  private mode(): number {
    const inForce = this.trace.last["op_mode_actual"] ?? 0;
    return this.chosen ?? (inForce === 0 ? PROFILE_POSITION : inForce);
  }

  private build(mode: number, able: boolean): void {
    const { dictionary } = this.model;
    const modes = dictionary?.modes.filter((row) => hasMode(this.trace.ref.axis, row.mode)) ?? [];
    const options = modes.map((row) => ({ value: String(row.mode), text: `${row.mode} ${modeName(row.mode)}` }));
    const choice = select(t("modes"), options, String(mode), (value) => (this.chosen = Number(value)));
    choice.dataset["test"] = "mode";
    const hadFocus = this.choicePlace.contains(document.activeElement);
    this.choicePlace.replaceChildren(choice);
    if (hadFocus) choice.focus();
    const objects = (OBJECTS.get(mode) ?? []).flatMap((name) => dictionary?.objects.find((row) => row.name === name) ?? []);
    this.rows = new Map(
      objects.map((object) => [objectAddress(object), new ModeRow(this.model, this.trace, object, (value, notes) => void this.write(object.name, value, notes))]),
    );
    const note = h("p", { class: "hint" }, t("mode_streamed"));
    this.rowPlace.replaceChildren(...[...this.rows.values()].map(({ root }) => root), ...(objects.length === 0 ? [note] : []));
    for (const control of this.fieldset.querySelectorAll<HTMLButtonElement>("button, .mode-row input, .mode-row select")) control.disabled = !able;
    this.read = new PolledObjects(this.model, () => [this.trace.ref], [...this.rows.keys()]);
  }

  /** @param value in the unit of the drive */
  private async write(object: string, value: number, notes: string[]): Promise<void> {
    await this.model.command("/write", { axis: this.trace.axis.address, object, value }, notes);
    this.read?.readAgain();
  }
}
