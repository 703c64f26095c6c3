// SPDX-License-Identifier: Apache-2.0
// The trigger of a scope: its condition.

import { CONTROLWORD, type Samples } from "../data/samples";
import { quantityOf, type Quantity } from "../data/signals";
import { CONDITIONS, MODES, type Condition, type Trigger, type TriggerMode } from "../data/trigger";
import { bitName, signalName, t } from "../i18n";
import type { Model } from "../model";
import { attempt, button, field, h, put, select } from "./dom";
import { valueTyped } from "./quantity";

const BITS = 16;
const BEFORE = [0.1, 0.25, 0.5, 0.75, 0.9];

export class TriggerPanel {
  readonly root: HTMLElement;
  /** shows and hides the panel */
  readonly toggle = button(t("trigger"), () => this.open(this.root.hidden), {
    class: "toggle",
    attributes: { "aria-pressed": "false", "data-test": "trigger" },
  });
  private readonly form = h("form", { class: "line trigger" });
  private readonly state = h("span", { class: "trigger-state", attributes: { role: "status", "data-test": "trigger_state" } });
  private chosen: Trigger = { mode: "single", axis: "", member: "", condition: "rising", value: 0, text: "", before: 0.25 };
  private typed = "0";
  private armed = false;

  /** @param axes shown in the scope
   *  @param arm called with the chosen trigger, or undefined to end it */
  constructor(
    private readonly model: Model,
    private readonly axes: () => Samples[],
    private readonly arm: (trigger: Trigger | undefined) => void,
    private readonly tools: Node[],
  ) {
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      if (this.armed) this.arm(undefined);
      else attempt(model, () => this.arm(this.read()));
    });
    this.root = h("div", { class: "trigger-panel", attributes: { "data-test": "trigger-panel" } }, this.form);
    this.root.hidden = true;
  }

  /** @param trigger of a link */
  set(trigger: Trigger): void {
    this.chosen = { ...trigger };
    const quantity = this.quantity();
    this.typed = String(trigger.value * (quantity?.scale.factor ?? 1));
    this.open(true);
  }

  private open(isOpen: boolean): void {
    this.root.hidden = !isOpen;
    this.toggle.setAttribute("aria-pressed", String(isOpen));
    if (isOpen) this.build();
  }

  show(text: string, isArmed: boolean): void {
    put(this.state, text);
    if (isArmed === this.armed) return;
    this.armed = isArmed;
    this.build();
  }

  /** The axes, their signals or the unit have changed. */
  build(): void {
    const samples = this.samples();
    if (samples === undefined) return;
    const { chosen } = this;
    chosen.axis = samples.axis.address;
    const members = [...samples.members, ...(samples.series(CONTROLWORD) === undefined ? [] : [CONTROLWORD])];
    if (chosen.member === "" && members.length > 0) chosen.member = members[0];
    const named = [...new Set([...members, chosen.member])].filter((member) => member !== "");
    const options = <Value extends string>(values: readonly Value[], text: (value: Value) => string) => values.map((value) => ({ value, text: text(value) }));
    const change = <Value>(apply: (value: Value) => void) => (value: string) => {
      apply(value as Value);
      this.build();
    };
    const mode = select(t("trigger"), options(MODES, (name) => t(`trigger_${name}`)), chosen.mode, change<TriggerMode>((value) => (chosen.mode = value)));
    const axis = select(t("axis"), options(this.axes().map((each) => each.axis.address), (address) => address), chosen.axis, change<string>((value) => (chosen.axis = value)));
    const condition = select(t("condition"), options(CONDITIONS, (name) => t(`when_${name}`)), chosen.condition, change<Condition>((value) => (chosen.condition = value)));
    const member = select(t("signal"), options(named, (name) => this.name(name)), chosen.member, change<string>((value) => (chosen.member = value)));
    const before = select(
      t("before_trigger"),
      options(BEFORE.map(String), (share) => `${Number(share) * 100} %`),
      String(chosen.before),
      (value) => (chosen.before = Number(value)),
    );
    for (const [made, name] of [[mode, "mode"], [axis, "axis"], [condition, "condition"], [member, "signal"]] as const) made.dataset["test"] = `trigger_${name}`;
    const isEvent = chosen.condition === "event";
    const arm = h("button", { class: this.armed ? "" : "primary", attributes: { "data-test": "arm" } }, t(this.armed ? "disarm" : "arm"));
    const share = h("label", { class: "choice" }, before, t("before_trigger"));
    const focused = this.form.contains(document.activeElement) ? (document.activeElement as HTMLElement).dataset["test"] : undefined;
    this.form.replaceChildren(mode, axis, ...(isEvent ? [] : [member]), condition, this.value(), share, arm, ...this.tools, this.state);
    if (focused !== undefined) this.form.querySelector<HTMLElement>(`[data-test="${focused}"]`)?.focus();
  }

  private samples(): Samples | undefined {
    const axes = this.axes();
    return axes.find(({ axis }) => axis.address === this.chosen.axis) ?? axes[0];
  }

  private name(member: string): string {
    return signalName(member, this.model.dictionary?.objects.find(({ name }) => name === member));
  }

  private quantity(): Quantity | undefined {
    const samples = this.samples();
    const object = this.model.dictionary?.objects.find(({ name }) => name === this.chosen.member);
    return samples === undefined ? undefined : quantityOf(object, this.model.scale(samples.axis));
  }

  /** The field for the level, the bit or the text. */
  private value(): HTMLElement {
    const { chosen } = this;
    if (chosen.condition === "bit_set" || chosen.condition === "bit_cleared") {
      const bits = Array.from({ length: BITS }, (_, bit) => ({ value: String(bit), text: this.bit(bit) }));
      const made = select(t("bit"), bits, this.typed, (value) => (this.typed = value));
      this.typed = made.value;
      made.dataset["test"] = "trigger_value";
      return made;
    }
    const isEvent = chosen.condition === "event";
    const made = field(t(isEvent ? "event_text" : "level"), { value: isEvent ? chosen.text : this.typed, unit: () => (isEvent ? "" : (this.quantity()?.unit ?? "")) });
    made.input.dataset["test"] = "trigger_value";
    if (isEvent) made.input.inputMode = "text";
    made.input.addEventListener("input", () => {
      if (isEvent) chosen.text = made.input.value;
      else this.typed = made.input.value;
    });
    return made.root;
  }

  private bit(bit: number): string {
    const { dictionary } = this.model;
    const mode = this.samples()?.last["op_mode_actual"] ?? 0;
    const tables: Record<string, { mode: number; bits: string[] }[] | undefined> = {
      ds402_statusword: dictionary?.statusword_bits,
      [CONTROLWORD]: dictionary?.controlword_bits,
    };
    const table = tables[this.chosen.member];
    const name = (table?.find((row) => row.mode === mode) ?? table?.[0])?.bits[bit] ?? "";
    return `${bit} ${bitName(name)}`.trim();
  }

  /** @throws Error with the reason if the level is invalid */
  private read(): Trigger {
    const { chosen, typed } = this;
    if (chosen.condition === "event") return { ...chosen, member: "", value: 0 };
    const isBit = chosen.condition === "bit_set" || chosen.condition === "bit_cleared";
    return { ...chosen, text: "", value: isBit ? Number(typed) : valueTyped(typed, this.quantity(), this.samples()?.axis.unit, []) };
  }
}
