// SPDX-License-Identifier: Apache-2.0
// The events of the benches, newest first.

import { eventsCsv, eventText, matchesEvent, sessionsIn, type EventFeed, type EventFilter, type LogEvent } from "../data/events";
import { timeText } from "../data/times";
import { isTextKey, t } from "../i18n";
import type { Model } from "../model";
import { button, download, h, select, type View } from "./dom";

const MOST_SHOWN = 200;
/** of foxglove.Log: everything, warnings and above, errors */
const LEVELS = [0, 3, 4];

export class Events implements View {
  readonly root: HTMLElement;
  private readonly list = h("ol", { class: "events", attributes: { "aria-label": t("events") } });
  private buttons: HTMLButtonElement[] = [];
  /** the one that Tab reaches; the arrow keys move on from there */
  private current = 0;
  private readonly sessions = h("span");
  private readonly filter: EventFilter = { level: 0, text: "", session: "" };
  private shown = "";
  private shownSessions = "?";

  /** @param wanted whether an event is shown here
   *  @param go shows the moment of an event */
  constructor(
    private readonly model: Model,
    private readonly feed: EventFeed,
    private readonly wanted: (event: LogEvent) => boolean,
    private readonly go: (event: LogEvent) => void,
  ) {
    this.list.addEventListener("keydown", (event) => this.key(event));
    this.root = h("section", { class: "panel events-panel" }, h("div", { class: "tools" }, h("h3", {}, t("events")), ...this.tools()), this.list);
  }

  update(): void {
    // A name may arrive after the event of its session.
    const wanted = `${this.feed.version} ${this.model.version} ${Object.values(this.filter).join(" ")}`;
    if (wanted === this.shown) return;
    this.shown = wanted;
    this.showSessions();
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
        h("span", { class: "message" }, this.text(event), times > 1 && h("span", { class: "times" }, ` × ${times}`)),
      );
    });
    if (rows.length === 0) rows.push(h("li", { class: "empty" }, t(this.feed.events.some(this.wanted) ? "no_such_events" : "no_events")));
    this.list.replaceChildren(...rows);
    const same = this.buttons.findIndex(({ dataset }) => dataset["event"] === before?.dataset["event"]);
    // Without the focus, Tab reaches the newest one.
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

  private tools(): Node[] {
    const levels = LEVELS.map((level) => ({ value: String(level), text: level === 0 ? t("all_levels") : t(`from_level_${level as 3 | 4}`) }));
    const level = select(t("level_of_event"), levels, "0", (value) => (this.filter.level = Number(value)));
    const search = h("input", { class: "search", attributes: { type: "search", placeholder: t("search_events"), "aria-label": t("search_events") } });
    search.addEventListener("input", () => (this.filter.text = search.value));
    level.dataset["test"] = "event_level";
    search.dataset["test"] = "event_text";
    return [level, search, this.sessions, button(t("csv"), () => this.save(), { title: t("save_events"), attributes: { "aria-label": t("save_events"), "data-test": "save_events" } })];
  }

  /** Lists the sessions that events name. */
  private showSessions(): void {
    const sessions = [...new Set(this.feed.events.filter(this.wanted).flatMap(({ message }) => sessionsIn(message)))];
    const options = sessions.map((session) => ({ value: session, text: this.model.programOf(session) ?? `${t("session")} ${session.slice(0, 8)}` }));
    const wanted = JSON.stringify(options);
    if (wanted === this.shownSessions) return;
    this.shownSessions = wanted;
    const made = select(t("session"), [{ value: "", text: t("all_sessions") }, ...options], this.filter.session, (value) => (this.filter.session = value));
    made.dataset["test"] = "event_session";
    made.hidden = options.length === 0;
    this.sessions.replaceChildren(made);
  }

  private save(): void {
    const rows = this.feed.events
      .filter((event) => this.isShown(event))
      .map((event) => ({ event, source: this.source(event), text: this.text(event) }));
    download("events.csv", new Blob([eventsCsv(rows)], { type: "text/csv" }));
  }

  private isShown(event: LogEvent): boolean {
    return this.wanted(event) && matchesEvent(event, `${this.source(event)} ${event.kind} ${this.text(event)}`, this.filter);
  }

  private text(event: LogEvent): string {
    return eventText(event, (session) => this.model.programOf(session), (code) => this.model.errorName(code));
  }

  private source({ bench, axis }: LogEvent): string {
    const found = this.model.benches.get(bench);
    if (axis !== 0) return `${bench}.${axis} ${found?.axis(axis)?.name ?? ""}`.trim();
    return `${found?.description?.name ?? "bench"} (${bench})`;
  }

  /** Newest first; successive events that differ only in numbers are grouped. */
  private groups(): { event: LogEvent; times: number }[] {
    const groups: { event: LogEvent; kind: string; times: number }[] = [];
    const { events } = this.feed;
    for (let i = events.length - 1; i >= 0 && groups.length < MOST_SHOWN; --i) {
      const event = events[i];
      if (!this.isShown(event)) continue;
      const kind = `${event.level} ${event.bench} ${event.axis} ${event.message.replace(/ \(.*\)$/, "").replace(/\d+/g, "#")}`;
      const last = groups[groups.length - 1];
      if (last?.kind === kind) ++last.times;
      else groups.push({ event, kind, times: 1 });
    }
    return groups;
  }
}
