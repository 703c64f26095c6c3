// SPDX-License-Identifier: Apache-2.0
// All axes of all benches: a table that draws only the visible rows.

import { decodePowerState } from "../data/power";
import { matches, sorted, type Filter, type Order, type Row, type SortKey } from "../data/rows";
import { formatAge, formatHex, formatPermille, formatUnits } from "../data/units";
import { modeName, stateName, t, type TextKey } from "../i18n";
import { addressOf, TREND_LENGTH, type AxisRef, type Bench, type BenchDescription, type Model } from "../model";
import { colour, fit, FOCUS, h, mark, put, select, type View } from "./dom";

interface TableRow extends Row {
  ref: AxisRef;
  place: number;
}

interface Column {
  key: SortKey | undefined;
  text: TextKey;
  class: string;
}

const COLUMNS: Column[] = [
  { key: "address", text: "address", class: "address" },
  { key: "name", text: "name", class: "name" },
  { key: "state", text: "state", class: "state" },
  { key: "mode", text: "mode", class: "mode" },
  { key: "position", text: "position", class: "position" },
  { key: "velocity", text: "velocity", class: "velocity" },
  { key: "torque", text: "torque", class: "torque" },
  { key: "error", text: "error", class: "error" },
  { key: undefined, text: "trend", class: "trend" },
  { key: "owner", text: "owner", class: "owner" },
  { key: "fault", text: "fault", class: "fault" },
  { key: "age", text: "age", class: "age" },
];
const SPARE_ROWS = 4;
const NUMBERS_EVERY_MS = 66; // faster changes cannot be read
const ORDER_EVERY_MS = 500;
const TREND_EVERY_MS = 100;
const MOVING_FROM = 10; // [UU/s]: less is noise of an axis at standstill
const OLD_FROM_MS = 500;
const NARROW_ROW = 84; // [px] as in the style sheet

/** @returns such as " (bench-0, 1.4.0)": the host of a bench, and its version. */
function placeOf(description: BenchDescription | undefined): string {
  const parts = [description?.host ?? "", description?.service_version ?? ""].filter((part) => part !== "");
  return parts.length === 0 ? "" : ` (${parts.join(", ")})`;
}

function at(bench: Bench, member: string, place: number): number {
  return Number(bench.numbers(member)?.[place] ?? 0);
}

function readRow(model: Model, row: TableRow, now: number): void {
  const bench = row.ref.bench;
  const place = bench.places.get(row.ref.axis.axis);
  row.age = model.age(bench, now);
  row.place = place ?? -1;
  if (place === undefined) return;
  row.state = decodePowerState(at(bench, "ds402_statusword", place));
  row.mode = at(bench, "op_mode_actual", place);
  row.position = at(bench, "load_position_actual_value", place);
  row.velocity = at(bench, "load_velocity_actual_value", place);
  row.torque = at(bench, "torque_actual_value", place);
  row.error = at(bench, "load_position_error_value", place);
  row.fault = at(bench, "error_code", place);
  row.owner = model.ownerName(BigInt(bench.numbers("owner_session")?.[place] ?? 0), true);
  // A velocity demand counts in every mode, however slow: it has no noise.
  row.moving = Math.abs(row.velocity) > MOVING_FROM || at(bench, "velocity_demand_value", place) !== 0;
}

/** The elements of one row, reused for whichever row is at that place on the screen. */
class RowElements {
  readonly root: HTMLElement;
  private readonly cells = new Map<string, HTMLElement>();
  private readonly box: HTMLInputElement;
  private readonly bar: HTMLElement;
  private readonly torque: HTMLElement;
  private readonly word: HTMLElement;
  private readonly lamp: HTMLElement;
  private readonly canvas: HTMLCanvasElement;
  row?: TableRow;

