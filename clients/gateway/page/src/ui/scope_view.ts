// SPDX-License-Identifier: Apache-2.0
// The scope in the full window, with the events: from the benches, or from a recording.

import { t } from "../i18n";
import type { Model } from "../model";
import { formatScope, parseScope } from "../data/scope_link";
import type { Samples } from "../data/samples";
import type { TriggerRun } from "../data/trigger";
import { openRecording, type Recording } from "../recording";
import type { Source } from "../source";
import { freeze, recordingOfWindow } from "../window";
import { button, FOCUS, h, type View } from "./dom";
import { Events } from "./events";
import { presetOf, Scope } from "./scope";

export class ScopeView implements View {
  readonly root: HTMLElement;
  private parts: View[] = [];
  private readonly place = h("div", { class: "scope-view" });
  private readonly file = h("input", { attributes: { type: "file", accept: ".mcap,.csv", "aria-label": t("open_recording"), "data-test": "recording" } });
  private readonly name = h("span", { class: "recording-name", attributes: { role: "status", "data-test": "recording_name" } });
  private readonly cut = h("p", { class: "problem", attributes: { role: "alert" } });
  private readonly closeButton: HTMLButtonElement;

  /** @param axis whose signals are shown if the link names none
   *  @param memory keeps the recording while other views are shown */
  constructor(
    private readonly model: Model,
    private readonly live: Source,
    private readonly axis: string | undefined,
    query: string,
    private readonly memory: { recording?: Recording },
  ) {
    this.file.hidden = true;
    this.file.addEventListener("change", () => void this.openFile(this.file.files?.[0]));
    const open = button(t("open_recording"), () => this.file.click(), { title: t("open_recording_hint") });
    this.closeButton = button(t("close_recording"), () => this.show(undefined), { attributes: { "data-test": "close_recording" } });
    this.root = h(
      "div",
      { class: "scope-view" },
      h("h2", { class: "only-heard", attributes: FOCUS }, t("scope")),
      h("div", { class: "line recording" }, open, this.file, this.closeButton, this.name),
      this.cut,
      this.place,
    );
    this.root.addEventListener("dragover", (event) => event.preventDefault());
    this.root.addEventListener("drop", (event) => {
      event.preventDefault();
      void this.openFile(event.dataTransfer?.files[0]);
    });
    this.show(memory.recording, query);
  }

  update(now: number): void {
    for (const part of this.parts) part.update(now);
  }

  redraw(): void {
    for (const part of this.parts) part.redraw?.();
  }

  close(): void {
    for (const part of this.parts) part.close?.();
  }

  /** @param query from the address: a link to a place in a recording applies once the file is open */
  private show(recording: Recording | undefined, query = location.hash.split("?")[1] ?? ""): Scope {
    this.close();
    this.memory.recording = recording;
    const source = recording ?? this.live;
    const [first] = recording?.axes() ?? [];
    const axis = recording === undefined ? this.axis : first?.address;
    const capture = (run: TriggerRun, all: readonly Samples[]) => void this.capture(run, all);
    const scope = new Scope(this.model, source, axis === undefined ? [] : presetOf(axis), query, true, recording === undefined ? capture : undefined);
    const events = new Events(this.model, source.events, () => true, ({ time }) => scope.goTo(time));
    this.parts = [scope, events];
    this.place.replaceChildren(scope.root, events.root);
    this.closeButton.hidden = recording === undefined;
    this.name.textContent = recording === undefined ? "" : `${recording.name}: ${recording.axes().map(({ address, name }) => `${address} ${name}`).join(", ")}`;
    this.cut.textContent = recording === undefined || recording.cut === "" ? "" : `${recording.name}: ${recording.cut}`;
    this.cut.hidden = this.cut.textContent === "";
    return scope;
  }

  /** Opens what the black box keeps around a trigger, with the signals that are shown. */
  private async capture({ trigger, found }: TriggerRun, all: readonly Samples[]): Promise<void> {
    const bench = Number(trigger.axis.split(".")[0]);
    try {
      const window = await freeze(this.model, bench);
      const recording = await recordingOfWindow(this.model, window, all.filter(({ axis }) => axis.bench === bench));
      if (!this.root.isConnected) return;
      const { strips } = parseScope(location.hash.split("?")[1] ?? "").state;
      const scope = this.show(recording, strips === undefined ? "" : formatScope({ strips }));
      if (found !== undefined) scope.markTime(found);
    } catch (error) {
      this.model.outcome = { ok: false, text: `${t("trigger")}: ${(error as Error).message}` };
    }
  }

  private async openFile(file: File | undefined): Promise<void> {
    if (file === undefined) return;
    this.file.value = ""; // so that the same file can be opened again
    try {
      const recording = await openRecording(file, (share) => (this.name.textContent = `${file.name}: ${Math.floor(share * 100)} %`));
      if (this.root.isConnected) this.show(recording);
    } catch (error) {
      if (this.root.isConnected) this.show(this.memory.recording);
      this.model.outcome = { ok: false, text: (error as Error).message };
    }
  }
}
