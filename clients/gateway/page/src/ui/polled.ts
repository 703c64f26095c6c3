// SPDX-License-Identifier: Apache-2.0
// Objects of axes that a view shows next to its controls, polled.

import { addressOf, type AxisRef, type Model } from "../model";

const READ_EVERY_MS = 1_000;

export class PolledObjects {
  /** by the address of the axis, then of the object */
  private readonly values = new Map<string, Map<string, number>>();
  private next = 0;
  private readAt = -Infinity;
  private reading = false;
  /** Increases with each command: values read before it are outdated. */
  private commands = 0;

  /** @param objects such as "0x6098" */
  constructor(
    private readonly model: Model,
    private readonly axes: () => AxisRef[],
    private readonly objects: string[],
  ) {}

  /** @return the latest value; undefined before the first read, or if the drive does not provide it. */
  value(address: string, object: string): number | undefined {
    return this.values.get(address)?.get(object);
  }

  /** Reads one axis per second, because each read is a request to its bench; unread ones come first.
   *  @param root of the view: nothing is read while it is invisible */
  update(now: number, root: HTMLElement): void {
    if (this.reading || !this.model.connected || now - this.readAt < READ_EVERY_MS) return;
    const axes = this.axes();
    if (axes.length === 0 || root.getClientRects().length === 0) return;
    this.readAt = now;
    const unknown = axes.find((ref) => !this.values.has(addressOf(ref)));
    void this.read(addressOf(unknown ?? axes[this.next++ % axes.length]));
  }

  /** A command has written one of these objects. */
  readAgain(): void {
    ++this.commands;
    this.readAt = -Infinity;
  }

  private async read(address: string): Promise<void> {
    const { commands } = this;
    this.reading = true;
    const answer = await this.model.connection.call("/read", { axis: address, objects: this.objects });
    this.reading = false;
    // A failed call says nothing about the values.
    if (commands !== this.commands || answer["values"] === undefined) return;
    const values = new Map<string, number>();
    const read = (answer["values"] ?? []) as { value?: number; code?: number }[];
    read.forEach(({ value, code }, i) => {
      if (value !== undefined && (code ?? 0) === 0) values.set(this.objects[i], value);
    });
    this.values.set(address, values);
  }
}
