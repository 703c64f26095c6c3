// SPDX-License-Identifier: Apache-2.0
// The data that the gateway sends about benches and axes, and the choices made in this browser.

import { browserOf } from "./data/browser";
import { EVENT_HISTORY, EventList } from "./data/events";
import { movesOrPresses } from "./data/motion";
import { BENCH_DESCRIPTION, BENCH_STATE, CONTROL, DICTIONARY } from "./data/tables";
import type { AxisUnit, Scale } from "./data/units";
import { formatUnits, scaleOf, USER_UNITS } from "./data/units";
import { language, modeName, serviceName, t, type Language } from "./i18n";
import { Motions, STARTS_MOTION } from "./motions";
import type { Message, NumberArray } from "./protocol/cdr";
import { checked, type Of } from "./protocol/checked";
import { Connection, type Answer, type ServerStatus } from "./protocol/connection";
import { LONGEST_SILENCE_MS } from "./protocol/silence";

export type BenchDescription = Of<typeof BENCH_DESCRIPTION>;
/** `topic` is the name used in topics. */
export type AxisDescription = BenchDescription["axes"][number];
export type BenchState = Of<typeof BENCH_STATE>;
/** The holder of control through the gateway; `you` is true if it is this page. */
export type ControlState = Of<typeof CONTROL>;
export type Dictionary = Of<typeof DICTIONARY>;
export type ObjectRow = Dictionary["objects"][number];
export type Disturbance = Dictionary["disturbances"][number];

/** Number of positions, from the last 10 s, that the overview keeps for each axis. */
export const TREND_LENGTH = 100;
const TREND_EVERY_MS = 100;
/** of all benches; the gateway keeps 1,024 of each */
const MOST_EVENTS = 4_096;
const MOST_NOTES = 4;
const MOST_NOTICES = 5;
const MOST_NAMES = 1_000;
const MOST_LISTED = 4;
/** The status of a bench with at most this many axes costs next to nothing. */
const SMALL_BENCH = 256;
const SILENT_FROM_MS = 1_000;
const GONE_FROM_MS = 3_000;
/** The choices for how long the page may be silent while it holds control [s]. Hidden tabs may freeze for some
 *  seconds, so the longest one is the default. */
export const SILENCES_S = [1, 2, 3, 5, 10];

/** A second press of the same control with the same values within this time is a double click. */
export const SECOND_PRESS_MS = 500;
/** Stops, and jogs, which move only while a button is held: never treated as a double click. */
const NEVER_LEFT_OUT: ReadonlySet<string> = new Set(["/quick_stop", "/halt", "/jog"]);
/** Services that are answered while the axis is still braking. */
const STOPS_MOTION: ReadonlySet<string> = new Set(["/quick_stop", "/halt"]);

/** @return the axes that a request addresses. */
function addressesIn(request: object): string[] {
  const { axis, axes = [], moves = [] } = request as { axis?: string; axes?: string[]; moves?: { axis: string }[] };
  return [...(axis === undefined ? [] : [axis]), ...axes, ...moves.map((move) => move.axis)];
}

export function listed(addresses: string[]): string {
  return addresses.slice(0, MOST_LISTED).join(", ") + (addresses.length > MOST_LISTED ? `, … (${addresses.length})` : "");
}

function timeOfDay(date = new Date()): string {
  return date.toLocaleTimeString(language() === "zh" ? "zh-CN" : "en-GB", { hour: "2-digit", minute: "2-digit" });
}

const NOT_SENT: Answer = { ok: false, outcome: "", message: "", code: 0 };

interface Press {
  values: string;
  /** [ms] */
  at: number;
}

/** @param text as written by the gateway */
const sessionOf = (text: string): bigint => BigInt(`0x${text.replace(/^0x/, "")}`);

/** A bench with the newest status of all its axes: for each member of the status, by its name in the core, an array
 *  with one value per axis. */