  /** @param choose called with the row, and whether all rows from the previously pressed one are meant */
  constructor(
    private readonly model: Model,
    choose: (row: TableRow, on: boolean, isRange: boolean) => void,
    open: (row: TableRow) => void,
  ) {
    this.root = h("div", { class: "row", attributes: { role: "row", tabindex: "-1" } });
    this.box = h("input", { attributes: { type: "checkbox" } });
    this.box.addEventListener("click", (event) => {
      if (this.row !== undefined) choose(this.row, this.box.checked, event.shiftKey);
    });
    this.root.append(h("div", { class: "cell choose", attributes: { role: "cell" } }, this.box));
    for (const column of COLUMNS) {
      // A narrow screen has no header line, so its cells have labels.
      const attributes = { role: "cell", "data-label": t(column.text) };
      const cell = h("div", { class: `cell ${column.class}`, attributes });
      this.cells.set(column.class, cell);
      this.root.append(cell);
    }
    this.lamp = h("span", { class: "lamp" });
    this.word = h("span");
    this.cell("state").append(this.lamp, this.word);
    this.bar = h("i");
    this.torque = h("b");
    this.cell("torque").append(h("span", { class: "bar" }, this.bar), this.torque);
    this.canvas = h("canvas", { attributes: { "aria-hidden": "true" } });
    this.cell("trend").append(this.canvas);
    this.root.addEventListener("click", (event) => {
      if (event.target !== this.box && this.row) open(this.row);
    });
  }

  private cell(name: string): HTMLElement {
    return this.cells.get(name) as HTMLElement;
  }

  hide(): void {
    this.root.hidden = true;
    this.row = undefined;
    delete this.root.dataset["address"];
  }

  show(row: TableRow, place: number, height: number, now: number): void {
    if (this.root.hidden) this.root.hidden = false;
    readRow(this.model, row, now);
    const moved = `translateY(${place * height}px)`;
    if (this.root.style.transform !== moved) this.root.style.transform = moved;
    const address = addressOf(row.ref);
    if (this.row !== row) {
      this.row = row;
      this.root.setAttribute("aria-rowindex", String(place + 2));
      this.root.dataset["address"] = address;
      put(this.cell("address"), address);
      put(this.cell("name"), row.name);
      this.cell("name").title = row.name;
      this.box.setAttribute("aria-label", `${t("choose")} ${address} ${row.name}`);
    }
    const chosen = this.model.chosen.has(address);
    if (this.box.checked !== chosen) this.box.checked = chosen;
    this.showState(row);
    this.showNumbers(row);
  }

  private showState(row: TableRow): void {
    const known = row.place >= 0;
    this.lamp.className = known ? `lamp ${row.state}` : "lamp";
    put(this.word, known ? stateName(row.state) : "–");
    put(this.cell("mode"), known ? modeName(row.mode) : "–");
    const owner = row.owner === "@" ? t("this_page") : row.owner;
    put(this.cell("owner"), owner === "" ? "–" : owner);
    const fault = row.fault === 0 ? "–" : formatHex(row.fault);
    put(this.cell("fault"), fault);
    this.cell("fault").title = row.fault === 0 ? "" : this.model.errorName(row.fault);
    mark(this.root, "faulted", row.fault !== 0);
    mark(this.root, "old", row.age > OLD_FROM_MS);
    put(this.cell("age"), formatAge(row.age));
  }

  private showNumbers(row: TableRow): void {
    const scale = this.model.scale(row.ref.axis);
    const known = row.place >= 0;
    put(this.cell("position"), known ? formatUnits(row.position, scale) : "–");
    put(this.cell("velocity"), known ? formatUnits(row.velocity, scale) : "–");
    put(this.cell("error"), known ? formatUnits(row.error, scale) : "–");
    put(this.torque, known ? formatPermille(row.torque) : "–");
    const share = Math.max(-1, Math.min(1, row.torque / 3000));
    this.bar.style.transform = `scaleX(${share.toFixed(3)})`;
  }

