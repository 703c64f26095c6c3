// SPDX-License-Identifier: Apache-2.0
// Whether a drive moves its axis, from one status.

import { decodePowerState } from "./power";

export interface Demand {
  /** 6041h */
  statusword: number;
  /** 606Bh */
  velocity: number;
  /** 6074h */
  torque: number;
}

/** @param commandsTorque the mode commands a torque, so that an axis may apply one at standstill
 *  @return whether the drive moves its axis or applies a commanded torque. */
export function movesOrPresses({ statusword, velocity, torque }: Demand, commandsTorque: boolean): boolean {
  const presses = commandsTorque && torque !== 0 && decodePowerState(statusword) === "operation_enabled";
  return velocity !== 0 || presses;
}
