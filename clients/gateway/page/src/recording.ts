// SPDX-License-Identifier: Apache-2.0
// A recording as a scope shows it.

import type { EventFeed } from "./data/events";
import { MOST_RECORDED_BYTES, type Recorded } from "./data/recorded";
import type { SampledAxis, Samples } from "./data/samples";
import type { Source } from "./source";

interface Reader {
  append(bytes: Uint8Array): void;
  finish(): Recorded;
}

/** First byte of MCAP; CSV never begins with it. */
const MCAP_MAGIC = 0x89;

export class Recording implements Source {
  readonly isLive = false;
  readonly events: EventFeed;
  private readonly samples: Map<string, Samples>;

  /** @param cut why the file is incomplete; "" if it is complete */
  constructor(
    readonly name: string,
    { axes, events, period }: Recorded,
    readonly cut: string,
  ) {
    this.samples = new Map(axes.map((axis) => [axis.address, axis.finish(period)]));
    this.events = { events, version: 0 };
  }

  axes(): SampledAxis[] {
    return [...this.samples.values()].map(({ axis }) => axis);
  }

  open(addresses: readonly string[]): Map<string, Samples> {
    return new Map([...this.samples].filter(([address]) => addresses.includes(address)));
  }

  ref(): undefined {
    return undefined;
  }
}

/** The MCAP reader is large and rarely needed, so it is loaded on demand. */
async function readerOf(first: Uint8Array): Promise<Reader> {
  if (first[0] === MCAP_MAGIC) return new (await import("./data/recorded_mcap")).McapReader();
  const { CsvReader } = await import("./data/recorded_csv");
  const reader = new CsvReader();
  const decoder = new TextDecoder();
  return { append: (bytes) => reader.append(decoder.decode(bytes, { stream: true })), finish: () => reader.finish() };
}

/** @param progress called with the share that has been read, 0 to 1
 *  @throws Error that names the file, the place and what is wrong */
export async function openRecording(file: File, progress: (share: number) => void): Promise<Recording> {
  try {
    if (file.size > MOST_RECORDED_BYTES) throw new Error(`${file.size} bytes: the limit is ${MOST_RECORDED_BYTES}`);
    if (file.size === 0) throw new Error("the file is empty");
    const stream = file.stream().getReader();
    let reader: Reader | undefined;
    let read = 0;
    for (let part = await stream.read(); !part.done; part = await stream.read()) {
      reader ??= await readerOf(part.value);
      reader.append(part.value);
      read += part.value.byteLength;
      progress(read / file.size);
      await new Promise((resolve) => setTimeout(resolve)); // lets messages and keys be handled
    }
    const recorded = reader?.finish();
    if (recorded === undefined) throw new Error("the file is empty");
    return new Recording(file.name, recorded, recorded.cut);
  } catch (error) {
    throw new Error(`${file.name}: ${(error as Error).message}`);
  }
}