export class Bench {
  private described?: BenchDescription;
  private readonly axes = new Map<number, AxisDescription>();
  state?: BenchState;
  stateAt = 0;
  frame?: Message;
  frameAt = 0;
  tick = 0;
  /** axis number -> index in the arrays of the frame */
  readonly places = new Map<number, number>();
  trend = new Float32Array(0);
  trendHead = 0;
  trendCount = 0;
  private trendAt = 0;

  constructor(
    readonly number: number,
    readonly topic: string,
  ) {}

  get description(): BenchDescription | undefined {
    return this.described;
  }

  set description(description: BenchDescription | undefined) {
    this.described = description;
    this.axes.clear();
    for (const axis of description?.axes ?? []) this.axes.set(axis.axis, axis);
  }

  /** @param number of the axis on this bench */
  axis(number: number): AxisDescription | undefined {
    return this.axes.get(number);
  }

  take(frame: Message): void {
    const axes = frame["axis"] as Uint16Array;
    if (this.places.size !== axes.length || this.frame === undefined) {
      this.places.clear();
      axes.forEach((axis, place) => this.places.set(axis, place));
      this.trend = new Float32Array(axes.length * TREND_LENGTH);
      this.trendCount = 0;
    }
    this.frame = frame;
    this.frameAt = performance.now();
    this.tick = Number(frame["tick"] as bigint);
    if (this.frameAt - this.trendAt >= TREND_EVERY_MS) this.keepTrend(frame);
  }

  /** @return the values of that member, or undefined if the status has no such member. */
  numbers(member: string): NumberArray | undefined {
    return this.frame?.[member] as NumberArray | undefined;
  }

  private keepTrend(frame: Message): void {
    this.trendAt = this.frameAt;
    const positions = frame["load_position_actual_value"] as Int32Array;
    this.trendHead = (this.trendHead + 1) % TREND_LENGTH;
    this.trendCount = Math.min(TREND_LENGTH, this.trendCount + 1);
    for (let i = 0; i < positions.length; ++i) {
      this.trend[i * TREND_LENGTH + this.trendHead] = positions[i];
    }
  }
}

/** Refers to an axis by its numbers: bench and description are looked up each time, because a restarted gateway or
 *  service brings new ones. While the axis is missing, its last bench and description are kept. */
export class AxisRef {
  constructor(
    private readonly benches: ReadonlyMap<number, Bench>,
    private lastBench: Bench,
    private lastAxis: AxisDescription,
  ) {}

  get bench(): Bench {
    this.lookUp();
    return this.lastBench;
  }

  get axis(): AxisDescription {
    this.lookUp();
    return this.lastAxis;
  }

  private lookUp(): void {
    const bench = this.benches.get(this.lastBench.number);
    const axis = bench?.axis(this.lastAxis.axis);
    if (bench === undefined || axis === undefined) return;
    this.lastBench = bench;
    this.lastAxis = axis;
  }
}

export function addressOf(ref: AxisRef): string {
  return `${ref.bench.number}.${ref.axis.axis}`;
}

export function topicOf(ref: AxisRef): string {
  return `${ref.bench.topic}/${ref.axis.topic}`;
}

export type Theme = "auto" | "light" | "dark";

export interface Settings {
  language: Language;
  theme: Theme;
  axisUnits: boolean;
  window: number;
  /** shown on plots */
  marks: boolean;
  /** see SILENCES_S */
  silence: number;
}

const SETTINGS_KEY = "vdrive";
const DEFAULTS: Settings = {
  language: navigator.language.startsWith("zh") ? "zh" : "en",
  theme: "auto",
  axisUnits: false,
  window: 10,
  marks: true,
  silence: LONGEST_SILENCE_MS / 1000,
};