  drawTrend(line: string): void {
    const row = this.row;
    const width = this.cell("trend").clientWidth - 12;
    if (row === undefined || row.place < 0 || width < 20) return;
    const { trend, trendHead, trendCount } = row.ref.bench;
    const height = 20;
    const context = fit(this.canvas, width, height);
    const value = (i: number) =>
      trend[row.place * TREND_LENGTH + ((trendHead - trendCount + 1 + i + TREND_LENGTH) % TREND_LENGTH)];
    let low = Infinity;
    let high = -Infinity;
    for (let i = 0; i < trendCount; ++i) {
      low = Math.min(low, value(i));
      high = Math.max(high, value(i));
    }
    const span = Math.max(high - low, 100); // less is noise and drawn as a line
    const middle = (low + high) / 2;
    context.strokeStyle = line;
    context.lineWidth = 1.2;
    context.beginPath();
    for (let i = 0; i < trendCount; ++i) {
      const x = ((TREND_LENGTH - trendCount + i) / (TREND_LENGTH - 1)) * width;
      const y = height / 2 - ((value(i) - middle) / span) * (height - 3);
      if (i === 0) context.moveTo(x, y);
      else context.lineTo(x, y);
    }
    context.stroke();
  }
}

/** The state of the overview, kept while another view is shown. */
export interface OverviewMemory {
  filter: Filter;
  order: Order;
  scrolled: number;
  /** index of the row that was selected by keyboard or opened */
  selected: number;
}

export function overviewMemory(): OverviewMemory {
  return {
    filter: { text: "", bench: undefined, faulted: false, moving: false, owned: false },
    order: { key: "address", descending: false },
    scrolled: 0,
    selected: 0,
  };
}

export class Overview implements View {
  readonly root: HTMLElement;
  private readonly scroller: HTMLElement;
  private readonly space: HTMLElement;
  private readonly head: HTMLElement;
  private readonly nothing: HTMLElement;
  private readonly count: HTMLElement;
  private readonly benchPlace = h("span");
  private benchesShown = "";
  private readonly headers = new Map<SortKey, HTMLElement>();
  private readonly pool: RowElements[] = [];
  private rows: TableRow[] = [];
  private shown: TableRow[] = [];
  private version = -1;
  private orderedAt = 0;
  private numbersAt = 0;
  private trendAt = 0;
  private scrolledTo = -1;
  private height = 28;
  private chosenLast = "";

  constructor(
    private readonly model: Model,
    private readonly memory: OverviewMemory,
  ) {
    this.count = h("span", { class: "count", attributes: { "aria-live": "polite" } });
    this.head = this.makeHead();
    this.space = h("div", { class: "space", attributes: { role: "rowgroup" } });
    this.nothing = h("p", { class: "nothing" });
    this.scroller = h(
      "div",
      {
        class: "scroller",
        attributes: { ...FOCUS, role: "table", "aria-label": t("overview"), tabindex: "0" },
        on: { scroll: () => (memory.scrolled = this.scroller.scrollTop), keydown: (event) => this.key(event) },
      },
      this.head,
      this.space,
    );
    this.root = h("section", { class: "overview" }, h("h2", { class: "only-heard" }, t("overview")), this.makeTools(), this.scroller, this.nothing);
    model.wantStatus(true);
    requestAnimationFrame(() => (this.scroller.scrollTop = memory.scrolled));
  }

  update(now: number): void {
    if (this.version !== this.model.version) this.rebuild(now);
    if (now - this.orderedAt > ORDER_EVERY_MS) this.reorder(now);
    const top = this.scroller.scrollTop;
    const numbers = now - this.numbersAt > NUMBERS_EVERY_MS;
    if (top !== this.scrolledTo || numbers) {
      if (numbers) this.numbersAt = now;
      this.scrolledTo = top;
      this.draw(top, now);
    }
    if (now - this.trendAt > TREND_EVERY_MS) {
      this.trendAt = now;
      const line = colour("line-1");
      for (const elements of this.pool) elements.drawTrend(line);
    }
  }

  close(): void {
    this.model.wantStatus(false);
  }

