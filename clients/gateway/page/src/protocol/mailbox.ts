// SPDX-License-Identifier: Apache-2.0
// Messages that the WebSocket has received and the thread of the page has not taken yet: one batch at a time, up to a
// limit. Also detects that the page's thread has stopped.

/** One WebSocket message. */
export type Packet = string | ArrayBuffer;

export interface Batch {
  packets: Packet[];
  /** messages of channels that were dropped before this batch, because the page was too slow */
  dropped: number;
}

const MESSAGE_DATA = 1;
const MOST_BYTES = 32 << 20; // 6 s of 1,024 axes

/** Only messages of channels may be dropped: all others are answers. */
function isData(packet: Packet): boolean {
  return typeof packet !== "string" && new DataView(packet).getUint8(0) === MESSAGE_DATA;
}

function sizeOf(packet: Packet): number {
  return typeof packet === "string" ? packet.length : packet.byteLength;
}

export class Mailbox {
  private waiting: Packet[] = [];
  private bytes = 0;
  private dropped = 0;
  private underWay = false;
  private unanswered = 0;

  /**
   * @param deliver sends a batch to the page, which answers with `taken`
   * @param most [bytes] that may wait
   */
  constructor(
    private readonly deliver: (batch: Batch) => void,
    private readonly most = MOST_BYTES,
  ) {}

  put(packet: Packet): void {
    this.waiting.push(packet);
    this.bytes += sizeOf(packet);
    while (this.bytes > this.most) {
      const oldest = this.waiting.findIndex(isData);
      if (oldest < 0) break;
      this.bytes -= sizeOf(this.waiting[oldest]);
      this.waiting.splice(oldest, 1);
      ++this.dropped;
    }
    if (!this.underWay) this.send();
  }

  /** The page has taken the last batch. */
  taken(): void {
    this.underWay = false;
    this.unanswered = 0;
    if (this.waiting.length > 0) this.send();
  }

  /** Drops waiting messages: their connection has ended. */
  clear(): void {
    this.waiting = [];
    this.bytes = 0;
    this.dropped = 0;
  }

  /**
   * Asks the page for an answer, unless one is pending. Must be called at fixed intervals by the worker: if the worker
   * itself is late, it also asks late, so the page is not blamed.
   *
   * @return how many times in a row the same answer was pending
   */
  ask(): number {
    if (this.underWay) return ++this.unanswered;
    this.send();
    return 0;
  }

  private send(): void {
    const batch = { packets: this.waiting, dropped: this.dropped };
    this.clear();
    this.underWay = true;
    this.deliver(batch);
  }
}
