// SPDX-License-Identifier: Apache-2.0
// How long a page that holds control may be silent, and what its axes do then (6007h, abort
// connection option code).

import { isTextKey, t } from "../i18n";
import { addressOf, listed, SILENCES_S, type AxisRef, type Model } from "../model";
import { h, put, select, type View } from "./dom";

const OPTION_CODE = "0x6007";
const READ_EVERY_MS = 1_000;

export class Silence implements View {
  readonly root: HTMLElement;
  private readonly choice: HTMLSelectElement;
  private readonly holders = h("span");
  private readonly reaction = h("span", { attributes: { "data-test": "on_loss" } });
  /** 6007h by the address of the axis, as it was read last */
  private readonly codes = new Map<string, number>();
  private next = 0;
  private readAt = -Infinity;
  private reading = false;
  private isChosen = false;

  constructor(
    private readonly model: Model,
    private readonly axes: () => AxisRef[],
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
    this.root = h("p", { class: "silence" }, label, this.holders, this.reaction);
  }

  update(now: number): void {
    const { control } = this.model;
    this.root.hidden = !control.enabled;
    // What is in force: the gateway may have refused a choice.
    const shown = String(control.you ? control.silence_ms / 1000 : this.model.settings.silence);
    if (!this.isChosen && this.choice.value !== shown) this.choice.value = shown;
    const isOthers = control.holder !== "" && !control.you;
    put(this.holders, isOthers ? `${control.holder}: ${t("silence_of_holder")} ${control.silence_ms / 1000} s` : "");
    this.showReaction();
    const visible = this.root.getClientRects().length > 0;
    if (visible && !this.reading && this.model.connected && now - this.readAt >= READ_EVERY_MS) {
      this.readAt = now;
      void this.read();
    }
  }

  private async choose(seconds: number): Promise<void> {
    this.isChosen = true;
    await this.model.chooseSilence(seconds);
    this.isChosen = false;
  }

  /** One axis at a time: each read is a request to its bench. */
  private async read(): Promise<void> {
    const axes = this.axes();
    if (axes.length === 0) return;
    // First what is not known yet.
    const unknown = axes.find((ref) => !this.codes.has(addressOf(ref)));
    const address = addressOf(unknown ?? axes[this.next++ % axes.length]);
    this.reading = true;
    const answer = await this.model.connection.call("/read", { axis: address, objects: [OPTION_CODE] });
    this.reading = false;
    const [value] = (answer["values"] ?? []) as { value?: number }[];
    if (value?.value !== undefined) this.codes.set(address, value.value);
  }

  /** Axes with the same option stand together; with one option there is nothing to tell apart. */
  private showReaction(): void {
    const groups = new Map<number, string[]>();
    for (const ref of this.axes()) {
      const address = addressOf(ref);
      const code = this.codes.get(address);
      if (code !== undefined) groups.set(code, [...(groups.get(code) ?? []), address]);
    }
    const parts = [...groups].map(([code, addresses]) => {
      const key = `abort_${code}`;
      const text = `= ${code}: ${isTextKey(key) ? t(key) : "?"}`;
      return groups.size > 1 ? `${text} (${listed(addresses)})` : text;
    });
    put(this.reaction, parts.length === 0 ? "" : `${t("on_loss")} ${parts.join(", ")}`);
  }
}
