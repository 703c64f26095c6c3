// SPDX-License-Identifier: Apache-2.0
// The samples of one axis, every tick: received by its trace channel, or read from a recording.

import type { Message, NumberArray } from "../protocol/cdr";
import { History, type Kind } from "./history";
import type { Moment } from "./moments";
import { decodePowerState, STATUS_BIT, wayBetween, type PowerState } from "./power";
import { CONTROL_BIT, hasHandshake, HOMING, type HeldSetPoints } from "./setpoints";
import type { AxisUnit } from "./units";

export interface SampledAxis {
  /** such as "1.2" */
  address: string;
  bench: number;
  /** number on the bench */
  axis: number;
  name: string;
  unit: AxisUnit | undefined;
}

export interface Way {
  from: PowerState;
  to: PowerState;
  transitions: number[];
  tick: number;
}

/** An event of the set-point handshake. */
export interface HandshakeMark {
  /** [s] of drive time */
  time: number;
  kind: "accepted" | "ignored" | "reached";
}

/** The latest value read of 6040h, which no topic contains. */
export const CONTROLWORD = "ds402_controlword";
/** Bits that have their own series, because the extremes of a word are not those of its bits. */
const STATUS_BITS = { acknowledge: STATUS_BIT.acknowledge, reached: STATUS_BIT.targetReached } as const;
/** Members of a message that are not part of the status. */
const NOT_SAMPLED = new Set(["stamp", "axis", "missed", "tick", "owner_session"]);
const MOST_MARKS = 2_000;
/** Times of a history count from a full hour of drive time: its round times are then also round drive times. */
const ORIGIN_S = 3_600;

export interface Sampling {
  /** [s] of a tick */
  period: number;
  /** Ticks are published at equal intervals. */
  isRegular: boolean;
  /** [samples] */
  capacity: number;
  /** 6040h is read in addition to the messages. */
  hasControlword: boolean;
}

/** A larger ratio between the intervals of successive ticks means that ticks were skipped. In freerun, ticks are
 *  published by wall time, at any interval. */
const JUMP = 4;
const SHORTEST_JUMP_S = 0.1;

export class Samples {
  history = new History([], 0);
  readonly marks: HandshakeMark[] = [];
  /** changes of the power state, and faults */
  readonly moments: Moment[] = [];
  /** The newest value of each member of the status. */
  readonly last: Record<string, number> = {};
  lastTick = 0;
  /** ticks lost while messages were received */
  lost = 0;
  way?: Way;
  /** undefined before it has been read, or if it cannot be read */
  controlword?: number;
  /** As of the last controlword read; undefined without one, and if the drive takes no set-points. */
  setPoints?: HeldSetPoints;
  /** The tick in which home was last found, false if it is not found; undefined if the axis was not seen in homing
   *  mode: in other modes no object shows it. */
  homedAt?: number | false;
  /** the members of the status in the history, by index */
  members: string[] = [];
  private places = new Map<string, number>();
  private sample: number[] = [];
  private missedBefore?: number;
  private missedLast = 0;
  /** hour of drive time at time 0 of the history */
  private hour = 0;
  private originTick?: number;
  /** Messages were not received for a while. */
  private wasAway = false;
  private lostBefore = 0;
  private lostHere = 0;
  private step = 1;
  private errorCode?: number;
  private statusword?: number;
  private ignored?: number;

  constructor(
    readonly axis: SampledAxis,
    private readonly sampling: Sampling,
  ) {}

  get period(): number {
    return this.sampling.period;
  }

  /** @return the index of a member of the status, or of a bit of the handshake; undefined if there is none */
  series(name: string): number | undefined {
    return this.places.get(name);
  }

  /** @param time [s] of drive time */
  tickAt(time: number): number {
    return Math.round(time / this.period);
  }

  /** @return [s] of drive time */
  timeOf(tick: number): number {
    return tick * this.period;
  }

  /** Drive time at time 0 of the history [s] */
  get origin(): number {
    return this.hour * ORIGIN_S;
  }

  /** drive time of the oldest sample [s]; undefined if there is none */
  get begin(): number | undefined {
    return this.history.end === 0 ? undefined : this.origin + this.history.time(this.history.first);
  }

  /** drive time of the newest sample [s]; undefined if there is none */
  get end(): number | undefined {
    return this.history.end === 0 ? undefined : this.origin + this.history.time(this.history.end - 1);
  }

  /** No messages are received from now on, so a gap precedes the next sample. */
  protected leave(): void {
    this.wasAway = true;
  }

