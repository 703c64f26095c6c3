// SPDX-License-Identifier: Apache-2.0
// Fields for numbers in the unit that the page shows. Typed text is kept when a view is rebuilt, and is converted when
// the unit changes: a target never changes its meaning.

import type { Quantity } from "../data/signals";
import { formatNumber, parseNumber, parseQuantity, retyped, USER_UNITS, wholeUserUnits, whyNoNumber, type AxisUnit, type Scale, type Suffix } from "../data/units";
import { t } from "../i18n";
import type { AxisRef, Model } from "../model";
import { field, h, put } from "./dom";

/** 12.3 % is 123 permille, except for rounding errors. */
const ROUNDING = 1e-9;

/** @param notes receives the result of converting a value with a unit
 *  @return integer user units
 *  @throws Error with the reason if the drive cannot take the value in the text */
export function userUnitsTyped(text: string, scale: Scale, unit: AxisUnit | undefined, suffix: Suffix, notes: string[]): number {
  const found = parseQuantity(text, scale, unit, suffix);
  if ("why" in found) throw new Error(`"${text}" ${t(found.why)}${found.units.length === 0 ? "" : `: ${found.units.join(", ")}`}`);
  const whole = wholeUserUnits(found);
  if (whole === undefined) throw new Error(`"${text}" ${t("fraction")}`);
  if (found.scale !== USER_UNITS) {
    const isBare = parseNumber(text) !== undefined;
    notes.push(`${text}${isBare ? ` ${scale.name}${suffix}` : ""} = ${formatNumber(whole, 0)} UU${suffix}`);
  }
  return whole;
}

/** @param notes receives the result of converting a value with a unit
 *  @return the value of an object, in the unit of the drive
 *  @throws Error with the reason if the drive cannot take the value in the text */
export function valueTyped(text: string, quantity: Quantity | undefined, unit: AxisUnit | undefined, notes: string[]): number {
  if (quantity?.suffix !== undefined) return userUnitsTyped(text, quantity.scale, unit, quantity.suffix, notes);
  const value = parseNumber(text);
  if (value === undefined) throw new Error(`"${text}" ${t(whyNoNumber(text))}`);
  const whole = value / (quantity?.scale.factor ?? 1);
  if (Math.abs(whole - Math.round(whole)) > ROUNDING) throw new Error(`"${text}" ${t("fraction")}`);
  return Math.round(whole);
}

export class QuantityField {
  readonly root: HTMLElement;
  readonly input: HTMLInputElement;
  private readonly unit: HTMLElement;
  private key = "";
  private ref?: AxisRef;
  private scale?: Scale;

  constructor(
    private readonly model: Model,
    label: string,
    private readonly suffix: Suffix = "",
    properties: { placeholder?: string; id?: string } = {},
  ) {
    const made = field(label, properties);
    this.root = made.root;
    this.input = made.input;
    this.unit = made.unit;
    this.input.addEventListener("input", () => this.keep());
    this.input.readOnly = true; // until bind(), which would replace text typed before it
  }

  /** Shows the text last typed under this key, in the present unit.
   *  @param initial content of the field before anything was typed */
  bind(key: string, ref: AxisRef, initial: (scale: Scale) => string = () => ""): void {
    const scale = this.model.scale(ref.axis);
    const same = key === this.key && scale.name === this.scale?.name && scale.factor === this.scale.factor;
    this.ref = ref;
    if (same) return;
    this.input.readOnly = false;
    this.key = key;
    this.scale = scale;
    const typed = this.model.typed.get(key);
    this.input.value = typed === undefined ? initial(scale) : retyped(typed.text, typed.scale, scale);
    this.accept();
    put(this.unit, scale.name + this.suffix);
  }

  isEmpty(): boolean {
    return this.input.value.trim() === "";
  }

  /** The typed text has become a value of the drive. */
  clear(): void {
    this.input.value = "";
    this.model.typed.delete(this.key);
    this.accept();
  }

  /** @param notes receives the result of converting a value with a unit
   *  @return integer user units; undefined for an empty field
   *  @throws Error with the reason if the drive cannot take the value in the text */
  read(notes: string[]): number | undefined {
    const text = this.input.value.trim();
    if (text === "" || this.scale === undefined) return undefined;
    try {
      const whole = userUnitsTyped(text, this.scale, this.ref?.axis.unit, this.suffix, notes);
      this.accept();
      return whole;
    } catch (error) {
      return this.refuse(error instanceof Error ? error.message : String(error));
    }
  }

  private keep(): void {
    if (this.scale !== undefined) this.model.typed.set(this.key, { text: this.input.value, scale: this.scale });
    this.accept();
  }

  private accept(): void {
    this.input.removeAttribute("aria-invalid");
    this.input.title = "";
  }

  private refuse(reason: string): never {
    this.input.setAttribute("aria-invalid", "true");
    this.input.title = reason;
    throw new Error(reason);
  }
}

/** A checkbox that keeps its state when its view is rebuilt. */
export class KeptCheckbox {
  readonly input = h("input", { attributes: { type: "checkbox" } });
  readonly root: HTMLElement;
  private key = "";

  constructor(
    private readonly model: Model,
    text: string,
  ) {
    this.root = h("label", { class: "check" }, this.input, text);
    this.input.disabled = true; // until bind()
    this.input.addEventListener("change", () => this.model.ticked.set(this.key, this.input.checked));
  }

  bind(key: string): void {
    if (key === this.key) return;
    this.key = key;
    this.input.disabled = false;
    this.input.checked = this.model.ticked.get(key) ?? false;
  }
}
