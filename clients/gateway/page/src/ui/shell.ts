// SPDX-License-Identifier: Apache-2.0
// The frame of every view: navigation, control, and STOP.

import { setLanguage, t } from "../i18n";
import { addressOf, listed, SECOND_PRESS_MS, type AxisRef, type Model, type Theme } from "../model";
import type { Recording } from "../recording";
import { LiveSource } from "../source";
import { Traces } from "../traces";
import { AxisView } from "./axis";
import { ControlView } from "./control";
import { button, h, mark, put, select, type View } from "./dom";
import { Overview, overviewMemory } from "./overview";
import { ask } from "./question";
import { ScopeView } from "./scope_view";

const MOTION_EVERY_MS = 250;
const MOST_MOTIONS = 4;
const LIGHT_FRAME_MS = 12;
const LONGEST_REST_MS = 500;

/**
 * Draws with each frame of the screen. If a frame takes long, as on a busy machine or without a graphics processor,
 * drawing pauses for as long as it took, so that messages and keys are handled.
 */
function drawFrames(draw: (now: number) => void): void {
  const drawn = new MessageChannel();
  let began = 0;
  const frame = (now: number) => {
    began = performance.now();
    drawn.port2.postMessage(undefined);
    draw(now);
  };
  const next = () => requestAnimationFrame(frame);
  // Arrives after the frame has been laid out and painted.
  drawn.port1.onmessage = () => {
    const took = performance.now() - began;
    if (took <= LIGHT_FRAME_MS) next();
    else window.setTimeout(next, Math.min(took, LONGEST_REST_MS));
  };
  next();
}

/** @return the hash without its query */
function pathOf(hash: string): string {
  return hash.split("?")[0];
}

export class Shell {
  private readonly memory = overviewMemory();
  private view?: View;
  private readonly traces: Traces;
  private readonly scopeMemory: { recording?: Recording } = {};
  private viewKey = "";
  private lastAxis?: string;
  private readonly main = h("main", { attributes: { tabindex: "-1" } });
  private readonly links = new Map<string, HTMLAnchorElement>();
  private readonly lamp = h("span", { class: "lamp" });
  private readonly link = h("span");
  private readonly clock = h("span", { class: "number bench-clock" });
  private readonly banner = h("p", { class: "banner", attributes: { role: "alert" } });
  private readonly notices = h("div", { class: "notices", attributes: { role: "status" } });
  private shownNotices = "";
  /** asked before control is taken from its holder */
  private readonly question = h("div", { class: "question", attributes: { role: "group", "aria-live": "polite" } });
  private readonly questionText = h("span");
  private endQuestion?: () => void;
  /** the session that the question is about */
  private askedAbout = "";
  private tookAt = -Infinity;
  private readonly holder = h("span", { class: "holder" });
  private readonly takeButton = button("", () => this.take(), { class: "take", attributes: { "data-test": "take" } });
  private readonly stopButton = button("", () => this.stop(), { class: "stop", attributes: { "data-test": "stop" } });
  private readonly outcome = h("p", { class: "outcome", attributes: { role: "status" } });
  private readonly motions = h("ul", { class: "motions" });
  /** Screen readers announce only the end of a motion, not its progress. */
  private readonly motionEnds = h("p", { class: "only-heard", attributes: { role: "status" } });
  private readonly motion = h("p", { class: "motion", attributes: { role: "status" } });
  private motionAt = -Infinity;
  private readonly prefersDark = window.matchMedia("(prefers-color-scheme: dark)");
  private version = -1;

  constructor(
    private readonly model: Model,
    private readonly app: HTMLElement,
  ) {
    this.traces = new Traces(model);
    setLanguage(model.settings.language);
    this.applyTheme();
    this.prefersDark.addEventListener("change", () => this.applyTheme());
    this.build();
    window.addEventListener("hashchange", () => {
      this.viewKey = ""; // a link may open the same view with other signals
      this.route();
    });
    window.addEventListener("beforeunload", (event) => {
      if (this.model.moving().own.length > 0) event.preventDefault();
    });
    window.addEventListener("beforeprint", () => (document.documentElement.dataset["theme"] = "light"));
    window.addEventListener("afterprint", () => {
      this.applyTheme();
      this.view?.redraw?.();
    });
    document.addEventListener("keydown", (event) => this.key(event), { capture: true });
    drawFrames((now) => this.update(now));
  }

