// SPDX-License-Identifier: Apache-2.0
// The samples of one axis in every tick, received from its trace channel.

import { CONTROLWORD, Samples } from "./data/samples";
import { heldSetPoints } from "./data/setpoints";
import { addressOf, topicOf, type AxisRef, type Model } from "./model";
import type { Message } from "./protocol/cdr";

export const LONGEST_WINDOW_S = 600;
const MOST_SAMPLES = 1_200_000;
const CONTROLWORD_EVERY_MS = 200;

function period(ref: AxisRef): number {
  return (ref.bench.description?.period_us ?? 1000) * 1e-6;
}

export class Trace extends Samples {
  owner = 0n;
  private reading = false;
  private droppedBefore = 0;
  private ends: (() => void)[] = [];
  private timer = 0;

  constructor(
    private readonly model: Model,
    readonly ref: AxisRef,
  ) {
    const { axis, name, unit } = ref.axis;
    super(
      { address: addressOf(ref), bench: ref.bench.number, axis, name, unit },
      {
        period: period(ref),
        isRegular: ref.bench.description?.clock_mode !== "freerun",
        capacity: Math.min(MOST_SAMPLES, LONGEST_WINDOW_S / period(ref)),
        hasControlword: true,
      },
    );
  }

  /** Starts receiving. Earlier samples are kept, followed by a gap. */
  open(): void {
    if (this.ends.length > 0) return;
    const topic = topicOf(this.ref);
    this.ends = [
      this.model.connection.subscribe(`${topic}/trace`, (message) => this.receive(message)),
      this.model.connection.subscribe(`${topic}/status`, (message) => {
        this.owner = message["owner_session"] as bigint;
      }),
    ];
  }

  /** Stops receiving. */
  close(): void {
    this.show(false);
    for (const end of this.ends) end();
    this.ends = [];
    this.leave();
  }

  /** While a view shows the axis, polls its controlword, which no topic contains. */
  show(on: boolean): void {
    window.clearInterval(this.timer);
    this.timer = 0;
    if (!on) return;
    this.timer = window.setInterval(() => void this.readControlword(), CONTROLWORD_EVERY_MS);
    void this.readControlword();
  }

  get isShown(): boolean {
    return this.timer !== 0;
  }

  private receive(message: Message): void {
    const { dropped } = this.model.connection;
    this.take(message, dropped !== this.droppedBefore);
    this.droppedBefore = dropped;
  }

  /** Controlword, statusword and mode of one tick. */
  private async readControlword(): Promise<void> {
    if (!this.model.connected || this.reading) return;
    this.reading = true;
    const objects = [CONTROLWORD, "0x6041", "0x6061"];
    const answer = await this.model.connection.call("/read", { axis: this.axis.address, objects });
    this.reading = false;
    const values = (answer["values"] as { value?: number; code?: number }[] | undefined)?.map((v) => (v.code === 0 ? v.value : undefined));
    const [control, status, mode] = values ?? [];
    this.controlword = control;
    const known = control !== undefined && status !== undefined && mode !== undefined;
    this.setPoints = known ? heldSetPoints(control, status, mode) : undefined;
  }
}