function loadSettings(): Settings {
  try {
    const kept = JSON.parse(localStorage.getItem(SETTINGS_KEY) ?? "{}") as Partial<Settings>;
    const settings = { ...DEFAULTS, ...kept };
    if (!SILENCES_S.includes(settings.silence)) settings.silence = DEFAULTS.silence;
    return settings;
  } catch {
    return { ...DEFAULTS };
  }
}

/** The text typed into a field, which outlives the view of the field. */
export interface Typed {
  text: string;
  /** scale of the unit shown when it was typed */
  scale: Scale;
}

/** A line about an event, and the action of its button. */
export interface Notice {
  text: string;
  button: string;
  press: () => void;
}

/** Moving axes, by their addresses. */
export interface Moving {
  /** controlled by this page */
  own: string[];
  /** controlled by another client, which holds control */
  holders: string[];
  /** controlled by nobody */
  free: string[];
}

/** The result of a command, for the line below the controls. */
export interface Outcome {
  text: string;
  ok: boolean;
  /** The drive has accepted it and is executing it. */
  isUnderWay?: boolean;
}

export class Model {
  readonly connection: Connection;
  readonly benches = new Map<number, Bench>();
  readonly settings = loadSettings();
  readonly chosen = new Set<string>();
  readonly events = new EventList(MOST_EVENTS);
  connected = false;
  server = "";
  control: ControlState = { enabled: false, holder: "", you: false, name: "", session: "", taken_at_ns: "0", silence_ms: 0 };
  dictionary?: Dictionary;
  outcome?: Outcome;
  /** the network problem that keeps the gateway from finding benches; "" = none */
  networkTrouble = "";
  readonly motions = new Motions(this);
  /** by the name of the field, such as "move 1.1 target" */
  readonly typed = new Map<string, Typed>();
  readonly ticked = new Map<string, boolean>();
  /** chosen homing methods, by the addresses of the axes */
  readonly homing = new Map<string, string>();
  /** Increases when benches, axes, control or the dictionary change: views are then rebuilt. */
  version = 0;
  /** A moment that the user wants to see, for the view of the axis. */
  wantedMoment?: { address: string; tick: number };
  /** benches whose earlier events were requested on this connection */
  private readonly askedEvents = new Set<number>();
  /** Resolves after the last call of /events. */
  private askingEvents: Promise<void> = Promise.resolve();
  private statusWanted = false;
  private readonly ends = new Map<string, () => void>();
  private readonly incarnations = new Map<number, string>();
  /** axes that this page controls, and the newest tick in which it did */
  private readonly owned = new Map<string, number>();
  /** axes that this page controlled until another session took them, with the tick; the user must take them back
   *  explicitly */
  private readonly taken = new Map<string, number>();
  /** when the last of them was taken, and by which session */
  private takenAt = "";
  private takenBy = 0n;
  /** names of programs, by their sessions as the gateway writes them */
  private readonly sessionNames = new Map<string, string>();
  /** news that the user may have missed */
  private readonly notes: string[] = [];
  private readonly presses = new Map<string, Press>();

  constructor(url: string) {
    this.connection = new Connection(url, {
      connected: (info) => {
        this.connected = true;
        this.server = `${info.name} ${info.metadata?.["version"] ?? ""}`.trim();
        this.changed();
      },
      disconnected: () => {
        this.connected = false;
        if (this.control.you) this.outcome = { ok: false, text: t("control_lost") };
        this.control = { ...this.control, holder: "", you: false };
        this.forgetOwned();
        this.askedEvents.clear(); // requested again, because events until the next connection are missed
        this.changed();
      },
      topicsChanged: () => this.follow(),
      status: (status) => this.onStatus(status),
      statusEnded: (ids) => this.onStatusEnded(ids),
      leftOut: (messages) => {
        this.outcome = { ok: false, text: `${messages} ${t("left_out")}` };
      },
      parameters: () => undefined,
    });
    this.connection.subscribe("/gateway/control", (message) => {
      const before = this.control.you;
      this.control = checked(CONTROL, message, "control");
      if (!this.control.you) this.forgetOwned();
      if (before && !this.control.you && this.control.holder !== "") {
        this.note(`${timeOfDay()}: ${t("control_taken")} ${this.control.holder}`);
      }
      this.connection.setPatience(this.control.you ? this.control.silence_ms : LONGEST_SILENCE_MS);
      this.changed();
    });
    this.connection.subscribe("/gateway/dictionary", (message) => {
      this.dictionary = checked(DICTIONARY, message, "dictionary");
      this.changed();
    });
    this.connection.open();
  }