  private makeTools(): HTMLElement {
    const { filter } = this.memory;
    const search = h("input", {
      class: "search",
      attributes: { type: "search", placeholder: t("search_axes"), "aria-label": t("search") },
    });
    search.value = filter.text;
    search.addEventListener("input", () => {
      filter.text = search.value;
      this.orderedAt = 0;
    });
    const toggle = (key: "faulted" | "moving" | "owned") => {
      const made = h("button", {
        class: "toggle",
        attributes: { type: "button", "aria-pressed": String(filter[key]) },
        on: {
          click: () => {
            filter[key] = !filter[key];
            made.setAttribute("aria-pressed", String(filter[key]));
            this.orderedAt = 0;
          },
        },
      }, t(key));
      return made;
    };
    const order = select(
      t("sort_by"),
      COLUMNS.filter((c) => c.key !== undefined).map((c) => ({ value: c.key as string, text: t(c.text) })),
      this.memory.order.key,
      (value) => this.sortBy(value as SortKey),
    );
    order.classList.add("narrow-only");
    return h("div", { class: "tools" }, search, this.benchPlace, toggle("faulted"), toggle("moving"), toggle("owned"), order, this.count);
  }

  /** Rebuilds the list of benches when it has changed. */
  private showBenches(): void {
    const { filter } = this.memory;
    const options = [
      { value: "", text: t("all_benches") },
      ...this.model.sortedBenches().map((bench) => ({
        value: String(bench.number),
        text: `${bench.number} ${bench.description?.name ?? ""}${placeOf(bench.description)}`,
      })),
    ];
    const wanted = options.map((option) => option.text).join("\n");
    if (wanted === this.benchesShown) return;
    this.benchesShown = wanted;
    if (!options.some((option) => option.value === String(filter.bench ?? ""))) filter.bench = undefined;
    const made = select(t("all_benches"), options, String(filter.bench ?? ""), (value) => {
      filter.bench = value === "" ? undefined : Number(value);
      this.orderedAt = 0;
    });
    this.benchPlace.replaceChildren(made);
  }

  private makeHead(): HTMLElement {
    const all = h("input", { title: t("choose_shown"), attributes: { type: "checkbox", "aria-label": t("choose_shown") } });
    all.addEventListener("change", () => {
      for (const row of this.shown) {
        if (all.checked) this.model.chosen.add(addressOf(row.ref));
        else this.model.chosen.delete(addressOf(row.ref));
      }
      this.numbersAt = 0;
    });
    const head = h("div", { class: "row head", attributes: { role: "row" } });
    head.append(h("div", { class: "cell choose", attributes: { role: "columnheader" } }, all));
    for (const column of COLUMNS) {
      const cell = h("div", { class: `cell ${column.class}`, attributes: { role: "columnheader" } });
      const key = column.key;
      if (key === undefined) cell.append(t(column.text));
      else {
        cell.append(h("button", { attributes: { type: "button" }, on: { click: () => this.sortBy(key) } }, t(column.text)));
        this.headers.set(key, cell);
      }
      head.append(cell);
    }
    return head;
  }

  private sortBy(key: SortKey): void {
    const { order } = this.memory;
    const biggestFirst = ["velocity", "torque", "error", "fault", "age"].includes(key);
    order.descending = order.key === key ? !order.descending : biggestFirst;
    order.key = key;
    this.orderedAt = 0;
  }

  private rebuild(now: number): void {
    this.version = this.model.version;
    this.showBenches();
    this.rows = this.model.axes().map((ref) => ({
      ref,
      place: -1,
      bench: ref.bench.number,
      axis: ref.axis.axis,
      name: ref.axis.name,
      state: "not_ready_to_switch_on",
      mode: 0,
      position: 0,
      velocity: 0,
      torque: 0,
      error: 0,
      owner: "",
      fault: 0,
      moving: false,
      age: Infinity,
    }));
    this.reorder(now);
  }

