// SPDX-License-Identifier: Apache-2.0
// The number of set-points that a drive in profile position mode holds, as far as controlword and statusword show it.

import { decodePowerState, STATUS_BIT } from "./power";

/** 6061h */
export const PROFILE_POSITION = 1;
export const HOMING = 6;

export const CONTROL_BIT = {
  newSetPoint: 1 << 4,
  changeSetImmediately: 1 << 5,
  halt: 1 << 8,
} as const;

/** @return whether bit 4 is a new set-point and bit 12 its acknowledge; also true before 6061h is known. */
export function hasHandshake(mode: number | undefined): boolean {
  return mode === undefined || mode === PROFILE_POSITION;
}

/** Bits 13, 12 and 10 of the statusword in homing mode (CiA 402-2). */
export type HomingState = "runs" | "stands" | "attained" | "done" | "error_moves" | "error_stands";

/** @param status 6041h in homing mode */
export function homingState(status: number): HomingState {
  const isReached = (status & STATUS_BIT.targetReached) !== 0;
  if ((status & STATUS_BIT.modeError) !== 0) return isReached ? "error_stands" : "error_moves";
  if ((status & STATUS_BIT.acknowledge) !== 0) return isReached ? "done" : "attained";
  return isReached ? "stands" : "runs";
}

export interface HeldSetPoints {
  /** 1 while the drive moves to a target */
  active: 0 | 1;
  /** 1 while another one waits for it to finish; undefined if unknown */
  waiting: 0 | 1 | undefined;
}

/**
 * @param control 6040h
 * @param status 6041h after the same tick
 * @param mode 6061h
 * @return undefined in modes other than profile position, in states other than Operation enabled, and under halt,
 *         where bit 10 means standstill
 *
 * Bit 12 stays 1 while a set-point waits. It also stays 1 while bit 4 is 1: then the statusword does not show whether
 * the set-point taken last waits or is already being executed. If bit 5 is 1, it does not have to wait.
 */
export function heldSetPoints(control: number, status: number, mode: number): HeldSetPoints | undefined {
  if (mode !== PROFILE_POSITION || decodePowerState(status) !== "operation_enabled") return undefined;
  if ((control & CONTROL_BIT.halt) !== 0) return undefined;
  if ((status & STATUS_BIT.targetReached) !== 0) return { active: 0, waiting: 0 };
  if ((status & STATUS_BIT.acknowledge) === 0) return { active: 1, waiting: 0 };
  if ((control & CONTROL_BIT.newSetPoint) === 0) return { active: 1, waiting: 1 };
  return { active: 1, waiting: (control & CONTROL_BIT.changeSetImmediately) !== 0 ? 0 : undefined };
}