  /** @return the axes that move or apply torque, by who controls them: this page, another client, or nobody. */
  moving(): Moving {
    const moving: Moving = { own: [], holders: [], free: [] };
    const holder = this.holderSession();
    const torqueModes = new Set(this.dictionary?.modes.filter((row) => row.commands_torque).map((row) => row.mode));
    for (const bench of this.sortedBenches()) {
      const owners = bench.numbers("owner_session");
      // The last frame remains after a bench has ended, and after the view that showed its status is closed.
      const isOld = this.isGone(bench, performance.now()) || !this.ends.has(`${bench.topic}/status`);
      if (owners === undefined || isOld) continue;
      for (const [axis, place] of bench.places) {
        const at = (member: string): number => Number(bench.numbers(member)?.[place] ?? 0);
        const demand = {
          statusword: at("ds402_statusword"),
          velocity: at("velocity_demand_value"),
          torque: at("torque_demand"),
        };
        if (!movesOrPresses(demand, torqueModes.has(at("op_mode_actual")))) continue;
        const owner = BigInt(owners[place]);
        const address = `${bench.number}.${axis}`;
        if (owner === 0n) moving.free.push(address);
        else if (owner === holder && this.control.you) moving.own.push(address);
        else if (owner === holder) moving.holders.push(address);
      }
    }
    return moving;
  }

  /** @return the question before this page takes control from another client: who that is, and which axes move. */
  takeOverText(): string {
    const { holder, taken_at_ns } = this.control;
    const since = timeOfDay(new Date(Number(BigInt(taken_at_ns) / 1_000_000n)));
    const moving = this.moving().holders.map((address) => this.motionText(address));
    const isUnknown = this.sortedBenches().some(({ topic }) => !this.ends.has(`${topic}/status`));
    const rest = t(isUnknown ? "moves_unknown" : "nothing_moves");
    const what = moving.length === 0 ? rest : `${t("moves_now")}: ${listed(moving)}`;
    return `${t("take_by_force")} ${holder}, ${t("has_had_it_since")} ${since}? ${what}`;
  }

  /** @return such as "1.1 (profile position, 51 892 UU, 20 480 UU/s)" */
  private motionText(address: string): string {
    const ref = this.find(address);
    if (ref === undefined) return address;
    const { bench, axis } = ref;
    const scale = this.scale(axis);
    const at = (member: string) => Number(bench.numbers(member)?.[bench.places.get(axis.axis) ?? 0] ?? 0);
    const position = `${formatUnits(at("load_position_actual_value"), scale)} ${scale.name}`;
    const velocity = `${formatUnits(at("load_velocity_actual_value"), scale)} ${scale.name}/s`;
    return `${address} (${modeName(at("op_mode_actual"))}, ${position}, ${velocity})`;
  }

  /** The status of all axes of a large bench is only requested while a view shows it. */
  wantStatus(wanted: boolean): void {
    this.statusWanted = wanted;
    this.follow();
  }

  saveSettings(): void {
    localStorage.setItem(SETTINGS_KEY, JSON.stringify(this.settings));
  }

  axes(): AxisRef[] {
    const found: AxisRef[] = [];
    for (const bench of this.sortedBenches()) {
      for (const axis of bench.description?.axes ?? []) found.push(new AxisRef(this.benches, bench, axis));
    }
    return found;
  }

  sortedBenches(): Bench[] {
    return [...this.benches.values()].sort((a, b) => a.number - b.number);
  }

