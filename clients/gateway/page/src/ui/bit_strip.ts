// SPDX-License-Identifier: Apache-2.0
// The bits of the set-point handshake of one axis, with the fate of each set-point.

import type { Samples } from "../data/samples";
import { hasHandshake } from "../data/setpoints";
import { t, type TextKey } from "../i18n";
import { colour, fit, h, put } from "./dom";
import { AXIS_WIDTH, RIGHT_MARGIN, type Shown } from "./strip";

/** Bits 4 and 12 belong to the handshake only in profile position mode. In other modes their row is labelled with
 *  `number` instead of `text`. */
const BITS: { series: string; text: TextKey; number?: number }[] = [
  { series: "new_set_point", text: "bit4", number: 4 },
  { series: "acknowledge", text: "bit12", number: 12 },
  { series: "reached", text: "bit10" },
];
const ROW = 20; // [px]

export class BitStrip {
  readonly root: HTMLElement;
  readonly canvas: HTMLCanvasElement;
  private readonly held = h("span", { class: "number", attributes: { "data-test": "set-points" } }, "–");

  constructor(
    readonly samples: Samples,
    head: Node[],
    tools: Node[],
  ) {
    this.canvas = h("canvas", { class: "strip", attributes: { role: "img", "aria-label": t("handshake") } });
    const kinds = (["accepted", "ignored", "reached"] as const).map((kind) =>
      h("span", { class: "reading" }, h("i", { class: `dot ${kind}` }), t(kind)),
    );
    const held = h("span", { class: "reading", title: t("held_hint") }, t("held"), this.held);
    const line = h("div", { class: "plot-head", title: t("handshake_hint") }, ...head, h("b", {}, t("handshake")), held, ...kinds, ...tools);
    this.root = h("div", { class: "plot strip-host" }, line, this.canvas);
  }

  /** Shows the number of set-points held. No history contains it, so there is none for a paused plot.
   *  @param isNow the plot shows the present */
  show(isNow: boolean): void {
    const held = isNow ? this.samples.setPoints : undefined;
    put(this.held, held === undefined ? "–" : `${held.active} + ${held.waiting ?? "?"}`);
  }

  draw({ from, to, columns }: Shown, width: number): void {
    const { samples } = this;
    const bits = BITS.filter(({ series }) => samples.series(series) !== undefined);
    const places = bits.map(({ series }) => samples.series(series) ?? 0);
    const points = samples.history.points(from - samples.origin, to - samples.origin, columns, places);
    const context = fit(this.canvas, width, BITS.length * ROW + 14);
    const right = width - RIGHT_MARGIN;
    const place = (time: number) => AXIS_WIDTH + ((time - from) / (to - from)) * (right - AXIS_WIDTH);
    context.font = "11px system-ui, sans-serif";
    const handshake = hasHandshake(samples.last["op_mode_actual"]);
    bits.forEach((bit, row) => {
      const bottom = (row + 1) * ROW - 4 + 12;
      context.strokeStyle = colour("grid");
      context.strokeRect(AXIS_WIDTH, bottom + 0.5, right - AXIS_WIDTH, 0);
      context.strokeStyle = colour(bit.series === "new_set_point" ? "line-2" : "line-1");
      context.lineWidth = 1.25;
      context.beginPath();
      let level = 0;
      points.x.forEach((time, i) => {
        const value = points.y[row][i];
        if (value === null) return;
        const x = Math.max(AXIS_WIDTH, place(time + samples.origin));
        if (i === 0) context.moveTo(x, bottom - value * 11);
        else {
          context.lineTo(x, bottom - level * 11);
          context.lineTo(x, bottom - value * 11);
        }
        level = value;
      });
      context.stroke();
      context.fillStyle = colour("muted");
      context.textAlign = "right";
      const text = handshake || bit.number === undefined ? t(bit.text) : `${t("bit")} ${bit.number}`;
      context.fillText(text, AXIS_WIDTH - 8, bottom - 1);
    });
    for (const { time, kind } of samples.marks) {
      if (time < from || time > to) continue;
      context.fillStyle = colour(kind === "ignored" ? "bad" : kind === "accepted" ? "line-2" : "good");
      context.beginPath();
      context.arc(place(time), 6, 3.5, 0, 2 * Math.PI);
      context.fill();
    }
  }
}
