// SPDX-License-Identifier: Apache-2.0
// How long a page that holds control may be silent, and what its axes do afterwards (6007h, abort connection option
// code).

import { isTextKey, t } from "../i18n";
import { addressOf, listed, SILENCES_S, type AxisRef, type Model } from "../model";
import { h, put, select } from "./dom";
import type { PolledObjects } from "./polled";

export const ABORT_OPTION_CODE = "0x6007";

export class Silence {
  readonly root: HTMLElement;
  private readonly choice: HTMLSelectElement;
  private readonly holder = h("span");
  private readonly reaction = h("span", { attributes: { "data-test": "on_loss" } });
  /** The gateway has not answered yet. */
  private isUnderWay = false;

  /** @param read polls ABORT_OPTION_CODE of the axes */
  constructor(
    private readonly model: Model,
    private readonly axes: () => AxisRef[],
    private readonly read: PolledObjects,
  ) {
    this.choice = select(
      t("silence"),
      SILENCES_S.map((seconds) => ({ value: String(seconds), text: `${seconds} s` })),
      String(model.settings.silence),
      (seconds) => void this.choose(Number(seconds)),
    );
    this.choice.dataset["test"] = "silence";
    this.choice.title = t("silence_hint");
    const label = h("label", { class: "choice", title: t("silence_hint") }, t("silence"), this.choice);
    this.root = h("p", { class: "silence" }, label, this.holder, this.reaction);
  }

  update(): void {
    const { control } = this.model;
    this.root.hidden = !control.enabled;
    // The value in force: the gateway may have refused a choice.
    const shown = String(control.you ? control.silence_ms / 1000 : this.model.settings.silence);
    if (!this.isUnderWay && this.choice.value !== shown) this.choice.value = shown;
    const isOthers = control.holder !== "" && !control.you;
    put(this.holder, isOthers ? `${control.holder}: ${t("silence_of_holder")} ${control.silence_ms / 1000} s` : "");
    this.showReaction();
  }

  private async choose(seconds: number): Promise<void> {
    this.isUnderWay = true;
    await this.model.chooseSilence(seconds);
    this.isUnderWay = false;
  }

  /** Axes with the same option are grouped; if all have the same, none are named. */
  private showReaction(): void {
    const groups = new Map<number, string[]>();
    for (const ref of this.axes()) {
      const address = addressOf(ref);
      const code = this.read.value(address, ABORT_OPTION_CODE);
      if (code !== undefined) groups.set(code, [...(groups.get(code) ?? []), address]);
    }
    const parts = [...groups].map(([code, addresses]) => {
      const key = `abort_${code}`;
      const text = `= ${code}: ${isTextKey(key) ? t(key) : "?"}`;
      return groups.size > 1 ? `${text} (${listed(addresses)})` : text;
    });
    const read = [...groups.values()].flat().length;
    const all = this.axes().length;
    if (read < all) parts.push(`${read} / ${all} ${t("axes_read")}`);
    put(this.reaction, groups.size === 0 ? "" : `${t("on_loss")} ${parts.join(", ")}`);
  }
}
