// SPDX-License-Identifier: Apache-2.0
// User units of a drive (UU), and engineering units.

export interface AxisUnit {
  /** rotary or linear */
  kind: string;
  name: string;
  /** [UU] per revolution (rotary) or per unit (linear) */
  per: number;
}

/** How positions of an axis are shown: one UU is `factor` units. */
export interface Scale {
  name: string;
  factor: number;
  decimals: number;
}

export const USER_UNITS: Scale = { name: "UU", factor: 1, decimals: 0 };

const PER_REVOLUTION: Record<string, number> = { deg: 360, rad: 2 * Math.PI, rev: 1 };
const MOST_DECIMALS = 6;

/** @return the scale of `unit`, with as many decimals as one UU needs. */
export function scaleOf(unit: AxisUnit | undefined): Scale {
  if (unit === undefined || !(unit.per > 0)) return USER_UNITS;
  const amount = unit.kind === "rotary" ? PER_REVOLUTION[unit.name] : 1;
  if (amount === undefined) return USER_UNITS;
  const factor = amount / unit.per;
  const decimals = Math.min(MOST_DECIMALS, Math.max(0, Math.ceil(-Math.log10(factor))));
  return { name: unit.name === "deg" ? "°" : unit.name, factor, decimals };
}

export function toShown(userUnits: number, scale: Scale): number {
  return userUnits * scale.factor;
}

/** @return the nearest integer number of user units. */
export function toUserUnits(shown: number, scale: Scale): number {
  const userUnits = shown / scale.factor;
  return Math.sign(userUnits) * Math.round(Math.abs(userUnits));
}

/** The suffix after the unit of a position: for a velocity, an acceleration and a jerk. */
export type Suffix = "" | "/s" | "/s²" | "/s³";

const ENDINGS: Record<Suffix, RegExp> = {
  "": /$/,
  "/s": /\s*\/\s*s$/,
  "/s²": /\s*\/\s*s(²|\^?2)$/,
  "/s³": /\s*\/\s*s(³|\^?3)$/,
};

/** @param units of the dictionary: PosUU, PosCU, p, VelUU, ...
 *  @return undefined for an object that is not a position, velocity, acceleration or jerk */
export function suffixOf(units: string): Suffix | undefined {
  if (units === "p" || units.startsWith("Pos")) return "";
  if (units.startsWith("Vel")) return "/s";
  if (units.startsWith("Acc")) return "/s²";
  return units.startsWith("Jerk") ? "/s³" : undefined;
}

/** A typed value with its unit. */
export interface Quantity {
  value: number;
  scale: Scale;
}

/** @return the scale of a unit that may be typed for an axis of `unit`. */
function scaleNamed(name: string, unit: AxisUnit | undefined): Scale | undefined {
  if (name.toLowerCase() === "uu") return USER_UNITS;
  if (unit === undefined) return undefined;
  const wanted = name === "°" ? "deg" : name;
  const scale = unit.kind === "rotary" || wanted === unit.name ? scaleOf({ ...unit, name: wanted }) : USER_UNITS;
  return scale === USER_UNITS ? undefined : scale;
}

/** Why a text is not a quantity, and the allowed units. */
export interface Unreadable {
  why: "not_a_number" | "ambiguous_comma" | "no_such_unit";
  units: string[];
}

/** @return the units that may be typed, as they are written. */
function unitsOf(unit: AxisUnit | undefined, suffix: Suffix): string[] {
  const own = unit === undefined || scaleOf(unit) === USER_UNITS ? [] : unit.kind === "rotary" ? Object.keys(PER_REVOLUTION) : [unit.name];
  return [...own, USER_UNITS.name].map((name) => name + suffix);
}

/** @param text a number in the unit of `scale`, or with a unit of the axis: 90deg, 1,5 mm, 12mm/s
 *  @param suffix that a unit must have: a velocity is not a position */
