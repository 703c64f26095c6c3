// SPDX-License-Identifier: Apache-2.0
// The history of one axis, filled by its trace channel: every tick.

import { History } from "./data/history";
import { decodePowerState, STATUS_BIT, wayBetween, type PowerState } from "./data/power";
import { CONTROL_BIT, heldSetPoints, type HeldSetPoints } from "./data/setpoints";
import { addressOf, topicOf, type AxisRef, type Model } from "./model";
import type { Message, NumberArray } from "./protocol/cdr";

/** Members of the status that the plots show; then three bits as 0 or 1. */
export const MEMBERS = [
  "position_demand_value",
  "load_position_actual_value",
  "velocity_demand_value",
  "load_velocity_actual_value",
  "motor_velocity_actual_value",
  "load_position_error_value",
  "torque_demand",
  "torque_actual_value",
  "current_actual_value",
] as const;
export type Series = (typeof MEMBERS)[number] | "new_set_point" | "acknowledge" | "reached";
export const SERIES: readonly Series[] = [...MEMBERS, "new_set_point", "acknowledge", "reached"];

export function seriesAt(series: Series): number {
  return SERIES.indexOf(series);
}

export interface Way {
  from: PowerState;
  to: PowerState;
  transitions: number[];
  tick: number;
}

/** A moment of the set-point handshake. */
export interface HandshakeMark {
  time: number;
  kind: "accepted" | "ignored" | "reached";
}

export const LONGEST_WINDOW_S = 600;
const MOST_SAMPLES = 1_200_000;
const MOST_MARKS = 2_000;
const CONTROLWORD_EVERY_MS = 200;

export class Trace {
  readonly history: History;
  readonly marks: HandshakeMark[] = [];
  /** The newest value of each member of the status. */
  readonly last: Record<string, number> = {};
  owner = 0n;
  lastTick = 0;
  /** ticks lost since the first message */
  lost = 0;
  way?: Way;
  /** 6040h as it was read last; undefined before that or when it cannot be read. */
  controlword?: number;
  /** When 6040h was read last; undefined as that, and where the drive takes no set-points. */
  setPoints?: HeldSetPoints;
  private reading = false;
  private missedBefore?: number;
  private droppedBefore = 0;
  private ticksLeftOut = 0;
  private originTick?: number;
  private readonly period: number;
  private readonly ends: (() => void)[];
  private readonly timer: number;
  private readonly sample = new Array<number>(SERIES.length).fill(0);
  private statusword?: number;
  private ignored?: number;

  constructor(
    private readonly model: Model,
    readonly ref: AxisRef,
  ) {
    this.period = (ref.bench.description?.period_us ?? 1000) * 1e-6;
    this.history = new History(SERIES.length, Math.min(MOST_SAMPLES, LONGEST_WINDOW_S / this.period));
    const topic = topicOf(ref);
    this.ends = [
      model.connection.subscribe(`${topic}/trace`, (message) => this.take(message)),
      model.connection.subscribe(`${topic}/status`, (message) => {
        this.owner = message["owner_session"] as bigint;
      }),
    ];
    this.timer = window.setInterval(() => void this.readControlword(), CONTROLWORD_EVERY_MS);
    void this.readControlword();
  }

  close(): void {
    for (const end of this.ends) end();
    window.clearInterval(this.timer);
  }

  /** @return the tick of a time of the history. */
  tickAt(time: number): number {
    return (this.originTick ?? 0) + Math.round(time / this.period);
  }

  /** [s] of the newest sample */
  get now(): number {
    return this.history.end === 0 ? 0 : this.history.time(this.history.end - 1);
  }

  /** Controlword, statusword and mode of one tick. */
  private async readControlword(): Promise<void> {
    if (!this.model.connected || this.reading) return;
    this.reading = true;
    const objects = ["0x6040", "0x6041", "0x6061"];
    const answer = await this.model.connection.call("/read", { axis: addressOf(this.ref), objects });
    this.reading = false;
    const values = (answer["values"] as { value?: number; code?: number }[] | undefined)?.map((v) => (v.code === 0 ? v.value : undefined));
    const [control, status, mode] = values ?? [];
    this.controlword = control;
    const known = control !== undefined && status !== undefined && mode !== undefined;
    this.setPoints = known ? heldSetPoints(control, status, mode) : undefined;
  }

  private take(message: Message): void {
    const ticks = message["tick"] as BigUint64Array;
    const columns = MEMBERS.map((member) => message[member] as NumberArray | undefined);
    const words = message["ds402_statusword"] as Uint16Array;
    const ignored = message["ignored_set_points"] as Uint32Array | undefined;
    const written = message["ds402_controlword"] as Uint16Array | undefined;
    const missed = Number(message["missed"] as bigint);
    this.missedBefore ??= missed;
    const lost = Math.max(0, missed - this.missedBefore) + this.leftOut(Number(ticks[0]));
    if (lost > this.lost && this.history.end > 0) this.history.markGap();
    this.lost = lost;
    for (let i = 0; i < ticks.length; ++i) {
      const tick = Number(ticks[i]);
      if (tick <= this.lastTick && this.originTick !== undefined) this.restart();
      this.originTick ??= tick;
      this.lastTick = tick;
      columns.forEach((column, at) => (this.sample[at] = Number(column?.[i] ?? 0)));
      const time = (tick - this.originTick) * this.period;
      this.takeBits(time, tick, words[i], written?.[i], ignored?.[i] ?? 0);
      this.history.append(time, this.sample);
    }
    this.keepLast(message, ticks.length - 1);
  }

  /** Ticks of messages that this page itself left out. */
  private leftOut(tick: number): number {
    const { dropped } = this.model.connection;
    if (dropped !== this.droppedBefore && this.history.end > 0) this.ticksLeftOut += Math.max(0, tick - this.lastTick - 1);
    this.droppedBefore = dropped;
    return this.ticksLeftOut;
  }

  private takeBits(time: number, tick: number, word: number, written: number | undefined, ignored: number): void {
    const control = written ?? this.controlword ?? 0;
    const at = MEMBERS.length;
    this.sample[at] = control & CONTROL_BIT.newSetPoint ? 1 : 0;
    this.sample[at + 1] = word & STATUS_BIT.acknowledge ? 1 : 0;
    this.sample[at + 2] = word & STATUS_BIT.targetReached ? 1 : 0;
    const before = this.statusword;
    if (before !== undefined && before !== word) {
      const rose = word & ~before;
      if (rose & STATUS_BIT.acknowledge) this.note(time, "accepted");
      if (rose & STATUS_BIT.targetReached) this.note(time, "reached");
      const from = decodePowerState(before);
      const to = decodePowerState(word);
      if (from !== to) this.way = { from, to, transitions: wayBetween(from, to), tick };
    }
    if (this.ignored !== undefined && ignored > this.ignored) this.note(time, "ignored");
    this.ignored = ignored;
    this.statusword = word;
  }

  private note(time: number, kind: HandshakeMark["kind"]): void {
    this.marks.push({ time, kind });
    if (this.marks.length > MOST_MARKS) this.marks.shift();
  }

  private keepLast(message: Message, at: number): void {
    if (at < 0) return;
    for (const [name, column] of Object.entries(message)) {
      if (ArrayBuffer.isView(column)) this.last[name] = Number((column as NumberArray)[at]);
    }
  }

  /** The bench has started again, or went back to a snapshot. */
  private restart(): void {
    this.history.clear();
    this.marks.length = 0;
    this.originTick = undefined;
    this.statusword = undefined;
    this.ignored = undefined;
  }
}