  private build(): void {
    const nav = h("nav", { attributes: { "aria-label": "vdrive" } });
    for (const [key, href] of [["overview", "#/"], ["axis", "#/axis"], ["scope", "#/scope"], ["control", "#/control"]] as const) {
      const link = h("a", { attributes: { href } }, t(key));
      this.links.set(key, link);
      nav.append(link);
    }
    this.endQuestion?.(); // its text is in the previous language
    this.stopButton.replaceChildren(h("b", {}, t("stop")), " ", h("kbd", {}, "Ctrl + ."));
    this.stopButton.title = t("stop_hint");
    const { settings } = this.model;
    const theme = select(
      t("theme"),
      (["auto", "light", "dark"] as const).map((value) => ({ value, text: t(`theme_${value}`) })),
      settings.theme,
      (value) => {
        settings.theme = value as Theme;
        this.model.saveSettings();
        this.applyTheme();
        this.view?.redraw?.();
      },
    );
    const language = select(
      t("language"),
      [{ value: "en", text: "English" }, { value: "zh", text: "中文" }],
      settings.language,
      (value) => {
        settings.language = value === "zh" ? "zh" : "en";
        this.settingsChanged();
      },
    );
    const units = select(
      t("units"),
      [{ value: "user", text: t("units_user") }, { value: "axis", text: t("units_axis") }],
      settings.axisUnits ? "axis" : "user",
      (value) => {
        settings.axisUnits = value === "axis";
        this.settingsChanged();
      },
    );
    const frame = h(
      "div",
      { class: "frame" },
      h("h1", {}, "vdrive"),
      nav,
      h("div", { class: "link" }, this.lamp, this.link, this.clock),
      h("div", { class: "settings" }, units, language, theme),
      h("div", { class: "holding" }, this.holder, this.takeButton),
    );
    // STOP has its own column, so that it stays in place whatever else the header shows.
    const header = h("header", {}, frame, this.stopButton);
    this.app.replaceChildren(header, this.question, this.banner, this.notices, this.main, h("footer", {}, this.outcome, this.motions, this.motionEnds, this.motion));
    this.viewKey = "";
    this.version = -1;
    this.route();
  }

  private settingsChanged(): void {
    this.model.saveSettings();
    setLanguage(this.model.settings.language);
    this.build();
  }

  private applyTheme(): void {
    const { theme } = this.model.settings;
    const systems = this.prefersDark.matches ? "dark" : "light";
    document.documentElement.dataset["theme"] = theme === "auto" ? systems : theme;
  }

  private route(): void {
    const [, view = "", address = ""] = pathOf(location.hash).split("/");
    const name = view === "axis" || view === "control" || view === "scope" ? view : "overview";
    const ref = name === "axis" || name === "scope" ? this.axisOf(address) : undefined;
    // A scope may show axes of any bench.
    const benches = name === "scope" ? this.model.sortedBenches() : ref === undefined ? [] : [ref.bench];
    const runs = benches.map((bench) => bench.description?.incarnation ?? "").join(" ");
    const key = `${name} ${ref === undefined ? "" : addressOf(ref)} ${runs}`;
    for (const [link, element] of this.links) {
      if (link === name) element.setAttribute("aria-current", "page");
      else element.removeAttribute("aria-current");
    }
    if (key === this.viewKey) return;
    this.viewKey = key;
    this.view?.close?.();
    this.view = this.make(name, ref);
    this.main.className = name;
    const hadFocus = this.main.contains(document.activeElement);
    this.main.replaceChildren(this.view.root);
    if (hadFocus) (this.main.querySelector<HTMLElement>("[data-focus]") ?? this.main).focus();
  }

  private axisOf(address: string): AxisRef | undefined {
    if (address !== "") this.lastAxis = address;
    const wanted = address === "" ? (this.lastAxis ?? [...this.model.chosen][0]) : address;
    return wanted === undefined ? this.model.axes()[0] : this.model.find(wanted);
  }

  private make(name: string, ref: AxisRef | undefined): View {
    this.traces.hide();
    const [, query = ""] = location.hash.split("?"); // for a rebuilt view: the contents that it showed
    if (name === "scope") return new ScopeView(this.model, new LiveSource(this.model, this.traces), ref && addressOf(ref), query, this.scopeMemory);
    if (ref !== undefined) {
      const [trace] = this.traces.show([ref]);
      return new AxisView(this.model, trace, new LiveSource(this.model, this.traces, ref), query, (recording) => {
        this.scopeMemory.recording = recording;
        location.hash = "#/scope";
      });
    }
    if (name === "control") return new ControlView(this.model);
    if (name === "overview") return new Overview(this.model, this.memory);
    const [, , asked = ""] = pathOf(location.hash).split("/");
    const text = asked === "" ? t("choose_axis") : `${t("no_axis")} ${asked}. ${t("choose_axis")}`;
    return { root: h("p", { class: "nothing" }, text), update: () => undefined };
  }

  private update(now: number): void {
    if (this.version !== this.model.version) {
      this.version = this.model.version;
      this.route();
      this.showControl();
    }
    this.showLink(now);
    this.showNotices();
    this.showMotion(now);
    this.showOutcome();
    this.view?.update(now);
  }