  find(address: string): AxisRef | undefined {
    const [number, axis] = address.split(".").map(Number);
    const bench = this.benches.get(number);
    const found = bench?.axis(axis);
    return bench !== undefined && found !== undefined ? new AxisRef(this.benches, bench, found) : undefined;
  }

  scale(axis: { unit?: AxisUnit }): Scale {
    return this.settings.axisUnits ? scaleOf(axis.unit) : USER_UNITS;
  }

  /** @return whether the bench has ended, or sends nothing. */
  isSilent(bench: Bench, now: number): boolean {
    return bench.state !== undefined && (!bench.state.alive || this.age(bench, now) > SILENT_FROM_MS);
  }

  /** @return whether its axes cannot be commanded; false while a service is being replaced. */
  isGone(bench: Bench, now: number): boolean {
    return bench.state === undefined || !bench.state.alive || this.age(bench, now) > GONE_FROM_MS;
  }

  /** @return the age of the data shown for the bench [ms]. */
  age(bench: Bench, now: number): number {
    const state = bench.state;
    if (state === undefined) return Infinity;
    return state.age_ms + Math.max(0, now - bench.stateAt - 250);
  }

  /** @param isShort without process and host, or browser and system, for a column */
  ownerName(session: bigint, isShort = false): string {
    if (session === 0n) return "";
    const text = session.toString(16).padStart(16, "0");
    const isHolder = session === this.holderSession();
    if (isHolder && this.control.you) return "@";
    const name = isHolder ? this.control.holder : this.sessionNames.get(text);
    if (name !== undefined) return isShort ? name.replace(/ \([^)]*\)$/, "") : name;
    return isShort ? text.slice(0, 8) : `${t("session")} ${text.slice(0, 8)}`;
  }

  /** @param session as the gateway writes it
   *  @return the program; undefined if it has not published its name */
  programOf(session: string): string | undefined {
    const isHolder = sessionOf(session) === this.holderSession();
    if (isHolder) return this.control.you ? t("this_page") : this.control.holder;
    return this.sessionNames.get(session);
  }

  /** @return when axes of this page were taken, and by whom; the name may arrive after the status. */
  private takenHow(): string {
    // A program that took an axis and ended immediately is in no status.
    if (this.takenBy === 0n) this.takenBy = this.takerOf([...this.taken.keys()]);
    const by = this.ownerName(this.takenBy);
    return `${this.takenAt}: ${t("taken_away")}${by === "" ? "" : `, ${t("now_by")} ${by}`}`;
  }

  /** @return the session that took the last of these axes from this page, 0 = unknown. */
  private takerOf(addresses: readonly string[]): bigint {
    const own = this.ownSession();
    for (const bench of this.benches.values()) {
      const taking = bench.state?.takings
        .filter(({ axis, from }) => sessionOf(from) === own && addresses.includes(`${bench.number}.${axis}`))
        .at(-1);
      if (taking !== undefined) return sessionOf(taking.by);
    }
    return 0n;
  }

  private noteNames(owners: BenchState["owners"]): void {
    if (this.sessionNames.size > MOST_NAMES) this.sessionNames.clear();
    for (const { session, name } of owners) this.sessionNames.set(session.replace(/^0x/, ""), name);
  }

  errorName(code: number): string {
    const row = this.dictionary?.error_codes?.find((e) => Number(e.code) === code);
    return row?.name ?? "";
  }

  /** @return the notices that the user must answer or dismiss. */
  notices(): Notice[] {
    const notes = this.notes.map((text) => ({ text, button: t("remove"), press: () => void this.notes.splice(this.notes.indexOf(text), 1) }));
    if (this.taken.size === 0) return notes;
    const text = `${this.takenHow()}: ${listed([...this.taken.keys()])}`;
    return [{ text, button: t("take_back"), press: () => this.taken.clear() }, ...notes];
  }

  /** @return what the user must do first, empty if the axes can be commanded. */
  whyDisabled(axes: AxisRef[], now: number): string {
    if (!this.control.enabled) return t("view_only");
    if (!this.control.you || !this.connected) return t("need_control");
    if (axes.length === 0) return t("none_chosen");
    const gone = axes.find(({ bench }) => this.isGone(bench, now))?.bench;
    return gone === undefined ? "" : `${gone.description?.name ?? ""} (${gone.number}) ${t("bench_gone")}`;
  }

  /** @return why the page does not command these axes, undefined if it may. */
  whyTaken(addresses: string[]): string | undefined {
    const taken = addresses.filter((address) => this.taken.has(address));
    return taken.length === 0 ? undefined : `${t("was_taken")}: ${listed(taken)}`;
  }

  /** Takes control with the chosen limit of silence; if another client holds it, the user has already confirmed. */
  takeControl(): void {
    const force = this.control.holder !== "";
    const browser = browserOf(navigator.userAgent);
    const name = browser === "" ? "page" : `page (${browser})`;
    void this.command("/take_control", { name, force, silence_ms: this.settings.silence * 1000 });
  }

  /** Sets how long the page may be silent while it holds control, from now on and next time.
   *  @param seconds one of SILENCES_S */
  async chooseSilence(seconds: number): Promise<void> {
    this.settings.silence = seconds;
    this.saveSettings();
    if (this.control.you) await this.command("/take_control", { silence_ms: seconds * 1000 }, [`${t("silence")} ${seconds} s`]);
  }

  /** Calls a service, and keeps its answer for the line below the controls.
   *  @param notes the results of converting typed values */
  async command(service: string, request: object, notes: string[] = []): Promise<Answer> {
    const what = serviceName(service);
    const began = performance.now();
    if (!NEVER_LEFT_OUT.has(service)) {
      const taken = this.whyTaken(addressesIn(request));
      const isSecond = taken === undefined && this.isSecondPress(service, request, began);
      if (taken !== undefined) this.outcome = { ok: false, text: `${what}: ${taken}` };
      if (isSecond) this.outcome = { ok: true, text: `${what}: ${t("second_press")}` };
      if (taken !== undefined || isSecond) return NOT_SENT;
    }
    const answer = await this.connection.call(service, request);
    const took = (performance.now() - began).toFixed(0);
    const why = answer.message === "" ? answer.outcome : answer.message;
    const became = notes.length === 0 ? "" : `: ${notes.slice(0, MOST_NOTES).join(", ")}${notes.length > MOST_NOTES ? ", …" : ""}`;
    const isUnderWay = answer.ok && (STARTS_MOTION.has(service) || STOPS_MOTION.has(service));
    const good = `${what}: ${isUnderWay ? t("accepted") : t("done")}, ${took} ms${became}`;
    this.outcome = { ok: answer.ok, text: answer.ok ? good : `${what}: ${why}`, isUnderWay };
    if (answer.ok && STARTS_MOTION.has(service)) void this.motions.follow(request, this.ownSession());
    return answer;
  }

  /** A double click counts once. */
  private isSecondPress(service: string, request: object, now: number): boolean {
    const { axis, axes, bench, name } = request as Record<string, unknown>;
    const control = JSON.stringify([service, axis, axes, bench, name]);
    const values = JSON.stringify(request);
    const before = this.presses.get(control);
    for (const [other, { at }] of this.presses) if (now - at >= SECOND_PRESS_MS) this.presses.delete(other);
    const isSecond = before !== undefined && before.values === values && now - before.at < SECOND_PRESS_MS;
    // A press that is left out does not restart the time, so somebody who keeps pressing gets through.
    if (!isSecond) this.presses.set(control, { values, at: now });
    return isSecond;
  }

  private onStatus(status: ServerStatus): void {
    if (status.id === "network") this.networkTrouble = status.message;
    else if (status.level > 0) this.outcome = { ok: false, text: status.message };
  }

  private onStatusEnded(ids: string[]): void {
    if (ids.includes("network")) this.networkTrouble = "";
  }

  private changed(): void {
    ++this.version;
  }

  private follow(): void {
    const topics = new Set<string>();
    const present = new Set<number>();
    for (const topic of this.connection.topics()) {
      const match = /^\/bench(\d+)\/(description|state|events|status)$/.exec(topic);
      if (match === null) continue;
      const number = Number(match[1]);
      present.add(number);
      let bench = this.benches.get(number);
      if (bench === undefined) {
        bench = new Bench(number, `/bench${number}`);
        this.benches.set(number, bench);
      }
      const isSmall = (bench.description?.axes.length ?? Infinity) <= SMALL_BENCH;
      if (match[2] === "status" && !this.statusWanted && !isSmall) continue;
      // Without the description an event has no axis; earlier events are requested later.
      if (match[2] === "events" && bench.description === undefined) continue;
      topics.add(topic);
      if (!this.ends.has(topic)) this.ends.set(topic, this.subscribe(bench, topic, match[2]));
    }
    for (const number of present) this.askEvents(number);
    if (this.connected) {
      for (const number of this.benches.keys()) {
        if (present.has(number)) continue;
        this.benches.delete(number);
        this.askedEvents.delete(number); // requested again, because events until the bench is back are missed
      }
      for (const [topic, end] of this.ends) {
        if (topics.has(topic)) continue;
        end();
        this.ends.delete(topic);
      }
    }
    this.changed();
  }

  private subscribe(bench: Bench, topic: string, kind: string): () => void {
    switch (kind) {
      case "description":
        return this.connection.subscribe(topic, (message) => {
          bench.description = checked(BENCH_DESCRIPTION, message, topic);
          this.noteRun(bench);
          this.follow(); // subscribes to the status of a small bench
        });
      case "state":
        return this.connection.subscribe(topic, (message) => {
          const before = bench.state?.alive;
          bench.state = checked(BENCH_STATE, message, topic);
          bench.stateAt = performance.now();
          this.noteNames(bench.state.owners);
          if (before !== bench.state.alive) this.changed();
        });
      case "status":
        return this.connection.subscribe(topic, (message) => {
          bench.take(message);
          if (this.control.you) this.watchOwners(bench);
        });
      default:
        return this.connection.subscribe(topic, (message) => this.addEvent(bench, message));
    }
  }

  /** Notices a restart of the bench, in which the values that were set are lost. */
  private noteRun(bench: Bench): void {
    const { incarnation = "", name = "" } = bench.description ?? {};
    const before = this.incarnations.get(bench.number);
    this.incarnations.set(bench.number, String(incarnation));
    if (before === undefined || before === String(incarnation)) return;
    this.events.forget(bench.number);
    this.motions.forgetBench(bench.number);
    this.askedEvents.delete(bench.number);
    // The axes of the new run have no owner, so both maps are cleared, including any entry from a frame of the new run
    // that arrived before this description.
    for (const axes of [this.owned, this.taken]) {
      for (const address of axes.keys()) if (address.startsWith(`${bench.number}.`)) axes.delete(address);
    }
    this.note(`${name} (${bench.number}): ${t("another_run")} ${timeOfDay()}`);
  }

  /** Adds a line that stays until the user dismisses it. */
  private note(text: string): void {
    this.notes.push(text);
    if (this.notes.length > MOST_NOTICES) this.notes.shift();
  }

  /** @return the session of the client that holds control, -1 = none */
  private holderSession(): bigint {
    const { session } = this.control;
    return session === "" ? -1n : sessionOf(session);
  }

  private ownSession(): bigint {
    return this.control.you ? this.holderSession() : -1n;
  }

  /** Detects that another session has taken an axis: the next command of the page must not take it back. */
  private watchOwners(bench: Bench): void {
    const owners = bench.numbers("owner_session");
    if (owners === undefined) return;
    const own = this.ownSession();
    let isTaken = false;
    let by = 0n;
    for (const [axis, place] of bench.places) {
      const owner = BigInt(owners[place]);
      const address = `${bench.number}.${axis}`;
      const before = this.owned.get(address);
      if (owner === own) {
        this.owned.set(address, bench.tick);
      } else if (before !== undefined) {
        this.owned.delete(address);
        this.taken.set(address, before);
        isTaken = true;
        if (owner !== 0n) by = owner;
      }
    }
    if (isTaken) this.noteTaken(by);
  }

  private noteTaken(by: bigint): void {
    this.takenAt = timeOfDay();
    this.takenBy = by;
    this.sortOutLost();
    if (this.taken.size > 0) this.outcome = { ok: false, text: `${this.takenHow()}: ${listed([...this.taken.keys()])}` };
  }

  /** Axes released by the watchdog of a bench were not taken by anybody: the event, which may arrive after the
   *  status, shows the reason. */
  private sortOutLost(): void {
    const lost = new Map<string, string[]>();
    for (const [address, tick] of this.taken) {
      const why = this.takerOf([address]) === 0n ? this.lossOf(address, tick) : undefined;
      if (why === undefined) continue;
      this.taken.delete(address);
      lost.set(why, [...(lost.get(why) ?? []), address]);
    }
    for (const [why, addresses] of lost) {
      const text = `${t("lost_by_silence")} ${listed(addresses)}: ${why}`;
      this.note(`${timeOfDay()}: ${text}`);
      this.outcome = { ok: false, text };
    }
  }

  /** @return the bench's report about the loss of this page's session since that tick */
  private lossOf(address: string, tick: number): string | undefined {
    const [bench] = address.split(".").map(Number);
    const { session } = this.control;
    return this.events.events.find(
      (event) => event.bench === bench && event.kind === "master_lost" && event.tick >= tick && event.message.includes(session),
    )?.message;
  }

  private forgetOwned(): void {
    this.owned.clear();
    this.taken.clear();
    this.motions.lose();
  }

  /** Requests the earlier events. Those since the subscription may be among them. */
  private askEvents(number: number): void {
    const period = this.benches.get(number)?.description?.period_us;
    if (period === undefined || this.askedEvents.has(number) || !this.connection.hasService("/events")) return;
    this.askedEvents.add(number);
    // One bench after the other: the gateway limits waiting calls and bytes.
    const turn = this.askingEvents.then(() => this.fetchEvents(number, period));
    this.askingEvents = turn.catch(() => undefined);
  }

  private async fetchEvents(number: number, period: number): Promise<void> {
    const answer = await this.connection.call("/events", { bench: number });
    if (!answer.ok) {
      this.askedEvents.delete(number); // requested again when topics change
      return;
    }
    const { events } = checked(EVENT_HISTORY, answer, "/events");
    this.events.merge(events.map((event) => ({ ...event, bench: number, time: event.tick * period * 1e-6 })));
  }

  private addEvent(bench: Bench, message: Message): void {
    const stamp = message["timestamp"] as { sec: number; nanosec?: number; nsec?: number };
    const nanoseconds = stamp.nanosec ?? stamp.nsec ?? 0;
    const period = bench.description?.period_us ?? 1000;
    // The bench, or the bench and its axis: "bench1/x".
    const [, topic] = (message["name"] as string).split("/");
    this.events.add({
      bench: bench.number,
      axis: bench.description?.axes.find((axis) => axis.topic === topic)?.axis ?? 0,
      tick: Math.round((stamp.sec * 1e6 + nanoseconds * 1e-3) / period),
      time: stamp.sec + nanoseconds * 1e-9,
      level: message["level"] as number,
      kind: message["file"] as string,
      message: message["message"] as string,
    });
    this.sortOutLost();
  }
}
