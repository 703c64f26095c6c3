// SPDX-License-Identifier: Apache-2.0
// The motions that this page has started: the drives have accepted them, and the page follows them to their end.

import { Motion, type Cause, type Reading } from "./data/motions";
import { formatHex, formatUnits } from "./data/units";
import { modeName, stateName, t } from "./i18n";
import { addressOf, topicOf, type AxisRef, type Model } from "./model";
import type { Message } from "./protocol/cdr";

/** Services that start or continue a motion; they are answered once the drive has accepted it. */
export const STARTS_MOTION: ReadonlySet<string> = new Set(["/move", "/move_group", "/home", "/resume"]);
/** The most axes followed, of all commands: each costs a subscription. */
const MOST_FOLLOWED = 32;
const ASK_EVERY_MS = 200;
const OBJECTS = ["0x6040", "0x6061", "0x607A", "0x6064", "0x607B:01", "0x607B:02"];

/** A motion as text for the user. */
export interface MotionLine {
  text: string;
  kind: "moves" | "reached" | "ended";
}

/** The request of one of STARTS_MOTION. */
interface MotionRequest {
  axis?: string;
  axes?: string[];
  moves?: { axis: string; position: number }[];
  position?: number;
  relative?: boolean;
}

interface Followed {
  ref: AxisRef;
  motion: Motion;
  /** Ends its subscription. */
  close: () => void;
  askedAt: number;
}

export class Motions {
  /** by the addresses of their axes */
  private readonly followed = new Map<string, Followed>();

  constructor(private readonly model: Model) {}

  /** The drives have accepted the request. Motions that ended earlier are no longer shown. */
  async follow(request: object, owner: bigint): Promise<void> {
    const targets = this.targetsOf(request);
    for (const [address, { motion }] of this.followed) {
      if (motion.end !== undefined || targets.has(address)) this.forget(address);
    }
    for (const [address, target] of [...targets].slice(0, MOST_FOLLOWED)) {
      const ref = this.model.find(address);
      const reading = ref === undefined ? undefined : await this.read(ref);
      const motion = reading === undefined ? undefined : Motion.of(reading, owner, target);
      if (this.followed.size >= MOST_FOLLOWED) return; // another command may have added some while this one was reading
      if (ref !== undefined && motion !== undefined) this.open(ref, motion);
    }
  }

  /** @return the end positions of the axes in the request [UU]; undefined for a relative move, and for a resumed
   *          motion that others started: its 607Ah may be a distance */
  private targetsOf(request: object): Map<string, number | undefined> {
    const { axis, axes = [], moves = [], position, relative } = request as MotionRequest;
    const one: [string, number | undefined][] = axis === undefined ? [] : [[axis, relative === true ? undefined : position]];
    const resumed = axes.map((address) => [address, this.followed.get(address)?.motion.target] as const);
    return new Map([...one, ...resumed, ...moves.map((move) => [move.axis, move.position] as const)]);
  }

  /** The page has lost control or its connection, and will not learn how its motions end. */
  lose(): void {
    for (const { motion, close } of this.followed.values()) {
      motion.end ??= { kind: "lost" };
      close();
    }
  }

  /** A new run of the bench knows nothing of the motions; a separate line reports the restart. */
  forgetBench(number: number): void {
    for (const [address, { ref }] of this.followed) if (ref.bench.number === number) this.forget(address);
  }

  lines(): MotionLine[] {
    return [...this.followed.values()].map(({ ref, motion }) => this.line(ref, motion));
  }

  private open(ref: AxisRef, motion: Motion): void {
    const address = addressOf(ref);
    this.forget(address);
    const close = this.model.connection.subscribe(`${topicOf(ref)}/status`, (message) => this.take(address, message));
    this.followed.set(address, { ref, motion, close, askedAt: -Infinity });
  }

  private forget(address: string): void {
    this.followed.get(address)?.close();
    this.followed.delete(address);
  }

  private take(address: string, message: Message): void {
    const followed = this.followed.get(address);
    if (followed === undefined) return;
    const { motion } = followed;
    const number = (member: string) => Number(message[member]);
    motion.take({
      tick: number("tick"),
      owner: message["owner_session"] as bigint,
      statusword: number("ds402_statusword"),
      mode: number("op_mode_actual"),
      errorCode: number("error_code"),
      inputs: number("digital_inputs"),
      position: number("load_position_actual_value"),
      demand: number("position_demand_value"),
      velocity: number("velocity_demand_value"),
    });
    if (motion.end !== undefined) followed.close();
    else if (motion.mustAsk) void this.ask(followed);
  }

  private async ask(followed: Followed): Promise<void> {
    const now = performance.now();
    if (now - followed.askedAt < ASK_EVERY_MS) return;
    followed.askedAt = now;
    const reading = await this.read(followed.ref);
    if (reading === undefined) return;
    followed.motion.answer(reading);
    if (followed.motion.end !== undefined) followed.close();
  }

  private async read(ref: AxisRef): Promise<Reading | undefined> {
    const answer = await this.model.connection.call("/read", { axis: addressOf(ref), objects: OBJECTS });
    const values = (answer["values"] as { value?: number }[] | undefined)?.map(({ value }) => value);
    if (values === undefined || values.includes(undefined)) return undefined;
    const [controlword, mode, target, position, lower, upper] = values as number[];
    return { tick: Number(answer["tick"]), controlword, mode, target, position, span: upper - lower };
  }

  private line(ref: AxisRef, motion: Motion): MotionLine {
    const scale = this.model.scale(ref.axis);
    const units = (value: number) => `${formatUnits(value, scale)} ${scale.name}`;
    const { target, share, end } = motion;
    const what = motion.isHoming ? t("home") : target === undefined ? t("move") : `${t("move_to")} ${units(target)}`;
    const place = `${addressOf(ref)}: ${what}`;
    if (end === undefined) {
      const progress = share === undefined ? "" : `, ${Math.floor(share * 100)} %`;
      return { kind: "moves", text: `${place}: ${t("moves")}, ${units(motion.position)}${progress}` };
    }
    if (end.kind === "reached" || end.kind === "home_found") {
      return { kind: "reached", text: `${place}: ${t(end.kind)}, ${units(motion.position)}` };
    }
    return { kind: "ended", text: `${place}: ${t("ended_at")} ${units(motion.position)}: ${this.causeText(end, units)}` };
  }

  private causeText(end: Exclude<Cause, { kind: "reached" } | { kind: "home_found" }>, units: (value: number) => string): string {
    switch (end.kind) {
      case "fault":
        return `${t("fault")} ${formatHex(end.code)} ${this.model.errorName(end.code)}`;
      case "state":
        return stateName(end.state);
      case "mode":
        return `${t("mode")} ${modeName(end.mode)}`;
      case "set_point":
        return `${t("other_set_point")} ${units(end.target)}`;
      case "owner":
        return end.session === 0n ? t("taken_away") : `${t("now_by")} ${this.model.ownerName(end.session)}`;
      default:
        return t(`by_${end.kind}` as const);
    }
  }
}
