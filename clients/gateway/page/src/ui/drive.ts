// SPDX-License-Identifier: Apache-2.0
// The controlword and statusword bit by bit, and the power state machine.

import { decodePowerState, POWER_STATES, type PowerState } from "../data/power";
import { formatHex } from "../data/units";
import { bitName, stateName, t } from "../i18n";
import type { Model } from "../model";
import type { Trace } from "../trace";
import { h, mark, put, s, type View } from "./dom";

const BITS = 16;

class Word {
  readonly root: HTMLElement;
  private readonly value = h("span", { class: "number" }, "–");
  private readonly rows: { lamp: HTMLElement; name: HTMLElement; root: HTMLElement }[] = [];
  private shown?: number;
  private shownNames?: string[];

  constructor(title: string, note: string) {
    const list = h("ol", { class: "bits", attributes: { "aria-label": title } });
    for (let bit = BITS - 1; bit >= 0; --bit) {
      const lamp = h("span", { class: "bit" }, "0");
      const name = h("span", { class: "bit-name" });
      const root = h("li", {}, h("span", { class: "bit-number" }, String(bit)), lamp, name);
      this.rows[bit] = { lamp, name, root };
      list.append(root);
    }
    const head = h("h3", {}, title, this.value);
    if (note !== "") head.title = note;
    this.root = h("div", { class: "word" }, head, list);
  }

  show(word: number | undefined, names: string[]): void {
    if (word === this.shown && names === this.shownNames) return;
    this.shown = word;
    this.shownNames = names;
    put(this.value, word === undefined ? "–" : formatHex(word));
    this.rows.forEach(({ lamp, name, root }, bit) => {
      const on = word !== undefined && (word >> bit) % 2 === 1;
      put(lamp, word === undefined ? "–" : on ? "1" : "0");
      put(name, bitName(names[bit] ?? ""));
      mark(root, "on", on);
    });
  }
}

const NO_NAMES: string[] = [];

export class Words implements View {
  readonly root: HTMLElement;
  private readonly status: Word;
  private readonly control: Word;

  constructor(
    private readonly model: Model,
    private readonly trace: Trace,
  ) {
    this.status = new Word(t("statusword"), "");
    this.control = new Word(t("controlword"), t("controlword_source"));
    this.root = h("section", { class: "words panel" }, this.status.root, this.control.root);
  }

  update(): void {
    const mode = this.trace.last["op_mode_actual"] ?? 0;
    const { dictionary } = this.model;
    const names = (table: { mode: number; bits: string[] }[] | undefined) =>
      (table?.find((row) => row.mode === mode) ?? table?.[0])?.bits ?? NO_NAMES;
    this.status.show(this.trace.last["ds402_statusword"], names(dictionary?.statusword_bits));
    this.control.show(this.trace.controlword, names(dictionary?.controlword_bits));
  }
}

interface Box {
  x: number;
  y: number;
}

const WIDTH = 146;
const HEIGHT = 26;
const PLACES: Record<PowerState, Box> = {
  not_ready_to_switch_on: { x: 6, y: 6 },
  switch_on_disabled: { x: 6, y: 70 },
  ready_to_switch_on: { x: 6, y: 134 },
  switched_on: { x: 6, y: 198 },
  operation_enabled: { x: 6, y: 262 },
  quick_stop_active: { x: 268, y: 262 },
  fault_reaction_active: { x: 268, y: 6 },
  fault: { x: 268, y: 70 },
};

/** The path of each transition, and the position of its number. */
const ARROWS: { number: number; path: string; label: [number, number] }[] = [
  { number: 1, path: "M79 32V70", label: [86, 54] },
  { number: 2, path: "M50 96V134", label: [40, 118] },
  { number: 7, path: "M108 134V96", label: [116, 118] },
  { number: 3, path: "M50 160V198", label: [40, 182] },
  { number: 6, path: "M108 198V160", label: [116, 182] },
  { number: 4, path: "M50 224V262", label: [40, 246] },
  { number: 5, path: "M108 262V224", label: [116, 246] },
  { number: 8, path: "M152 266H170V147H152", label: [177, 170] },
  { number: 10, path: "M152 211H190V89H152", label: [199, 128] },
  { number: 9, path: "M152 271H212V83H152", label: [219, 200] },
  { number: 11, path: "M152 278H268", label: [240, 274] },
  { number: 16, path: "M268 284H152", label: [240, 296] },
  { number: 12, path: "M341 262V150H232V77H152", label: [349, 210] },
  { number: 14, path: "M341 32V70", label: [349, 54] },
  { number: 15, path: "M268 89H246V62H120V70", label: [256, 102] },
  { number: 13, path: "M214 19H268", label: [240, 15] },
];

export class PowerMachine implements View {
  readonly root: HTMLElement;
  private readonly boxes = new Map<PowerState, SVGGElement>();
  private readonly arrows = new Map<number, SVGGElement>();
  private readonly wayText = h("p", { class: "way", attributes: { "aria-live": "polite" } });
  private shown?: PowerState;

  constructor(private readonly trace: Trace) {
    const svg = s("svg", { viewBox: "0 0 420 302", role: "img", "aria-label": t("power_machine"), class: "machine" });
    svg.append(
      s(
        "defs",
        {},
        ...["tip", "tip-taken"].map((id) =>
          s("marker", { id, viewBox: "0 0 10 10", refX: 9, refY: 5, markerWidth: 7, markerHeight: 7, orient: "auto" }, s("path", { d: "M0 0L10 5L0 10z" })),
        ),
      ),
    );
    for (const { number, path, label } of ARROWS) {
      const group = s(
        "g",
        { class: "arrow" },
        s("path", { d: path }),
        s("text", { x: label[0], y: label[1], "text-anchor": "middle" }, String(number)),
      );
      this.arrows.set(number, group);
      svg.append(group);
    }
    svg.append(s("text", { x: 210, y: 22, "text-anchor": "end", class: "any" }, t("any_state")));
    for (const state of POWER_STATES) {
      const { x, y } = PLACES[state];
      const group = s(
        "g",
        { class: "box" },
        s("rect", { x, y, width: WIDTH, height: HEIGHT, rx: 4 }),
        s("text", { x: x + WIDTH / 2, y: y + 17, "text-anchor": "middle" }, stateName(state)),
      );
      this.boxes.set(state, group);
      svg.append(group);
    }
    this.root = h("section", { class: "panel power" }, h("h3", {}, t("power_machine")));
    this.root.append(svg, this.wayText);
  }

  update(): void {
    const word = this.trace.last["ds402_statusword"];
    const state = word === undefined ? undefined : decodePowerState(word);
    if (state !== this.shown) {
      this.shown = state;
      for (const [name, box] of this.boxes) box.setAttribute("class", name === state ? `box lit ${name}` : "box");
    }
    const way = this.trace.way;
    for (const [number, arrow] of this.arrows) {
      const wanted = way?.transitions.includes(number) === true ? "arrow taken" : "arrow";
      if (arrow.getAttribute("class") !== wanted) arrow.setAttribute("class", wanted);
    }
    put(
      this.wayText,
      way === undefined
        ? `${t("last_way")}: ${t("no_way")}`
        : `${t("last_way")}: ${stateName(way.from)} → ${stateName(way.to)} (${way.transitions.join(", ")}), ${t("tick")} ${way.tick}`,
    );
  }
}