  private showLink(now: number): void {
    const { connected } = this.model;
    const benches = this.model.sortedBenches();
    const silent = benches.filter((b) => this.model.isSilent(b, now));
    const lamp = `lamp ${connected ? (silent.length > 0 ? "quick_stop_active" : "operation_enabled") : "fault"}`;
    if (this.lamp.className !== lamp) this.lamp.className = lamp;
    put(this.link, connected ? t("connected") : t("connecting"));
    const first = benches[0];
    const time = first?.state === undefined ? "" : `${t("tick")} ${first.state.tick}`;
    put(this.clock, time);
    const silence = silent
      .map((b) => `${b.description?.name ?? ""} (${b.number}) ${t("bench_silent")} ${(this.model.age(b, now) / 1000).toFixed(0)} s`)
      .join(", ");
    const troubles = [this.model.networkTrouble, silence].filter((text) => text !== "").join("; ");
    put(this.banner, connected ? troubles : t("lost_banner"));
    this.banner.hidden = connected && troubles === "";
    mark(document.body, "lost", !connected);
  }

  private showControl(): void {
    const { control, connected } = this.model;
    // If control has changed since the question was asked, the question no longer applies.
    if (control.session !== this.askedAbout) this.endQuestion?.();
    const able = control.enabled && connected;
    this.stopButton.disabled = !able;
    this.takeButton.hidden = !able;
    mark(this.holder, "you", control.you);
    if (!control.enabled) {
      put(this.holder, t("view_only_short"));
      this.holder.title = t("view_only");
      return;
    }
    this.holder.title = "";
    const held = control.holder !== "";
    put(this.holder, control.you ? t("you_hold") : held ? `${t("held_by")} ${control.holder}` : t("nobody_holds"));
    put(this.takeButton, control.you ? t("release") : held ? `${t("take")} …` : t("take"));
  }

  private showNotices(): void {
    const notices = this.model.notices();
    const wanted = notices.map(({ text }) => text).join("\n");
    if (wanted === this.shownNotices) return;
    this.shownNotices = wanted;
    const lines = notices.map(({ text, button: label, press }) => h("p", {}, h("span", {}, text), button(label, press)));
    this.notices.replaceChildren(...lines);
  }

  /** Shows which axes would continue to move after this page is closed, or move with nobody in control. */
  private showMotion(now: number): void {
    if (now - this.motionAt < MOTION_EVERY_MS) return;
    this.motionAt = now;
    this.showMotions();
    if (this.endQuestion !== undefined) put(this.questionText, this.model.takeOverText());
    const { own, free } = this.model.moving();
    const { control } = this.model;
    const isFree = free.length > 0 && control.enabled && !control.you;
    put(this.motion, own.length > 0 ? `${t("moves_on")}: ${listed(own)}` : isFree ? `${t("moves_free")}: ${listed(free)}` : "");
  }

  private showOutcome(): void {
    const { outcome } = this.model;
    put(this.outcome, outcome?.text ?? "");
    const kind = outcome === undefined ? "" : !outcome.ok ? " bad" : outcome.isUnderWay === true ? "" : " good";
    const wanted = `outcome${kind}`;
    if (this.outcome.className !== wanted) this.outcome.className = wanted;
  }

  /** Shows the motions that this page has started: first those that ended early. */
  private showMotions(): void {
    const all = this.model.motions.lines();
    put(this.motionEnds, all.flatMap(({ kind, text }) => (kind === "moves" ? [] : [text])).join("; "));
    const lines = [...all.filter(({ kind }) => kind === "ended"), ...all.filter(({ kind }) => kind !== "ended")].slice(0, MOST_MOTIONS);
    if (all.length > lines.length) lines.push({ kind: "moves", text: `… (${all.length})` });
    while (this.motions.children.length > lines.length) this.motions.lastElementChild?.remove();
    lines.forEach(({ kind, text }, i) => {
      const line = this.motions.children[i] ?? this.motions.appendChild(h("li"));
      if (line.className !== kind) line.className = kind;
      put(line as HTMLElement, text);
    });
  }

  private take(): void {
    const { control } = this.model;
    // The button takes and releases: the second click of a double click would undo the first.
    const now = performance.now();
    const isSecond = now - this.tookAt < SECOND_PRESS_MS;
    this.tookAt = now;
    if (isSecond) return;
    if (control.you) void this.model.command("/release_control", {});
    else if (control.holder === "") this.model.takeControl();
    else this.askTakeOver(control.session);
  }

  /** Asks first, because the holder loses control even while its axes move. */
  private askTakeOver(session: string): void {
    if (this.endQuestion !== undefined) return;
    put(this.questionText, this.model.takeOverText());
    this.endQuestion = ask(this.question, {
      text: this.questionText,
      label: t("take"),
      name: "take",
      agree: () => this.model.takeControl(),
      leave: (hadFocus) => {
        this.endQuestion = undefined;
        if (hadFocus) this.takeButton.focus();
      },
    });
    this.askedAbout = session;
  }

  private stop(): void {
    void this.model.command("/quick_stop", {});
  }

  private key(event: KeyboardEvent): void {
    if (!event.ctrlKey || event.key !== ".") return;
    event.preventDefault();
    this.stop();
  }
}
