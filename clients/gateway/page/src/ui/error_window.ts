// SPDX-License-Identifier: Apache-2.0
// The following error window (6065h) next to the plot of the error: the value in force, and a field for a new one.

import { formatUnits } from "../data/units";
import { t } from "../i18n";
import { addressOf, type AxisRef, type Model } from "../model";
import { attempt, h, put } from "./dom";
import { PolledObjects } from "./polled";
import { QuantityField } from "./quantity";

const WINDOW = "0x6065";

export class ErrorWindow {
  readonly root: HTMLElement;
  private readonly value = h("span", { class: "number", attributes: { "data-test": "error_window" } }, "–");
  private readonly field: QuantityField;
  private readonly form: HTMLFormElement;
  private readonly read: PolledObjects;

  constructor(
    private readonly model: Model,
    private readonly ref: AxisRef,
  ) {
    this.read = new PolledObjects(model, () => [ref], [WINDOW]);
    this.field = new QuantityField(model, t("new_window"));
    this.field.input.dataset["test"] = "new_window";
    this.form = h("form", { class: "line" }, this.field.root, h("button", {}, t("set")));
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      attempt(model, () => this.write());
    });
    this.root = h("span", { class: "reading window-6065" }, t("error_window"), this.value, this.form);
  }

  update(now: number): void {
    this.read.update(now, this.root);
    const scale = this.model.scale(this.ref.axis);
    const value = this.read.value(addressOf(this.ref), WINDOW);
    put(this.value, value === undefined ? "–" : `${formatUnits(value, scale)} ${scale.name}`);
    this.form.hidden = this.model.whyDisabled([this.ref], now) !== "";
    this.field.bind(`window ${addressOf(this.ref)}`, this.ref);
  }

  private write(): void {
    const notes: string[] = [];
    const value = this.field.read(notes);
    if (value === undefined) throw new Error(t("no_value"));
    const axis = addressOf(this.ref);
    void this.model.command("/write", { axis, object: WINDOW, value }, notes).then(({ ok }) => {
      if (ok) this.field.clear();
      this.read.readAgain();
    });
  }
}
