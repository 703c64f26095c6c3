// SPDX-License-Identifier: Apache-2.0
// The history of one axis, filled by its trace channel: every tick.

import { History } from "./data/history";
import type { Moment } from "./data/moments";
import { decodePowerState, STATUS_BIT, wayBetween, type PowerState } from "./data/power";
import { CONTROL_BIT, hasHandshake, HOMING, heldSetPoints, type HeldSetPoints } from "./data/setpoints";
import { addressOf, topicOf, type AxisRef, type Model } from "./model";
import type { Message, NumberArray } from "./protocol/cdr";

/** Members of the status that are kept, with their units; then three bits as 0 or 1. */
export const MEMBERS = [
  { name: "position_demand_value", unit: "UU" },
  { name: "load_position_actual_value", unit: "UU" },
  { name: "velocity_demand_value", unit: "UU/s" },
  { name: "load_velocity_actual_value", unit: "UU/s" },
  { name: "motor_velocity_actual_value", unit: "UU/s" },
  { name: "load_position_error_value", unit: "UU" },
  { name: "torque_demand", unit: "permille of rated torque" },
  { name: "torque_actual_value", unit: "permille of rated torque" },
  { name: "current_actual_value", unit: "permille of rated current" },
  { name: "ds402_statusword", unit: "" },
  { name: "error_code", unit: "" },
] as const;
export type Series = (typeof MEMBERS)[number]["name"] | "new_set_point" | "acknowledge" | "reached";
export const SERIES: readonly Series[] = [...MEMBERS.map(({ name }) => name), "new_set_point", "acknowledge", "reached"];

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
/** Times of a history count from a whole hour of drive time: round ones stay round. */
const ORIGIN_S = 3_600;
/** Ticks that follow each other in so different distances were jumped over. In freerun they are
 *  published by wall time, in any distance. */
const JUMP = 4;
const SHORTEST_JUMP_S = 0.1;

export class Trace {
  readonly history: History;
  readonly marks: HandshakeMark[] = [];
  /** changes of the power state, and faults */
  readonly moments: Moment[] = [];
  /** The newest value of each member of the status. */
  readonly last: Record<string, number> = {};
  owner = 0n;
  lastTick = 0;
  /** ticks lost while messages were received */
  lost = 0;
  way?: Way;
  /** 6040h as it was read last; undefined before that or when it cannot be read. */
  controlword?: number;
  /** When 6040h was read last; undefined as that, and where the drive takes no set-points. */
  setPoints?: HeldSetPoints;
  /** The tick in which home was found last, false while it is not found; undefined where the axis was not seen in
   *  homing mode: in others no object shows it. */
  homedAt?: number | false;
  private reading = false;
  private missedBefore?: number;
  private missedLast = 0;
  private droppedBefore = 0;
  private ticksLeftOut = 0;
  private originTick?: number;
  /** [s] of a tick */
  readonly period: number;
  private ends: (() => void)[] = [];
  private timer = 0;
  /** Messages were not received meanwhile. */
  private wasAway = false;
  private lostBefore = 0;
  private step = 1;
  private errorCode?: number;
  private readonly sample = new Array<number>(SERIES.length).fill(0);
  private statusword?: number;
  private ignored?: number;

  constructor(
    private readonly model: Model,
    readonly ref: AxisRef,
  ) {
    this.period = (ref.bench.description?.period_us ?? 1000) * 1e-6;
    this.history = new History(SERIES.length, Math.min(MOST_SAMPLES, LONGEST_WINDOW_S / this.period));
  }

  /** Receives from now on. What was received before stays, with a gap behind it. */
  open(): void {
    if (this.ends.length > 0) return;
    const topic = topicOf(this.ref);
    this.ends = [
      this.model.connection.subscribe(`${topic}/trace`, (message) => this.take(message)),
      this.model.connection.subscribe(`${topic}/status`, (message) => {
        this.owner = message["owner_session"] as bigint;
      }),
    ];
  }

  /** Receives no more. */
  close(): void {
    this.show(false);
    for (const end of this.ends) end();
    this.ends = [];
    this.wasAway = true;
  }

  /** While a view shows it the controlword is read, which no topic has. */
  show(on: boolean): void {
    window.clearInterval(this.timer);
    if (!on) return;
    this.timer = window.setInterval(() => void this.readControlword(), CONTROLWORD_EVERY_MS);
    void this.readControlword();
  }

  /** @return the tick of a time of the history. */
  tickAt(time: number): number {
    return (this.originTick ?? 0) + Math.round(time / this.period);
  }

