// SPDX-License-Identifier: Apache-2.0
// The source of a scope's samples: the benches, or a recording.

import type { EventFeed } from "./data/events";
import type { SampledAxis, Samples } from "./data/samples";
import { addressOf, type AxisRef, type Model } from "./model";
import type { Traces } from "./traces";

export interface Source {
  /** New samples arrive while it is shown. */
  readonly isLive: boolean;
  /** axes that a scope can show */
  axes(): SampledAxis[];
  /** @return the samples of these axes, by address; an axis that does not exist has no entry. Live axes are received
   *          from now on. */
  open(addresses: readonly string[]): Map<string, Samples>;
  readonly events: EventFeed;
  /** @return the axis on its bench; undefined for an axis of a recording */
  ref(address: string): AxisRef | undefined;
}

export class LiveSource implements Source {
  readonly isLive = true;
  readonly events: EventFeed;

  /** @param always received even if no strip shows it */
  constructor(
    private readonly model: Model,
    private readonly traces: Traces,
    private readonly always?: AxisRef,
  ) {
    this.events = model.events;
  }

  axes(): SampledAxis[] {
    return this.model.axes().map((ref) => {
      const { axis, name, unit } = ref.axis;
      return { address: addressOf(ref), bench: ref.bench.number, axis, name, unit };
    });
  }

  open(addresses: readonly string[]): Map<string, Samples> {
    const wanted = new Set([...(this.always === undefined ? [] : [addressOf(this.always)]), ...addresses]);
    const refs = [...wanted].flatMap((address) => this.model.find(address) ?? []);
    return new Map(this.traces.show(refs).map((trace) => [trace.axis.address, trace]));
  }

  ref(address: string): AxisRef | undefined {
    return this.model.find(address);
  }
}
