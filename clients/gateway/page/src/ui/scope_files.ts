// SPDX-License-Identifier: Apache-2.0
// The contents of a scope as CSV and as a picture.

import type { Samples } from "../data/samples";
import { quantityOf, type ObjectUnit } from "../data/signals";
import { isoDate, timeText } from "../data/times";
import { formatHex, scaleOf, toShown, USER_UNITS } from "../data/units";
import { t } from "../i18n";
import type { BitStrip } from "./bit_strip";
import { colour, h } from "./dom";
import type { PlotStrip } from "./strip";

const PRINTED_DATE = "2026-01-01".length;
const FILE_DATE = "2026-01-01T00:00:00".length;

/** The date of a drive time [s]; the present date if drive time has none. */
function dateOf(time: number): string {
  const date = isoDate(time);
  return date === "" ? new Date().toISOString() : date;
}

/** @param to [s] of drive time, the end of the saved range */
export function fileName(all: readonly Samples[], to: number): string {
  const name = all.map(({ axis }) => `${axis.address}_${axis.name}`).join("_");
  return `${name}_${dateOf(to).slice(0, FILE_DATE)}`.replace(/[^\w.-]/g, "_");
}

interface CsvColumn {
  head: string;
  /** @return the text of a sample; "" if there is none */
  text: (sample: number) => string;
}

function columnsOf(samples: Samples, objects: readonly ObjectUnit[], inAxisUnits: boolean, named: boolean): CsvColumn[] {
  const scale = inAxisUnits ? scaleOf(samples.axis.unit) : USER_UNITS;
  const unitName = scale === USER_UNITS ? scale.name : (samples.axis.unit?.name ?? scale.name);
  return samples.members.map((member, series) => {
    const quantity = quantityOf(objects.find(({ name }) => name === member), { ...scale, name: unitName });
    const unit = quantity.unit === "" ? "" : ` [${quantity.unit}]`;
    const text = (sample: number) => toShown(samples.history.value(series, sample), quantity.scale).toFixed(quantity.scale.decimals);
    return { head: `${named ? `${samples.axis.address} ` : ""}${member}${unit}`, text };
  });
}

/** Every sample from `from` to `to` [s], not only the points drawn: a row for each tick of any axis. */
export function csvOf(all: readonly Samples[], objects: readonly ObjectUnit[], from: number, to: number, inAxisUnits: boolean): string[] {
  const named = all.length > 1;
  const tables = all.map((samples) => ({
    samples,
    columns: columnsOf(samples, objects, inAxisUnits, named),
    next: samples.history.lowerBound(from - samples.origin),
  }));
  const parts = [`tick,time [s],date,${tables.flatMap(({ columns }) => columns.map(({ head }) => head)).join(",")}\n`];
  const timeAt = (samples: Samples, n: number) => (n < samples.history.end ? samples.origin + samples.history.time(n) : Infinity);
  for (;;) {
    const time = Math.min(...tables.map(({ samples, next }) => timeAt(samples, next)));
    if (!(time <= to)) return parts;
    const tick = tables[0].samples.tickAt(time);
    const cells = tables.flatMap((table) => {
      const isHere = table.samples.tickAt(timeAt(table.samples, table.next)) === tick;
      const sample = table.next;
      if (isHere) ++table.next;
      return table.columns.map(({ text }) => (isHere ? text(sample) : ""));
    });
    parts.push(`${tick},${time.toFixed(6)},${isoDate(time)},${cells.join(",")}\n`);
  }
}

/** The axes, the time, and the states at the end. */
export function titleOf(all: readonly Samples[], from: number, to: number): string {
  const states = all.map((samples) => {
    const number = samples.history.nearest(to - samples.origin);
    const hex = (member: string) => {
      const series = samples.series(member);
      return number === undefined || series === undefined ? "–" : formatHex(samples.history.value(series, number));
    };
    return `${samples.axis.address} ${samples.axis.name}, 6041h = ${hex("ds402_statusword")}, 603Fh = ${hex("error_code")}`;
  });
  const times = [from, to].map((time) => timeText(Math.max(0, time))).join(" – ");
  return `${dateOf(to).slice(0, PRINTED_DATE)}, ${times}: ${states.join("; ")}`;
}

/** @return the strips stacked vertically, with their legends */
export function pictureOf(title: string, strips: readonly (PlotStrip | BitStrip)[], width: number): HTMLCanvasElement {
  const ratio = window.devicePixelRatio || 1;
  const head = 22 * ratio;
  const canvasOf = (strip: PlotStrip | BitStrip) => ("plot" in strip ? strip.plot.ctx.canvas : strip.canvas);
  const whole = h("canvas");
  whole.width = width * ratio;
  whole.height = strips.reduce((sum, strip) => sum + canvasOf(strip).height + head, head);
  const context = whole.getContext("2d");
  if (context === null) throw new Error("no canvas");
  context.fillStyle = colour("panel");
  context.fillRect(0, 0, whole.width, whole.height);
  context.fillStyle = colour("text");
  context.font = `${12 * ratio}px system-ui, sans-serif`;
  context.fillText(title, 8 * ratio, 15 * ratio);
  let top = head;
  for (const strip of strips) {
    const isPlot = "plot" in strip;
    const text = `${strip.samples.axis.address} ${isPlot ? `[${strip.unit}]` : t("handshake")}`;
    context.fillText(text, 8 * ratio, top + 15 * ratio);
    if (isPlot) strip.drawLegend(context, 8 * ratio + context.measureText(text).width, top + 15 * ratio, ratio);
    context.drawImage(canvasOf(strip), 0, top + head);
    top += canvasOf(strip).height + head;
  }
  return whole;
}
