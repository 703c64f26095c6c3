// SPDX-License-Identifier: Apache-2.0
// What the benches report, newest first.

import type { LogEvent } from "../data/events";
import { timeText } from "../data/times";
import { isTextKey, t } from "../i18n";
import type { Model } from "../model";
import { button, h, type View } from "./dom";

const MOST_SHOWN = 200;

export class Events implements View {
  readonly root: HTMLElement;
  private readonly list = h("ol", { class: "events", attributes: { "aria-label": t("events") } });
  private buttons: HTMLButtonElement[] = [];
  /** the one that Tab reaches; from there the arrow keys go on */
  private current = 0;
  private shownVersion = -1;

  /** @param wanted whether an event is shown here
   *  @param go shows what was then; an event of no axis has nothing to show */
  constructor(
    private readonly model: Model,
    private readonly wanted: (event: LogEvent) => boolean,
    private readonly go: (event: LogEvent) => void,
  ) {
    this.list.addEventListener("keydown", (event) => this.key(event));
    this.root = h("section", { class: "panel events-panel" }, h("h3", {}, t("events")), this.list);
  }

  update(): void {
    const { version } = this.model.events;
    if (version === this.shownVersion) return;
    this.shownVersion = version;
    const before = this.buttons[this.current];
    const hadFocus = before !== undefined && document.activeElement === before;
    this.buttons = [];
    const rows = this.groups().map(({ event, times }) => {
      const key = `level_${event.level}`;
      return h(
        "li",
        { class: `level-${event.level}` },
        this.time(event),
        h("span", { class: "level" }, isTextKey(key) ? t(key) : String(event.level)),
        h("span", { class: "source" }, this.source(event)),
        h("span", { class: "message" }, event.message, times > 1 && h("span", { class: "times" }, ` × ${times}`)),
      );
    });
    if (rows.length === 0) rows.push(h("li", { class: "empty" }, t("no_events")));
    this.list.replaceChildren(...rows);
    const same = this.buttons.findIndex(({ dataset }) => dataset["event"] === before?.dataset["event"]);
    // Else nobody has come here: Tab reaches the newest one.
    this.choose(hadFocus ? (same >= 0 ? same : this.current) : 0, hadFocus);
  }

  private choose(place: number, isFocused: boolean): void {
    this.current = Math.max(0, Math.min(place, this.buttons.length - 1));
    this.buttons.forEach((button, i) => (button.tabIndex = i === this.current ? 0 : -1));
    if (isFocused) this.buttons[this.current]?.focus();
  }

  private key(event: KeyboardEvent): void {
    const last = this.buttons.length - 1;
    const places: Record<string, number> = { ArrowDown: this.current + 1, ArrowUp: this.current - 1, Home: 0, End: last };
    const place = places[event.key];
    if (place === undefined) return;
    event.preventDefault();
    this.choose(place, true);
  }

  private time(event: LogEvent): HTMLElement {
    const text = timeText(event.time);
    const made = button(text, () => this.go(event), {
      class: "quiet number time",
      title: t("go_to_event"),
      attributes: { "data-event": `${event.bench} ${event.axis} ${event.tick} ${event.message}` },
    });
    const place = this.buttons.push(made) - 1;
    made.addEventListener("focus", () => place !== this.current && this.choose(place, false));
    return made;
  }

  private source({ bench, axis }: LogEvent): string {
    const topic = this.model.benches.get(bench)?.axis(axis)?.topic;
    return `bench${bench}` + (topic === undefined ? "" : `/${topic}`);
  }

  /** Newest first; what repeats but for its figures stands once. */
  private groups(): { event: LogEvent; times: number }[] {
    const groups: { event: LogEvent; kind: string; times: number }[] = [];
    const { events } = this.model.events;
    for (let i = events.length - 1; i >= 0 && groups.length < MOST_SHOWN; --i) {
      const event = events[i];
      if (!this.wanted(event)) continue;
      const kind = `${event.level} ${event.bench} ${event.axis} ${event.message.replace(/ \(.*\)$/, "").replace(/\d+/g, "#")}`;
      const last = groups[groups.length - 1];
      if (last?.kind === kind) ++last.times;
      else groups.push({ event, kind, times: 1 });
    }
    return groups;
  }
}
