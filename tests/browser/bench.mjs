// SPDX-License-Identifier: Apache-2.0
// A service, a gateway and a browser for testing the page.
import { chromium } from "playwright-core";
import { spawn } from "node:child_process";
import { createInterface } from "node:readline";

const BIN = process.env.VDRIVE_BIN;
const DOMAIN = process.env.VDRIVE_DOMAIN;
const BROWSER = process.env.VDRIVE_BROWSER ?? "/usr/bin/chromium";
export const PATIENCE_MS = 60_000; // on a busy machine a browser can stall for many seconds

const programs = new Set();

/** A running program; it has ended once `stop` returns. */
class Program {
  constructor(name, options) {
    this.child = spawn(`${BIN}/${name}`, ["--domain", DOMAIN, ...options], { stdio: ["ignore", "pipe", "pipe"] });
    this.ended = new Promise((resolve) => this.child.once("exit", resolve));
    this.errors = "";
    this.child.stderr.on("data", (data) => (this.errors += data));
    this.lines = createInterface({ input: this.child.stdout })[Symbol.asyncIterator]();
    programs.add(this);
  }

  async stop(signal = "SIGTERM") {
    this.child.kill(signal);
    await this.ended;
    programs.delete(this);
  }
}

/** Runs the tool until it ends. @return its exit code. */
export async function runTool(...words) {
  const tool = new Program("vdrive", words);
  const code = await tool.ended;
  programs.delete(tool);
  return code;
}

export function startService(...options) {
  return new Program("vdrived", ["--log-level", "warn", ...options]);
}

/** Three axes with a long watchdog time, since a busy machine may stall the gateway. */
export function startPatientService() {
  return startService("--config", `${process.env.VDRIVE_ROOT}/tests/data/patient.yaml`, "--axes", "3");
}

/** @param port 0 = any free port. @return the program; `address` is the URL of its page. */
export async function startGateway(port, ...options) {
  const gateway = new Program("vdrive-gateway", ["--listen", `127.0.0.1:${port}`, ...options]);
  const line = await Promise.race([gateway.lines.next(), gateway.ended.then(() => undefined)]);
  gateway.address = /http:\S+/.exec(line?.value ?? "")?.[0];
  if (gateway.address === undefined) throw new Error(`vdrive-gateway did not start: ${gateway.errors}`);
  gateway.port = Number(new URL(gateway.address).port);
  return gateway;
}

export function startBrowser() {
  // Without the sandbox, it also runs as root. It only loads our own page.
  return chromium.launch({ executablePath: BROWSER, args: ["--no-sandbox"] });
}

export async function stopAll() {
  await Promise.all([...programs].map((program) => program.stop("SIGKILL")));
}

/** Calls a service of the gateway from within a page, bypassing its controls. */
export function callService(page, service, request) {
  return page.evaluate(
    ([name, body]) =>
      new Promise((resolve, reject) => {
        const socket = new WebSocket(`ws://${location.host}/`, ["foxglove.sdk.v1"]);
        socket.binaryType = "arraybuffer";
        socket.onerror = () => reject(new Error("no connection"));
        socket.onmessage = ({ data }) => {
          if (typeof data !== "string") {
            if (new DataView(data).getUint8(0) !== 3) return;
            resolve(JSON.parse(new TextDecoder().decode(new Uint8Array(data, 17))));
            socket.close();
            return;
          }
          const message = JSON.parse(data);
          const found = message.op === "advertiseServices" && message.services.find((s) => s.name === name);
          if (!found) return;
          const payload = new TextEncoder().encode(`json${JSON.stringify(body)}`);
          const frame = new Uint8Array(13 + payload.length);
          const view = new DataView(frame.buffer);
          view.setUint8(0, 2);
          view.setUint32(1, found.id, true);
          view.setUint32(5, 1, true);
          view.setUint32(9, 4, true);
          frame.set(payload, 13);
          socket.send(frame);
        };
      }),
    [service, request],
  );
}
