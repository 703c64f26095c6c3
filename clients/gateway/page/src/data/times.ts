// SPDX-License-Identifier: Apache-2.0
// Drive time for display: a bench in real time counts from 1970, so its times are times of day; others count from 0.

import { formatNumber } from "./units";

const FIRST_WALL_TIME_S = 1e9;
const MICROSECONDS = 1e6;

export function isWallTime(seconds: number): boolean {
  return seconds >= FIRST_WALL_TIME_S;
}

function two(value: number): string {
  return String(value).padStart(2, "0");
}

/** @param seconds of drive time
 *  @return such as 14:03:27.250 in the time zone of the browser, or 12.250 */
export function formatTime(seconds: number, decimals: number): string {
  if (!isWallTime(seconds)) return formatNumber(seconds, decimals);
  const scale = 10 ** decimals;
  // Rounded first: 59.9996 must not become 60.
  const rounded = Math.round(seconds * scale);
  const date = new Date(Math.floor(rounded / scale) * 1000);
  const fraction = decimals === 0 ? "" : `.${String(rounded % scale).padStart(decimals, "0")}`;
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}${fraction}`;
}

/** @return the same as a stand-alone text, with its unit if it has one. */
export function timeText(seconds: number): string {
  return formatTime(seconds, 3) + (isWallTime(seconds) ? "" : " s");
}

/** @return the date of a drive time as ISO 8601 in UTC with microseconds; "" if the drive time has no date. */
export function isoDate(seconds: number): string {
  if (!isWallTime(seconds)) return "";
  const microseconds = Math.round(seconds * MICROSECONDS);
  const whole = new Date(Math.floor(microseconds / MICROSECONDS) * 1000).toISOString().slice(0, -".000Z".length);
  return `${whole}.${String(microseconds % MICROSECONDS).padStart(6, "0")}Z`;
}
