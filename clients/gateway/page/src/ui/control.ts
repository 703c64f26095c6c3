// SPDX-License-Identifier: Apache-2.0
// Commands for the axes chosen in the overview, and the clocks of the benches.

import type { LogEvent } from "../data/events";
import { decodePowerState } from "../data/power";
import { nameMatches, wordsOf } from "../data/rows";
import { formatUnits } from "../data/units";
import { stateName, t } from "../i18n";
import { addressOf, type AxisRef, type Model } from "../model";
import { BenchClock, Commands, GroupMove } from "./commands";
import { button, FOCUS, h, put, type View } from "./dom";
import { Events } from "./events";

const FIGURES_EVERY_MS = 100;

interface Line {
  root: HTMLElement;
  lamp: HTMLElement;
  state: HTMLElement;
  position: HTMLElement;
}

export class ControlView implements View {
  readonly root: HTMLElement;
  private readonly parts: View[];
  private readonly list = h("ul", { class: "chosen" });
  private readonly lines = new Map<string, Line>();
  private readonly title = h("h3", {}, t("chosen_axes"));
  private readonly tools: HTMLElement;
  private readonly groupMove: GroupMove;
  private words: string[] = [];
  /** the chosen axes, looked up again every FIGURES_EVERY_MS */
  private found?: AxisRef[];
  private readonly clockPlace = h("div", { class: "clocks" });
  private readonly clocks: BenchClock[] = [];
  private shown = "?";
  private shownAt = 0;
  private benches = "";

  constructor(private readonly model: Model) {
    const axes = () => this.axes();
    const commands = new Commands(model, axes);
    const groupMove = new GroupMove(model, axes);
    this.groupMove = groupMove;
    const events = new Events(
      model,
      model.events,
      () => true,
      (event) => this.goTo(event),
    );
    this.parts = [commands, groupMove, events];
    this.tools = this.makeTools();
    const chosen = h("section", { class: "panel" }, h("div", { class: "tools" }, this.title, this.tools), this.list);
    this.root = h(
      "div",
      { class: "control-view" },
      h("h2", { class: "only-heard", attributes: FOCUS }, t("control")),
      h("div", { class: "main-column" }, chosen, groupMove.root, this.clockPlace, events.root),
      h("div", { class: "side-column" }, commands.root),
    );
    model.wantStatus(true);
  }

  update(now: number): void {
    if (now - this.shownAt < FIGURES_EVERY_MS) return;
    this.shownAt = now;
    this.found = undefined;
    this.showClocks();
    for (const part of [...this.parts, ...this.clocks]) part.update(now);
    this.showChosen();
  }

  close(): void {
    for (const part of this.parts) part.close?.();
    this.model.wantStatus(false);
  }

  private axes(): AxisRef[] {
    return (this.found ??= [...this.model.chosen].flatMap((address) => this.model.find(address) ?? []));
  }

  /** Shows what an axis did at the time of an event; for an event of the bench, one of its axes. */
  private goTo(event: LogEvent): void {
    const { bench, axis } = event;
    const isOfBench = (ref: AxisRef) => ref.bench.number === bench;
    const ref = axis === 0 ? (this.axes().find(isOfBench) ?? this.model.axes().find(isOfBench)) : this.model.find(`${bench}.${axis}`);
    if (ref === undefined) return;
    this.model.wantedMoment = { address: addressOf(ref), tick: event.tick };
    location.hash = `#/axis/${addressOf(ref)}`;
  }

  private makeTools(): HTMLElement {
    const search = h("input", {
      class: "search",
      attributes: { type: "search", placeholder: t("search_axes"), "aria-label": t("search_chosen") },
    });
    search.addEventListener("input", () => {
      this.words = wordsOf(search.value);
      this.filter();
    });
    const removeAll = button(t("remove_all"), () => this.model.chosen.clear(), { attributes: { "data-test": "remove_all" } });
    return h("div", { class: "tools" }, search, removeAll);
  }

  private filter(): void {
    for (const ref of this.axes()) {
      const line = this.lines.get(addressOf(ref));
      if (line !== undefined) line.root.hidden = !nameMatches(addressOf(ref), ref.axis.name, this.words);
    }
    this.groupMove.filter(this.words);
  }

  private showClocks(): void {
    const benches = this.model.sortedBenches().map((bench) => bench.number);
    if (benches.join() === this.benches) return;
    this.benches = benches.join();
    this.clocks.splice(0, Infinity, ...benches.map((number) => new BenchClock(this.model, number)));
    this.clockPlace.replaceChildren(...this.clocks.map((clock) => clock.root));
  }

  private showChosen(): void {
    const axes = this.axes();
    const wanted = axes.map(addressOf).join(" ");
    if (wanted !== this.shown) this.buildChosen(axes, wanted);
    for (const ref of axes) {
      const line = this.lines.get(addressOf(ref));
      const place = ref.bench.places.get(ref.axis.axis);
      if (line === undefined || place === undefined) continue;
      const state = decodePowerState(Number(ref.bench.numbers("ds402_statusword")?.[place] ?? 0));
      const lamp = `lamp ${state}`;
      if (line.lamp.className !== lamp) line.lamp.className = lamp;
      put(line.state, stateName(state));
      const scale = this.model.scale(ref.axis);
      const position = Number(ref.bench.numbers("load_position_actual_value")?.[place] ?? 0);
      put(line.position, `${formatUnits(position, scale)} ${scale.name}`);
    }
  }

  private buildChosen(axes: AxisRef[], wanted: string): void {
    this.shown = wanted;
    this.lines.clear();
    const rows = axes.map((ref) => {
      const address = addressOf(ref);
      const lamp = h("span", { class: "lamp" });
      const state = h("span", { class: "state" });
      const position = h("span", { class: "number" });
      const remove = button("×", () => this.model.chosen.delete(address), {
        class: "quiet",
        attributes: { "aria-label": `${t("remove")} ${address}` },
      });
      const name = h("a", { attributes: { href: `#/axis/${address}` } }, `${address} ${ref.axis.name}`);
      const root = h("li", {}, lamp, name, state, position, remove);
      this.lines.set(address, { root, lamp, state, position });
      return root;
    });
    put(this.title, `${t("chosen_axes")}` + (rows.length > 1 ? `: ${rows.length}` : ""));
    this.tools.hidden = rows.length < 2;
    if (rows.length === 0) rows.push(h("li", { class: "empty" }, t("none_chosen")));
    this.list.replaceChildren(...rows);
    this.filter();
  }
}
