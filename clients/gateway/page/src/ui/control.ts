// SPDX-License-Identifier: Apache-2.0
// Commands for the axes that were chosen in the overview, and the clocks of the benches.

import { decodePowerState } from "../data/power";
import { formatUnits } from "../data/units";
import { stateName, t } from "../i18n";
import { addressOf, type AxisRef, type Model } from "../model";
import { BenchClock, Commands, GroupMove } from "./commands";
import { button, h, put, type View } from "./dom";
import { Events } from "./events";

const FIGURES_EVERY_MS = 100;

export class ControlView implements View {
  readonly root: HTMLElement;
  private readonly parts: View[];
  private readonly list = h("ul", { class: "chosen" });
  private readonly lines = new Map<string, { lamp: HTMLElement; state: HTMLElement; position: HTMLElement }>();
  private readonly clockPlace = h("div", { class: "clocks" });
  private readonly clocks: BenchClock[] = [];
  private shown = "?";
  private shownAt = 0;
  private benches = "";

  constructor(private readonly model: Model) {
    const axes = () => this.axes();
    const commands = new Commands(model, axes);
    const groupMove = new GroupMove(model, axes);
    const events = new Events(model, () => true);
    this.parts = [commands, groupMove, events];
    const chosen = h("section", { class: "panel" }, h("h3", {}, t("chosen_axes")), this.list);
    this.root = h(
      "div",
      { class: "control-view" },
      h("div", { class: "main-column" }, chosen, groupMove.root, this.clockPlace, events.root),
      h("div", { class: "side-column" }, commands.root),
    );
    model.wantStatus(true);
  }

  update(now: number): void {
    this.showClocks();
    for (const part of [...this.parts, ...this.clocks]) part.update(now);
    if (now - this.shownAt < FIGURES_EVERY_MS) return;
    this.shownAt = now;
    this.showChosen();
  }

  close(): void {
    for (const part of this.parts) part.close?.();
    this.model.wantStatus(false);
  }

  private axes(): AxisRef[] {
    return [...this.model.chosen].flatMap((address) => this.model.find(address) ?? []);
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
      line.lamp.className = `lamp ${state}`;
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
      const line = { lamp: h("span", { class: "lamp" }), state: h("span", { class: "state" }), position: h("span", { class: "number" }) };
      this.lines.set(address, line);
      const remove = button("×", () => this.model.chosen.delete(address), {
        class: "quiet",
        attributes: { "aria-label": `${t("remove")} ${address}` },
      });
      const name = h("a", { attributes: { href: `#/axis/${address}` } }, `${address} ${ref.axis.name}`);
      return h("li", {}, line.lamp, name, line.state, line.position, remove);
    });
    if (rows.length === 0) rows.push(h("li", { class: "empty" }, t("none_chosen")));
    this.list.replaceChildren(...rows);
  }
}
