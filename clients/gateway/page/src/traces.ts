// SPDX-License-Identifier: Apache-2.0
// What the page has received of axes: it stays while other views are shown.

import { addressOf, type AxisRef, type Model } from "./model";
import { Trace } from "./trace";

/** Each may have some tens of megabytes. */
const MOST_TRACES = 4;

export class Traces {
  /** by address and run of the bench; the one shown last is the last one */
  private readonly traces = new Map<string, Trace>();
  private shown?: Trace;

  constructor(private readonly model: Model) {}

  /** @return what was received of the axis, which is received from now on, also while no view shows
   *          it, until another axis is shown */
  show(ref: AxisRef): Trace {
    const run = ref.bench.description?.incarnation ?? "";
    const key = `${addressOf(ref)} ${run}`;
    const trace = this.traces.get(key) ?? new Trace(this.model, ref);
    if (this.shown !== trace) this.shown?.close();
    this.shown = trace;
    trace.open();
    trace.show(true);
    this.traces.delete(key);
    this.traces.set(key, trace);
    this.forget(addressOf(ref), key);
    return trace;
  }

  /** No view shows an axis. */
  hide(): void {
    this.shown?.show(false);
  }

  /** The run before counts its ticks anew, or has other axes. */
  private forget(address: string, kept: string): void {
    for (const key of this.traces.keys()) {
      const isOld = key.startsWith(`${address} `) && key !== kept;
      if (isOld || this.traces.size > MOST_TRACES) this.traces.delete(key);
    }
  }
}
