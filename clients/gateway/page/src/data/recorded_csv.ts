// SPDX-License-Identifier: Apache-2.0
// CSV as written by `vdrive record`: a row for each axis and tick.

import { RecordedAxis, recordedUnit, SampleLimit, type Kinds, type Recorded } from "./recorded";

/** Columns that are not members of the status. */
const OTHERS = ["axis", "name", "tick", "missed", "owner", "owner_epoch", "unit", "unit_size", "position_in_unit", "velocity_in_unit"];
const NEEDED = ["axis", "tick", "ds402_statusword"];
/** CSV does not contain the period of a tick. `vdrive convert` uses the same default. */
const PERIOD_S = 0.001;
const LONGEST_LINE = 65_536;

/** Takes the text of a file in pieces. Errors name the line. */
export class CsvReader {
  private readonly axes = new Map<string, RecordedAxis>();
  private readonly limit = new SampleLimit();
  private heads?: string[];
  private kinds: Kinds = new Map();
  private readonly places = new Map<string, number>();
  private rest = "";
  private line = 0;

  /** @throws Error if the text is not a recording */
  append(text: string): void {
    const lines = (this.rest + text).split("\n");
    this.rest = lines.pop() ?? "";
    for (const line of lines) this.take(line.replace(/\r$/, ""));
    if (this.rest.length > LONGEST_LINE) throw new Error(`line ${this.line + 1} has more than ${LONGEST_LINE} characters: not a recording`);
  }

  /** @throws Error if nothing can be shown */
  finish(): Recorded {
    const axes = [...this.axes.values()];
    if (this.heads === undefined) throw new Error(this.rest === "" ? "the file is empty" : "neither MCAP nor CSV of vdrive record");
    if (axes.length === 0) throw new Error("it contains no samples");
    const cut = this.rest === "" ? "" : `line ${this.line + 1} is incomplete: the file is truncated; all lines before it are shown`;
    return { axes, events: [], period: PERIOD_S, cut };
  }

  private take(text: string): void {
    ++this.line;
    if (this.heads === undefined) {
      this.takeHeads(text.split(","));
      return;
    }
    if (text === "") return;
    const cells = cellsOf(text);
    if (cells.length !== this.heads.length) this.fail(`${cells.length} columns instead of ${this.heads.length}`);
    const cell = (name: string) => cells[this.places.get(name) ?? -1] ?? "";
    const address = cell("axis");
    if (!/^\d+\.\d+$/.test(address)) this.fail(`axis "${address}" is not an address such as 1.2`);
    const axis = this.axes.get(address) ?? this.newAxis(address, cell);
    this.limit.add();
    const missed = cell("missed") === "" ? 0 : this.whole("missed", cell("missed"));
    try {
      axis.add(this.whole("tick", cell("tick")), (member) => this.member(member, cell(member)), missed);
    } catch (error) {
      this.fail((error as Error).message.replace(/^line \d+: /, ""));
    }
  }

  private takeHeads(heads: string[]): void {
    heads.forEach((head, place) => this.places.set(head, place));
    const missing = NEEDED.filter((head) => !this.places.has(head));
    if (missing.length > 0) this.fail(`no column ${missing.join(", ")}: not a recording of vdrive record`);
    this.heads = heads;
    this.kinds = new Map(heads.filter((head) => !OTHERS.includes(head)).map((head) => [head, Int32Array]));
  }

  private newAxis(address: string, cell: (name: string) => string): RecordedAxis {
    const size = Number(cell("unit_size"));
    const unit = cell("unit") === "" || !(size > 0) ? undefined : recordedUnit(cell("unit"), size);
    const made = new RecordedAxis(address, cell("name"), this.kinds, unit);
    this.axes.set(address, made);
    return made;
  }

  private member(name: string, text: string): number {
    const value = this.whole(name, text);
    return value === (value | 0) ? value : this.fail(`${name} "${text}" is out of range`);
  }

  private whole(name: string, text: string): number {
    const value = Number(text);
    return text !== "" && Number.isSafeInteger(value) ? value : this.fail(`${name} "${text}" is not a whole number`);
  }

  private fail(reason: string): never {
    throw new Error(`line ${this.line}: ${reason}`);
  }
}

/** Names may be quoted. */
function cellsOf(text: string): string[] {
  if (!text.includes('"')) return text.split(",");
  const cells = text.match(/"(?:[^"]|"")*"|[^,]+|(?<=^|,)(?=,|$)/g) ?? [];
  return cells.map((cell) => (cell.startsWith('"') ? cell.slice(1, -1).replaceAll('""', '"') : cell));
}
