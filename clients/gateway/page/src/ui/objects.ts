// SPDX-License-Identifier: Apache-2.0
// The object dictionary of one axis: every object with its value, which can be written.

import { formatHex, formatNumber, formatUnits, parseNumber, suffixOf, USER_UNITS, whyNoNumber, type Scale, type Suffix } from "../data/units";
import { language, t } from "../i18n";
import { addressOf, type AxisRef, type Model, type ObjectRow } from "../model";
import { button, h, mark, put, type View } from "./dom";
import { userUnitsTyped } from "./quantity";

const READ_EVERY_MS = 1_000;
const OBJECTS_A_CALL = 32;
const COLUMNS = [
  ["object", "index"],
  ["name", "title"],
  ["value", "value"],
  ["unit", "unit"],
  ["range", "range"],
  ["default_value", "default"],
  ["access", "access"],
] as const;

interface ObjectValue {
  object: string;
  value?: number;
  code?: number;
  message?: string;
}

function asNumber(value: string | number): number {
  return typeof value === "number" ? value : Number(value.startsWith("0x") ? value : `0x${value}`);
}

/** @return "0x607D:01" or "0x6081" */
export function objectAddress(row: ObjectRow): string {
  const index = asNumber(row.index).toString(16).toUpperCase().padStart(4, "0");
  const sub = asNumber(row.sub_index);
  return `0x${index}` + (sub === 0 ? "" : `:${String(sub).padStart(2, "0")}`);
}

function isWritable(row: ObjectRow): boolean {
  return /w/i.test(row.access);
}

/** Names of units may have a Chinese explanation in brackets. */
function unitText(unit: string): string {
  const plain = unit === "-" ? "" : unit;
  return language() === "zh" ? plain : plain.replace(/[（(][^（(]*[\u4e00-\u9fff].*[）)]/, "").trim();
}

class ObjectLine {
  readonly root: HTMLElement;
  readonly address: string;
  private readonly value = h("span", { class: "number" }, "–");
  private readonly valueCell: HTMLElement;
  private latest?: number;
  private readonly suffix: Suffix | undefined;
  /** for a position, a velocity, an acceleration or a jerk: the unit that the page shows */
  private readonly scale: Scale;

  constructor(
    readonly row: ObjectRow,
    private readonly model: Model,
    private readonly ref: AxisRef,
  ) {
    this.suffix = suffixOf(row.unit);
    this.scale = this.suffix === undefined ? USER_UNITS : model.scale(ref.axis);
    this.address = objectAddress(row);
    const sub = asNumber(row.sub_index);
    const shown = formatHex(asNumber(row.index)) + (sub === 0 ? "" : `:${sub}`);
    const title = language() === "zh" ? row.title_zh : row.title;
    this.valueCell = h("td", { class: "value" }, this.value);
    if (isWritable(row)) this.valueCell.append(this.editButton());
    this.root = h(
      "tr",
      { attributes: { "data-object": this.address } },
      h("td", { class: "number index" }, shown),
      h("td", { class: "title", title: row.name }, h("span", {}, title), h("code", {}, row.name)),
      this.valueCell,
      h("td", { class: "unit" }, this.suffix === undefined ? unitText(row.unit) : this.scale.name + this.suffix),
      h("td", { class: "number range" }, h("div", {}, formatUnits(row.minimum, this.scale)), h("div", {}, formatUnits(row.maximum, this.scale))),
      h("td", { class: "number default" }, formatUnits(row.default, this.scale)),
      h("td", { class: "access" }, isWritable(row) ? "rw" : "ro"),
    );
  }

  show(read: ObjectValue): void {
    const good = (read.code ?? 0) === 0 && read.value !== undefined;
    if (good) this.latest = read.value;
    put(this.value, good ? formatUnits(read.value as number, this.scale) : "–");
    const raw = this.scale === USER_UNITS ? "" : `${formatNumber(read.value ?? 0, 0)} UU${this.suffix}, `;
    this.value.title = good ? `${raw}0x${(read.value as number).toString(16).toUpperCase()}` : (read.message ?? "");
  }

  /** @return false for an entry beyond the end of a list: the drive would refuse to read it, and report the refusal
   *          as an event. Sub-index 0 of a list counts its entries (CiA 301). */
  isReadable(lines: ObjectLine[]): boolean {
    const sub = asNumber(this.row.sub_index);
    const count = lines.find((line) => line.row.index === this.row.index && asNumber(line.row.sub_index) === 0);
    const readable = sub === 0 || count === undefined || sub <= (count.latest ?? 0);
    if (!readable) this.show({ object: this.address });
    return readable;
  }

  matches(words: string[]): boolean {
    const { row } = this;
    const index = asNumber(row.index).toString(16);
    const text = `${row.title} ${row.title_zh} ${row.name}`.toLowerCase();
    return words.every((word) => text.includes(word) || index.startsWith(word.replace(/^0x|h$/g, "")));
  }

  private editButton(): HTMLButtonElement {
    return button(t("edit"), () => this.edit(), {
      class: "edit",
      attributes: { "aria-label": `${t("edit")} ${this.address}` },
    });
  }

  /** @throws Error with the reason if the drive cannot take the value in the text */
  private read(text: string, notes: string[]): number {
    if (this.suffix !== undefined) return userUnitsTyped(text, this.scale, this.ref.axis.unit, this.suffix, notes);
    const value = parseNumber(text);
    if (value === undefined) throw new Error(`"${text}" ${t(whyNoNumber(text))}`);
    if (!Number.isInteger(value)) throw new Error(`"${text}" ${t("fraction")}`);
    return value;
  }

  private edit(): void {
    const input = h("input", { attributes: { type: "text", inputmode: "decimal", "aria-label": this.row.title } });
    const shown = this.latest;
    const before = shown === undefined ? "" : String(Number((shown * this.scale.factor).toFixed(this.scale.decimals)));
    input.value = before;
    const leave = () => this.valueCell.replaceChildren(this.value, this.editButton());
    const refuse = (reason: string) => {
      input.setAttribute("aria-invalid", "true");
      this.model.outcome = { ok: false, text: `${this.address}: ${reason}` };
    };
    const write = async () => {
      const notes: string[] = [];
      try {
        // An unchanged value is not rounded.
        const value = shown !== undefined && input.value === before ? shown : this.read(input.value.trim(), notes);
        const answer = await this.model.command("/write", { axis: addressOf(this.ref), object: this.address, value }, notes);
        if (answer.ok) leave();
      } catch (error) {
        refuse(error instanceof Error ? error.message : String(error));
      }
    };
    const form = h("form", { class: "editing" }, input, h("button", {}, t("write")), button(t("cancel"), leave));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void write();
    });
    form.addEventListener("keydown", (event) => {
      // Escape also ends the composition of Chinese characters.
      if (event.key === "Escape" && !event.isComposing) leave();
    });
    this.valueCell.replaceChildren(form);
    input.select();
  }
}