  private reorder(now: number): void {
    this.orderedAt = now;
    this.numbersAt = 0;
    const { filter, order } = this.memory;
    for (const row of this.rows) readRow(this.model, row, now);
    this.shown = sorted(this.rows.filter((row) => matches(row, filter)), order);
    for (const [key, cell] of this.headers) {
      cell.setAttribute("aria-sort", key !== order.key ? "none" : order.descending ? "descending" : "ascending");
    }
    const chosen = this.rows.filter((row) => this.model.chosen.has(addressOf(row.ref))).length;
    const of = this.shown.length === this.rows.length ? "" : ` / ${this.rows.length}`;
    put(this.count, `${this.shown.length}${of} ${t("axes")}` + (chosen === 0 ? "" : `, ${chosen} ${t("chosen")}`));
    this.nothing.hidden = this.shown.length > 0;
    put(this.nothing, this.rows.length === 0 ? t("no_benches") : t("no_rows"));
    this.scroller.setAttribute("aria-rowcount", String(this.shown.length + 1));
  }

  private draw(top: number, now: number): void {
    this.height = this.head.offsetHeight > 0 ? 28 : NARROW_ROW; // only a narrow screen has no head
    const total = `${this.shown.length * this.height}px`;
    if (this.space.style.height !== total) this.space.style.height = total;
    const visible = Math.ceil(this.scroller.clientHeight / this.height) + SPARE_ROWS;
    const first = Math.max(0, Math.min(Math.floor(top / this.height) - SPARE_ROWS / 2, this.shown.length - visible));
    while (this.pool.length < visible) {
      const made = new RowElements(
        this.model,
        (row, on, isRange) => this.choose(row, on, isRange),
        (row) => this.open(row),
      );
      this.pool.push(made);
      this.space.append(made.root);
    }
    // A row keeps its elements while it is visible: its index modulo the size of the pool selects them.
    const end = Math.min(first + this.pool.length, this.shown.length);
    for (let place = end; place < first + this.pool.length; ++place) this.pool[place % this.pool.length].hide();
    for (let place = first; place < end; ++place) {
      const elements = this.pool[place % this.pool.length];
      elements.show(this.shown[place], place, this.height, now);
      mark(elements.root, "selected", place === this.memory.selected && this.scroller.matches(":focus-visible"));
    }
  }

  /** Selects or deselects a row; with Shift, every row from the previously pressed one, in the order shown. */
  private choose(row: TableRow, on: boolean, isRange: boolean): void {
    const place = this.shown.indexOf(row);
    const before = isRange ? this.shown.findIndex((shown) => addressOf(shown.ref) === this.chosenLast) : -1;
    const first = before < 0 ? place : Math.min(before, place);
    for (const { ref } of this.shown.slice(first, Math.max(before, place) + 1)) {
      if (on) this.model.chosen.add(addressOf(ref));
      else this.model.chosen.delete(addressOf(ref));
    }
    this.chosenLast = addressOf(row.ref);
    this.orderedAt = 0;
  }

  private open(row: TableRow): void {
    this.memory.selected = this.shown.indexOf(row);
    location.hash = `#/axis/${addressOf(row.ref)}`;
  }

  private key(event: KeyboardEvent): void {
    const steps: Record<string, number> = { ArrowDown: 1, ArrowUp: -1 };
    const row = this.shown[this.memory.selected];
    if (event.target !== this.scroller) return;
    if (event.key in steps) {
      this.memory.selected = Math.max(0, Math.min(this.shown.length - 1, this.memory.selected + steps[event.key]));
      const top = this.memory.selected * this.height;
      const height = this.scroller.clientHeight - this.head.offsetHeight;
      if (top < this.scroller.scrollTop) this.scroller.scrollTop = top;
      if (top + this.height > this.scroller.scrollTop + height) this.scroller.scrollTop = top + this.height - height;
    } else if (event.key === "Enter" && row !== undefined) {
      this.open(row);
    } else if (event.key === " " && row !== undefined) {
      const address = addressOf(row.ref);
      if (!this.model.chosen.delete(address)) this.model.chosen.add(address);
    } else {
      return;
    }
    event.preventDefault();
    this.numbersAt = 0;
  }
}
