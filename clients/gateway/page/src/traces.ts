// SPDX-License-Identifier: Apache-2.0
// The received samples of axes, which are kept while other views are shown.

import { addressOf, type AxisRef, type Model } from "./model";
import { Trace } from "./trace";

/** Each may take some tens of megabytes. */
export const MOST_TRACES = 8;

export class Traces {
  /** by address and run of the bench; in the order in which they were last shown */
  private readonly traces = new Map<string, Trace>();
  private shown: Trace[] = [];

  constructor(private readonly model: Model) {}

  /** @param refs MOST_TRACES at most
   *  @return the samples of these axes. The axes are received from now on until others are shown, even while no view
   *          shows them. */
  show(refs: readonly AxisRef[]): Trace[] {
    const wanted = refs.map((ref) => this.find(ref));
    for (const trace of this.shown) if (!wanted.includes(trace)) trace.close();
    this.shown = wanted;
    for (const trace of wanted) {
      trace.open();
      if (!trace.isShown) trace.show(true);
    }
    this.forget();
    return wanted;
  }

  /** No view shows an axis. */
  hide(): void {
    for (const trace of this.shown) trace.show(false);
  }

  private find(ref: AxisRef): Trace {
    const address = addressOf(ref);
    const key = `${address} ${ref.bench.description?.incarnation ?? ""}`;
    const trace = this.traces.get(key) ?? new Trace(this.model, ref);
    // The previous run had its own tick numbers, or other axes.
    for (const old of this.traces.keys()) if (old.startsWith(`${address} `)) this.traces.delete(old);
    this.traces.set(key, trace);
    return trace;
  }

  private forget(): void {
    for (const [key, trace] of this.traces) {
      if (this.traces.size > MOST_TRACES && !this.shown.includes(trace)) this.traces.delete(key);
    }
  }
}