  /** @param message an array for each member, in successive ticks; `missed` counts those that did not arrive
   *  @param isCut the page itself has dropped messages before this one */
  take(message: Message, isCut = false): void {
    const ticks = message["tick"] as BigUint64Array;
    if (ticks.length === 0) return;
    if (this.members.length === 0) this.build(message);
    const columns = this.members.map((name) => message[name] as NumberArray | undefined);
    const column = (name: string) => columns[this.places.get(name) ?? -1];
    const words = column("ds402_statusword");
    const modes = column("op_mode_actual");
    const codes = column("error_code");
    const ignored = column("ignored_set_points");
    const missed = Number(message["missed"] as bigint);
    if (this.wasAway || missed < this.missedLast) this.resume(); // a restarted gateway counts from 0
    this.missedLast = missed;
    this.missedBefore ??= missed;
    if (isCut && this.history.end > 0) this.lostHere += Math.max(0, Number(ticks[0]) - this.lastTick - 1);
    const lost = this.lostBefore + Math.max(0, missed - this.missedBefore) + this.lostHere;
    if (lost > this.lost && this.history.end > 0) this.history.markGap();
    this.lost = lost;
    for (let i = 0; i < ticks.length; ++i) {
      const tick = Number(ticks[i]);
      if (tick <= this.lastTick && this.originTick !== undefined) this.restart();
      if (this.originTick !== undefined && this.isJump(tick)) this.history.markGap();
      this.originTick ??= this.originOf(tick);
      this.step = tick - this.lastTick;
      this.lastTick = tick;
      columns.forEach((values, at) => (this.sample[at] = Number(values?.[i] ?? 0)));
      this.takeBits(tick, Number(words?.[i] ?? 0), modes === undefined ? undefined : Number(modes[i]));
      this.takeIgnored(tick, Number(ignored?.[i] ?? 0));
      this.takeError(tick, Number(codes?.[i] ?? 0));
      this.history.append((tick - this.originTick) * this.period, this.sample);
    }
    this.members.forEach((name, at) => (this.last[name] = this.sample[at]));
  }

  /** The first message shows the members of the status and their types. */
  private build(message: Message): void {
    const columns = Object.entries(message).filter(([name, value]) => ArrayBuffer.isView(value) && !NOT_SAMPLED.has(name));
    this.members = columns.map(([name]) => name);
    const control: [string, Kind][] = this.sampling.hasControlword ? [[CONTROLWORD, Uint16Array], ["new_set_point", Uint8Array]] : [];
    const bits = Object.keys(STATUS_BITS).map((name): [string, Kind] => [name, Uint8Array]);
    const all = [...columns.map(([name, values]): [string, Kind] => [name, (values as object).constructor as Kind]), ...bits, ...control];
    this.places = new Map(all.map(([name], place) => [name, place]));
    this.history = new History(all.map(([, kind]) => kind), this.sampling.capacity);
  }

  private originOf(tick: number): number {
    this.hour = Math.floor((tick * this.period) / ORIGIN_S);
    return Math.round((this.hour * ORIGIN_S) / this.period);
  }

  private takeBits(tick: number, word: number, mode: number | undefined): void {
    let at = this.members.length;
    for (const bit of Object.values(STATUS_BITS)) this.sample[at++] = word & bit ? 1 : 0;
    this.sample[at++] = this.controlword ?? 0;
    this.sample[at++] = (this.controlword ?? 0) & CONTROL_BIT.newSetPoint ? 1 : 0;
    if (mode === HOMING) this.homedAt = word & STATUS_BIT.acknowledge ? this.homedAt || tick : false;
    const before = this.statusword;
    if (before !== undefined && before !== word) {
      const rose = word & ~before;
      if (rose & STATUS_BIT.acknowledge && hasHandshake(mode)) this.note(tick, "accepted");
      if (rose & STATUS_BIT.targetReached) this.note(tick, "reached");
      const from = decodePowerState(before);
      const to = decodePowerState(word);
      if (from !== to) {
        this.way = { from, to, transitions: wayBetween(from, to), tick };
        this.noteMoment({ tick, state: to });
      }
    }
    this.statusword = word;
  }

  private takeIgnored(tick: number, ignored: number): void {
    if (this.ignored !== undefined && ignored > this.ignored) this.note(tick, "ignored");
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
    return this.sampling.isRegular && step > JUMP * this.step && step * this.period >= SHORTEST_JUMP_S;
  }

  /** Messages arrive again after a pause. Ticks that the gateway missed during the pause do not count as lost, and
   *  changes during the pause must not be marked at this tick. */
  private resume(): void {
    this.wasAway = false;
    this.lostBefore = this.lost;
    this.missedBefore = undefined;
    this.lostHere = 0;
    this.statusword = undefined;
    this.ignored = undefined;
    this.errorCode = undefined;
    this.step = 1;
    if (this.history.end > 0) this.history.markGap();
  }

  private note(tick: number, kind: HandshakeMark["kind"]): void {
    this.marks.push({ time: this.timeOf(tick), kind });
    if (this.marks.length > MOST_MARKS) this.marks.shift();
  }

  /** The bench has been restarted, or set back to a snapshot. */
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
