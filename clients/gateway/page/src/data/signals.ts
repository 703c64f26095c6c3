// SPDX-License-Identifier: Apache-2.0
// The quantities of the members of a status, from the objects of the same names in the dictionary.

import { suffixOf, type Scale, type Suffix } from "./units";

export interface ObjectUnit {
  name: string;
  title: string;
  title_zh: string;
  /** such as PosCU, "0.1 % of rated", "TqCU (mA)", - */
  unit: string;
}

export interface Quantity {
  /** the same for all signals that share a scale */
  kind: string;
  scale: Scale;
  /** of a position, velocity, acceleration or jerk */
  suffix?: Suffix;
  /** with its suffix, such as °/s; "" = none */
  unit: string;
  /** smallest height of a plot [unit of the drive] */
  least: number;
}

const PERMILLE: Scale = { name: "%", factor: 0.1, decimals: 1 };
/** [UU, UU/s, ...] by the suffix of the unit; smaller values are the ripple of a loop */
const LEAST = { "": 10, "/s": 200, "/s²": 200, "/s³": 200 } as const;
const LEAST_PERMILLE = 100;

/** @param object of the member; undefined if the member is not an object, such as a count
 *  @param position the scale of positions of the axis */
export function quantityOf(object: ObjectUnit | undefined, position: Scale): Quantity {
  const whole = object?.unit ?? "-";
  const unit = /\((.+)\)/.exec(whole)?.[1] ?? whole;
  const suffix = suffixOf(unit);
  if (suffix !== undefined) return { kind: `position${suffix}`, scale: position, suffix, unit: position.name + suffix, least: LEAST[suffix] };
  const [isRated, perSecond = ""] = /^(?:‰|0\.1 ?%)(\/s)?/.exec(unit) ?? [];
  if (isRated !== undefined) return { kind: `rated${perSecond}`, scale: PERMILLE, unit: PERMILLE.name + perSecond, least: LEAST_PERMILLE };
  const name = unit === "-" ? "" : unit;
  return { kind: unit === "-" ? (object?.name ?? "") : unit, scale: { name, factor: 1, decimals: 0 }, unit: name, least: 1 };
}

/** @return whether it is a demand value, which is drawn dashed */
export function isDemand(member: string): boolean {
  return member.includes("demand");
}