  /** @return the time of a tick in the history; nothing before the first message. */
  timeOf(tick: number): number | undefined {
    return this.originTick === undefined ? undefined : (tick - this.originTick) * this.period;
  }

  /** @return the drive time of a time of the history [s] */
  driveTime(time: number): number {
    return (this.originTick ?? 0) * this.period + time;
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
    const columns = MEMBERS.map(({ name }) => message[name] as NumberArray | undefined);
    const words = message["ds402_statusword"] as Uint16Array;
    const modes = message["op_mode_actual"] as Int8Array | undefined;
    const codes = message["error_code"] as Uint16Array | undefined;
    const ignored = message["ignored_set_points"] as Uint32Array | undefined;
    const written = message["ds402_controlword"] as Uint16Array | undefined;
    const missed = Number(message["missed"] as bigint);
    if (this.wasAway || missed < this.missedLast) this.resume(); // another gateway counts anew
    this.missedLast = missed;
    this.missedBefore ??= missed;
    const lost = this.lostBefore + Math.max(0, missed - this.missedBefore) + this.leftOut(Number(ticks[0]));
    if (lost > this.lost && this.history.end > 0) this.history.markGap();
    this.lost = lost;
    for (let i = 0; i < ticks.length; ++i) {
      const tick = Number(ticks[i]);
      if (tick <= this.lastTick && this.originTick !== undefined) this.restart();
      if (this.originTick !== undefined && this.isJump(tick)) this.history.markGap();
      this.originTick ??= Math.round((Math.floor((tick * this.period) / ORIGIN_S) * ORIGIN_S) / this.period);
      this.step = tick - this.lastTick;
      this.lastTick = tick;
      columns.forEach((column, at) => (this.sample[at] = Number(column?.[i] ?? 0)));
      const time = (tick - this.originTick) * this.period;
      this.takeBits(time, tick, words[i], written?.[i], modes?.[i]);
      this.takeIgnored(time, ignored?.[i] ?? 0);
      this.takeError(tick, Number(codes?.[i] ?? 0));
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

  private takeBits(time: number, tick: number, word: number, written: number | undefined, mode: number | undefined): void {
    const control = written ?? this.controlword ?? 0;
    const at = MEMBERS.length;
    this.sample[at] = control & CONTROL_BIT.newSetPoint ? 1 : 0;
    this.sample[at + 1] = word & STATUS_BIT.acknowledge ? 1 : 0;
    this.sample[at + 2] = word & STATUS_BIT.targetReached ? 1 : 0;
    if (mode === HOMING) this.homedAt = word & STATUS_BIT.acknowledge ? this.homedAt || tick : false;
    const before = this.statusword;
    if (before !== undefined && before !== word) {
      const rose = word & ~before;
      if (rose & STATUS_BIT.acknowledge && hasHandshake(mode)) this.note(time, "accepted");
      if (rose & STATUS_BIT.targetReached) this.note(time, "reached");
      const from = decodePowerState(before);
      const to = decodePowerState(word);
      if (from !== to) {
        this.way = { from, to, transitions: wayBetween(from, to), tick };
        this.noteMoment({ tick, state: to });
      }
    }
    this.statusword = word;
  }

  private takeIgnored(time: number, ignored: number): void {
    if (this.ignored !== undefined && ignored > this.ignored) this.note(time, "ignored");
    this.ignored = ignored;
  }

  private takeError(tick: number, code: number): void {
    if (this.errorCode !== undefined && code !== 0 && code !== this.errorCode) this.noteMoment({ tick, code });
    this.errorCode = code;
  }

  private noteMoment(moment: Moment): void {
    this.moments.push(moment);
    if (this.moments.length > MOST_MARKS) this.moments.shift();
  }

  private isJump(tick: number): boolean {
    const step = tick - this.lastTick;
    const isRegular = this.ref.bench.description?.clock_mode !== "freerun";
    return isRegular && step > JUMP * this.step && step * this.period >= SHORTEST_JUMP_S;
  }

  /** The gateway counts missed ticks of its own stream: those of the meantime were not wanted. What
   *  changed then did not change in this tick. */
  private resume(): void {
    this.wasAway = false;
    this.lostBefore = this.lost;
    this.missedBefore = undefined;
    this.ticksLeftOut = 0;
    this.statusword = undefined;
    this.ignored = undefined;
    this.errorCode = undefined;
    this.step = 1;
    if (this.history.end > 0) this.history.markGap();
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
    this.moments.length = 0;
    this.errorCode = undefined;
    this.originTick = undefined;
    this.statusword = undefined;
    this.ignored = undefined;
    this.homedAt = undefined;
  }
}
