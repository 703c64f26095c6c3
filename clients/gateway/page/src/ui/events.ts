// SPDX-License-Identifier: Apache-2.0
// What the benches report, newest first.

import { formatNumber } from "../data/units";
import { isTextKey, t } from "../i18n";
import type { LogEvent, Model } from "../model";
import { h, type View } from "./dom";

const MOST_SHOWN = 200;

export class Events implements View {
  readonly root: HTMLElement;
  private readonly list = h("ol", { class: "events", attributes: { "aria-label": t("events") } });
  private shownCount = -1;

  /** @param wanted whether an event is shown here */
  constructor(
    private readonly model: Model,
    private readonly wanted: (event: LogEvent) => boolean,
  ) {
    this.root = h("section", { class: "panel events-panel" }, h("h3", {}, t("events")), this.list);
  }

  update(): void {
    if (this.model.eventCount === this.shownCount) return;
    this.shownCount = this.model.eventCount;
    const rows = this.groups().map(({ event, times }) => {
      const key = `level_${event.level}`;
      return h(
        "li",
        { class: `level-${event.level}` },
        h("span", { class: "number time" }, driveTime(event.time)),
        h("span", { class: "level" }, isTextKey(key) ? t(key) : String(event.level)),
        h("span", { class: "source" }, event.name),
        h("span", { class: "message" }, event.message, times > 1 && h("span", { class: "times" }, ` × ${times}`)),
      );
    });
    if (rows.length === 0) rows.push(h("li", { class: "empty" }, t("no_events")));
    this.list.replaceChildren(...rows);
  }

  /** Newest first; what repeats but for its figures stands once. */
  private groups(): { event: LogEvent; times: number }[] {
    const groups: { event: LogEvent; kind: string; times: number }[] = [];
    for (let i = this.model.events.length - 1; i >= 0 && groups.length < MOST_SHOWN; --i) {
      const event = this.model.events[i];
      if (!this.wanted(event)) continue;
      const kind = `${event.level} ${event.name} ${event.message.replace(/ \(.*\)$/, "").replace(/\d+/g, "#")}`;
      const last = groups[groups.length - 1];
      if (last?.kind === kind) ++last.times;
      else groups.push({ event, kind, times: 1 });
    }
    return groups;
  }
}

const FIRST_WALL_TIME_S = 1e9;

/** Benches in real time count from the epoch: their times are times of the day. */
function driveTime(seconds: number): string {
  if (seconds < FIRST_WALL_TIME_S) return `${formatNumber(seconds, 3)} s`;
  const date = new Date(seconds * 1000);
  const two = (value: number) => String(value).padStart(2, "0");
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}.${String(date.getMilliseconds()).padStart(3, "0")}`;
}
