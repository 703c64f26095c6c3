// SPDX-License-Identifier: Apache-2.0
// Homing, and its method (6098h).

import { t } from "../i18n";
import { addressOf, type AxisRef, type Dictionary, type Model } from "../model";
import { button, h, put, select } from "./dom";
import type { PolledObjects } from "./polled";

export const HOMING_METHOD = "0x6098";
type Method = Dictionary["homing_methods"][number];

export function methodText({ method, direction, limit_switch, home_switch, hard_stop, index_pulse }: Method): string {
  const ways = [
    limit_switch && t("to_limit_switch"),
    home_switch && t("to_home_switch"),
    hard_stop && t("to_hard_stop"),
    index_pulse && t("to_index_pulse"),
  ].filter((way) => way !== false);
  if (ways.length === 0) return `${method}: ${t("home_here")}`;
  return `${method}: ${direction < 0 ? "−" : "+"} ${ways.join(" → ")}`;
}

export class Homing {
  readonly root: HTMLElement;
  private readonly place = h("span");
  private choice?: HTMLSelectElement;
  private built?: Dictionary;

  /** @param read polls HOMING_METHOD of the axes */
  constructor(
    private readonly model: Model,
    private readonly axes: () => AxisRef[],
    private readonly read: PolledObjects,
  ) {
    const home = button(t("home"), () => void this.home(), { attributes: { "data-test": "home" } });
    this.root = h("div", { class: "line" }, home, this.place);
  }

  update(): void {
    const { dictionary } = this.model;
    if (dictionary !== undefined && dictionary !== this.built) this.build(dictionary);
    const [asSet] = this.choice?.options ?? [];
    if (asSet !== undefined) put(asSet, this.asSet());
    const chosen = this.model.homing.get(this.key()) ?? "";
    if (this.choice !== undefined && this.choice.value !== chosen) this.choice.value = chosen;
  }

  private key(): string {
    return this.axes().map(addressOf).join(" ");
  }

  /** The method set in the drives, if it is the same in all of them. */
  private asSet(): string {
    const methods = new Set(this.axes().map((ref) => this.read.value(addressOf(ref), HOMING_METHOD)));
    const [method] = methods;
    return methods.size === 1 && method !== undefined ? `${t("as_set")}: ${method}` : t("as_set");
  }

  private build(dictionary: Dictionary): void {
    this.built = dictionary;
    const methods = dictionary.homing_methods.map((row) => ({ value: String(row.method), text: methodText(row) }));
    this.choice = select(t("homing_method"), [{ value: "", text: t("as_set") }, ...methods], "", (value) => {
      this.model.homing.set(this.key(), value);
    });
    this.choice.dataset["test"] = "homing_method";
    this.place.replaceChildren(this.choice);
  }

  private async home(): Promise<void> {
    const chosen = this.choice?.value ?? "";
    const method = chosen === "" ? {} : { method: Number(chosen) };
    for (const ref of this.axes()) await this.model.command("/home", { axis: addressOf(ref), ...method });
    this.read.readAgain();
  }
}