export class Objects implements View {
  readonly root: HTMLElement;
  private readonly body = h("tbody");
  private readonly needText = h("span", { class: "need" });
  private lines: ObjectLine[] = [];
  private readAt = 0;
  private reading = false;
  private built?: unknown;
  private builtIn?: Scale;
  private words: string[] = [];
  private readonly axis: string;

  constructor(
    private readonly model: Model,
    private readonly ref: AxisRef,
  ) {
    this.axis = addressOf(ref);
    const search = h("input", {
      class: "search",
      attributes: { type: "search", placeholder: t("search_objects"), "aria-label": t("search_objects") },
    });
    search.addEventListener("input", () => {
      this.words = search.value.toLowerCase().split(/\s+/).filter((word) => word !== "");
      this.filter();
    });
    const heads = COLUMNS.map(([key, name]) => h("th", { class: name, attributes: { scope: "col" } }, t(key)));
    this.root = h(
      "section",
      { class: "panel objects" },
      h("div", { class: "tools" }, h("h3", {}, t("objects")), this.needText, search),
      h("div", { class: "table-scroller", attributes: { tabindex: "0", role: "region", "aria-label": t("objects") } }, h("table", {}, h("thead", {}, h("tr", {}, ...heads)), this.body)),
    );
  }

  update(now: number): void {
    const scale = this.model.scale(this.ref.axis);
    const isSame = this.built === this.model.dictionary && scale.name === this.builtIn?.name && scale.factor === this.builtIn.factor;
    if (this.model.dictionary !== undefined && !isSame) this.build();
    // Users without control see the reason instead of buttons whose requests would be refused.
    const need = this.model.whyDisabled([this.ref], now);
    put(this.needText, need);
    mark(this.root, "looking", need !== "");
    const visible = this.root.getClientRects().length > 0;
    if (visible && !this.reading && now - this.readAt > READ_EVERY_MS && this.model.connected) {
      this.readAt = now;
      void this.read();
    }
  }

  private build(): void {
    this.built = this.model.dictionary;
    this.builtIn = this.model.scale(this.ref.axis);
    this.lines = (this.model.dictionary?.objects ?? []).map((row) => new ObjectLine(row, this.model, this.ref));
    this.body.replaceChildren(...this.lines.map((line) => line.root));
    this.filter();
  }

  private filter(): void {
    for (const line of this.lines) line.root.hidden = !line.matches(this.words);
    mark(this.root, "filtered", this.words.length > 0);
  }

  private async read(): Promise<void> {
    this.reading = true;
    const wanted = this.lines.filter((line) => !line.root.hidden && line.isReadable(this.lines));
    for (let i = 0; i < wanted.length; i += OBJECTS_A_CALL) {
      const part = wanted.slice(i, i + OBJECTS_A_CALL);
      const objects = part.map((line) => line.address);
      const answer = await this.model.connection.call("/read", { axis: this.axis, objects });
      const values = (answer["values"] ?? []) as ObjectValue[];
      values.forEach((value, at) => part[at]?.show(value));
    }
    this.reading = false;
  }
}
