// SPDX-License-Identifier: Apache-2.0
// A motion that this page has started, from the tick in which the drive accepted it to its end: what the status of its
// axis shows, and what must be read because the status does not show it.

import { decodePowerState, STATUS_BIT, type PowerState } from "./power";
import { CONTROL_BIT, HOMING, PROFILE_POSITION } from "./setpoints";

/** 60FDh */
export const INPUT_BIT = { negativeLimit: 1 << 0, positiveLimit: 1 << 1, home: 1 << 2 } as const;

/** Objects read in one tick after the drive has accepted the motion. */
export interface Reading {
  tick: number;
  /** 6040h */
  controlword: number;
  /** 6061h */
  mode: number;
  /** 607Ah [UU]; for a relative move a distance */
  target: number;
  /** 6064h [UU] */
  position: number;
  /** span of 607Bh [UU] */
  span: number;
}

/** The status of an axis after a tick. */
export interface MotionStatus {
  tick: number;
  /** session, 0 = nobody */
  owner: bigint;
  /** 6041h */
  statusword: number;
  /** 6061h */
  mode: number;
  /** 603Fh */
  errorCode: number;
  /** 60FDh */
  inputs: number;
  /** 6064h [UU] */
  position: number;
  /** 6062h [UU] */
  demand: number;
  /** 606Bh [UU/s] */
  velocity: number;
}

/** The cause of the end of a motion. */
export type Cause =
  | { kind: "reached" }
  | { kind: "home_found" }
  | { kind: "halt" | "software_limit" | "positive_limit" | "negative_limit" | "homing_error" | "interrupted" | "lost" }
  | { kind: "fault"; code: number }
  | { kind: "state"; state: PowerState }
  | { kind: "mode"; mode: number }
  | { kind: "set_point"; target: number }
  | { kind: "owner"; session: bigint };

const isAmong = (word: number, bit: number): boolean => (word & bit) !== 0;

export class Motion {
  /** [UU] */
  position: number;
  /** why it has ended; undefined while it continues */
  end?: Cause;
  /** Bit 10 is 1 and the status does not show why: the drive must be asked. */
  mustAsk = false;
  /** 6062h of the last status [UU] */
  private demand?: number;
  private blocked?: "positive_limit" | "negative_limit";

  /** @param target end position [UU]; undefined if unknown, as for a relative move
   *  @return the motion that the drive has accepted; undefined in a mode whose motions have no end */
  static of(reading: Reading, owner: bigint, target: number | undefined): Motion | undefined {
    return reading.mode === PROFILE_POSITION || reading.mode === HOMING ? new Motion(reading, owner, target) : undefined;
  }

  private constructor(
    private readonly start: Reading,
    private readonly owner: bigint,
    readonly target: number | undefined,
  ) {
    this.position = start.position;
  }

  get isHoming(): boolean {
    return this.start.mode === HOMING;
  }

  /** @return the share of the distance covered, 0 to 1; undefined if the target is unknown */
  get share(): number | undefined {
    if (this.target === undefined) return undefined;
    const way = this.target - this.start.position;
    return way === 0 ? 1 : Math.min(1, Math.max(0, (this.position - this.start.position) / way));
  }

  /** Ignores a status from before the drive accepted the motion: it belongs to an earlier motion. */
  take(status: MotionStatus): void {
    if (this.end !== undefined || status.tick < this.start.tick) return;
    this.position = status.position;
    this.demand = status.demand;
    this.end = this.isHoming ? this.endOfHoming(status) : this.endOfMove(status);
    this.end = this.endFromOutside(status) ?? this.end;
    this.mustAsk = this.end === undefined && isAmong(status.statusword, STATUS_BIT.targetReached);
  }

  /** Takes the drive's answer, read while bit 10 was 1. */
  answer(reading: Reading): void {
    if (this.end !== undefined || !this.mustAsk || reading.tick < this.start.tick) return;
    if (isAmong(reading.controlword, CONTROL_BIT.halt)) this.end = { kind: "halt" };
    else if (this.isHoming) this.end = { kind: "interrupted" };
    else if (reading.target !== this.start.target) this.end = { kind: "set_point", target: reading.target };
    else if (this.target === undefined || this.isThere(reading.span)) this.end = { kind: "reached" };
  }

  /** On a modulo axis, 6062h is the target wrapped into the range. */
  private isThere(span: number): boolean {
    return this.target !== undefined && this.demand !== undefined && span > 0 && (this.target - this.demand) % span === 0;
  }

  private endFromOutside({ owner, statusword, mode, errorCode }: MotionStatus): Cause | undefined {
    const state = decodePowerState(statusword);
    if (state === "fault" || state === "fault_reaction_active") return { kind: "fault", code: errorCode };
    if (state !== "operation_enabled") return { kind: "state", state };
    if (owner !== this.owner) return { kind: "owner", session: owner };
    return mode === this.start.mode ? undefined : { kind: "mode", mode };
  }

  private endOfHoming({ statusword }: MotionStatus): Cause | undefined {
    if (isAmong(statusword, STATUS_BIT.modeError)) return { kind: "homing_error" };
    const attained = STATUS_BIT.targetReached | STATUS_BIT.acknowledge;
    return (statusword & attained) === attained ? { kind: "home_found" } : undefined;
  }

  /** As in the client library: a limit switch in the way ends the motion for good, even if it opens again. */
  private endOfMove({ statusword, inputs, demand, velocity }: MotionStatus): Cause | undefined {
    const way = this.target === undefined ? velocity : this.target - demand;
    if (way > 0 && isAmong(inputs, INPUT_BIT.positiveLimit)) this.blocked = "positive_limit";
    if (way < 0 && isAmong(inputs, INPUT_BIT.negativeLimit)) this.blocked = "negative_limit";
    const isReached = isAmong(statusword, STATUS_BIT.targetReached);
    if (isReached && demand === this.target) return { kind: "reached" };
    if (velocity !== 0) return undefined;
    if (this.blocked !== undefined) return { kind: this.blocked };
    return isReached && isAmong(statusword, STATUS_BIT.internalLimit) ? { kind: "software_limit" } : undefined;
  }
}