export function parseQuantity(text: string, scale: Scale, unit: AxisUnit | undefined, suffix: Suffix = ""): Quantity | Unreadable {
  const bare = parseNumber(text);
  if (bare !== undefined) return { value: bare, scale };
  const [, number = "", whole = ""] = /^(.*?\d[.,]?)\s*([\p{L}°%]+(?:\s*\/.*)?)$/u.exec(text.trim()) ?? [];
  const value = parseNumber(number);
  if (value === undefined) return { why: whyNoNumber(whole === "" ? text : number), units: [] };
  const named = ENDINGS[suffix].test(whole) ? scaleNamed(whole.replace(ENDINGS[suffix], ""), unit) : undefined;
  return named === undefined ? { why: "no_such_unit", units: unitsOf(unit, suffix) } : { value, scale: named };
}

/** @return the nearest user units of a value with a unit; undefined for a fraction of a plain user unit. */
export function wholeUserUnits({ value, scale }: Quantity): number | undefined {
  if (scale === USER_UNITS && !Number.isInteger(value)) return undefined;
  return toUserUnits(value, scale);
}

/** @return a text typed for one scale, converted to another. */
export function retyped(text: string, from: Scale, to: Scale): string {
  const value = parseNumber(text);
  const same = from.name === to.name && from.factor === to.factor;
  if (value === undefined || same) return text; // a text with its own unit remains unchanged
  return String(Number((value * (to.factor / from.factor)).toFixed(to.decimals)));
}

const NARROW_SPACE = "\u202f";
const MINUS = "\u2212";

/** @return the number with groups of three digits and a true minus sign, so that digits of equal width are aligned. */
export function formatNumber(value: number, decimals: number): string {
  if (!Number.isFinite(value)) return "–";
  const text = Math.abs(value).toFixed(decimals);
  const [whole, fraction] = text.split(".");
  const grouped = whole.replace(/\B(?=(\d{3})+(?!\d))/g, NARROW_SPACE);
  const negative = value < 0 && Number(text) !== 0;
  return (negative ? MINUS : "") + grouped + (fraction === undefined ? "" : "." + fraction);
}

export function formatUnits(userUnits: number, scale: Scale): string {
  return formatNumber(userUnits * scale.factor, scale.decimals);
}

/** Permille of the rated value as per cent. */
export function formatPermille(value: number): string {
  return formatNumber(value / 10, 1);
}

export function formatHex(value: number, digits = 4): string {
  return value.toString(16).toUpperCase().padStart(digits, "0") + "h";
}

/** 1,500 may mean 1.5 or 1500, and a drive moves even if it is given the wrong one. */
const AMBIGUOUS_COMMA = /^-?[1-9]\d{0,2},\d{3}$/;

function cleaned(text: string): string {
  return text.replace(/[\s\u202f\u00a0_]/g, "").replace(MINUS, "-");
}

/** @return why parseNumber rejects a text. */
export function whyNoNumber(text: string): "not_a_number" | "ambiguous_comma" {
  return AMBIGUOUS_COMMA.test(cleaned(text)) ? "ambiguous_comma" : "not_a_number";
}

/** @param text decimal with a point or a comma and either minus sign, spaces allowed, or 0x...
 *  @return the number, or undefined if the text is not a number. */
export function parseNumber(text: string): number | undefined {
  const clean = cleaned(text);
  if (clean === "" || AMBIGUOUS_COMMA.test(clean)) return undefined;
  const value = Number(clean.includes(".") ? clean : clean.replace(",", "."));
  return Number.isFinite(value) ? value : undefined;
}

/** @return a time that does not flicker: tenths of a second below 10 s. */
export function formatAge(milliseconds: number): string {
  if (!Number.isFinite(milliseconds)) return "–";
  if (milliseconds < 100) return "<0.1 s";
  const seconds = milliseconds / 1000;
  if (seconds < 10) return `${seconds.toFixed(1)} s`;
  if (seconds < 120) return `${seconds.toFixed(0)} s`;
  return `${(seconds / 60).toFixed(0)} min`;
}
