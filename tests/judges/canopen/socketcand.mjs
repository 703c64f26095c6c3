// SPDX-License-Identifier: Apache-2.0
// A client of a socketcand server in raw mode (linux-can/socketcand, doc/protocol.md).
import { EventEmitter } from "node:events";
import net from "node:net";

/** Emits "frame" with {id, data}, and "close". */
export class SocketcandClient extends EventEmitter {
  static async connect(host, port, channel = "can0") {
    const client = new SocketcandClient();
    await client.#open(host, port, channel);
    return client;
  }

  #socket;
  #text = "";
  #answers = [];

  async #open(host, port, channel) {
    this.#socket = net.connect(port, host);
    this.#socket.setNoDelay(true);
    this.#socket.on("data", (part) => this.#take(part.toString("ascii")));
    this.#socket.on("error", (error) => this.emit("close", error));
    this.#socket.on("close", () => this.emit("close", new Error("the server has closed")));
    await this.#answer("< hi >");
    for (const request of [`< open ${channel} >`, "< rawmode >"]) {
      const answer = this.#answer("< ok >");
      this.#socket.write(request);
      await answer;
    }
  }

  #answer(expected) {
    return new Promise((resolve, reject) => {
      this.#answers.push((word) =>
        word === expected ? resolve() : reject(new Error(`${word} instead of ${expected}`)),
      );
    });
  }

  #take(part) {
    this.#text += part;
    for (;;) {
      const begin = this.#text.indexOf("<");
      const end = this.#text.indexOf(">", begin);
      if (begin < 0 || end < 0) return;
      const word = this.#text.slice(begin, end + 1);
      this.#text = this.#text.slice(end + 1);
      const frame = /^< frame ([0-9A-F]{3}) [0-9]+\.[0-9]{6} ([0-9A-F]*) >$/.exec(word);
      if (frame) {
        this.emit("frame", { id: parseInt(frame[1], 16), data: Buffer.from(frame[2], "hex") });
      } else if (this.#answers.length) {
        this.#answers.shift()(word);
      } else {
        this.emit("close", new Error(`a word that nobody waits for: ${word}`));
      }
    }
  }

  send(id, data) {
    const bytes = [...data].map((byte) => byte.toString(16).padStart(2, "0"));
    const words = ["send", id.toString(16).padStart(3, "0"), String(data.length), ...bytes];
    this.#socket.write(`< ${words.join(" ")} >`);
  }
}
