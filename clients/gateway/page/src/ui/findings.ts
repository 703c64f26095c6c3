// SPDX-License-Identifier: Apache-2.0
// The mistakes of the masters of an axis, found by the judge of the gateway while this is open.

import { FINDINGS, type FoundMistake } from "../data/findings";
import { timeText } from "../data/times";
import { isTextKey, t } from "../i18n";
import type { AxisRef, Model } from "../model";
import { checked } from "../protocol/checked";
import { button, h, put, type View } from "./dom";

const ASK_EVERY_MS = 1_000;

export class Findings implements View {
  readonly root: HTMLDetailsElement;
  private readonly list = h("ol", { class: "findings", attributes: { "aria-label": t("judge") } });
  private readonly state = h("p", { class: "hint" });
  private asking = false;
  private askedAt = -Infinity;
  private shown = "";

  /** @param go shows the state at a tick */
  constructor(
    private readonly model: Model,
    private readonly ref: AxisRef,
    private readonly go: (tick: number) => void,
  ) {
    this.root = h("details", { class: "panel findings-panel" }, h("summary", { title: t("judge_hint") }, t("judge")), this.state, this.list);
  }

  /** Nothing is judged unless somebody looks. */
  update(now: number): void {
    if (!this.root.open || this.asking || !this.model.connected || now - this.askedAt < ASK_EVERY_MS) return;
    this.askedAt = now;
    void this.ask();
  }

  private async ask(): Promise<void> {
    if (!this.model.connection.hasService("/judge")) {
      put(this.state, t("judge_absent"));
      return;
    }
    this.asking = true;
    const answer = await this.model.connection.call("/judge", { bench: this.ref.bench.number });
    this.asking = false;
    if (!answer.ok) {
      put(this.state, String(answer["message"] ?? ""));
      return;
    }
    const { judged, findings } = checked(FINDINGS, answer, "/judge");
    if (!judged) {
      put(this.state, t("judge_waits"));
      return;
    }
    this.show(findings.filter(({ axis }) => axis === this.ref.axis.axis));
  }

  private show(findings: FoundMistake[]): void {
    put(this.state, t(findings.length === 0 ? "judge_none" : "judge_found"));
    const text = JSON.stringify(findings);
    if (text === this.shown) return;
    this.shown = text;
    this.list.replaceChildren(...findings.map((finding) => this.row(finding)));
  }

  private row({ rule, severity, title, count, tick, happened, remedy }: FoundMistake): HTMLElement {
    const key = `severity_${severity}`;
    const period = this.ref.bench.description?.period_us ?? 1000;
    return h(
      "li",
      { class: `severity-${severity}` },
      button(timeText(tick * period * 1e-6), () => this.go(tick), { class: "quiet number time", title: t("go_to_event") }),
      h("span", { class: "level" }, isTextKey(key) ? t(key) : severity),
      h("span", { class: "source" }, rule),
      h(
        "div",
        { class: "message" },
        title,
        count > 1 && h("span", { class: "times" }, ` × ${count}`),
        h("div", {}, happened),
        h("div", { class: "remedy" }, remedy),
      ),
    );
  }
}
