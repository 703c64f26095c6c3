#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Independent judges of the gateway.

  gateway.py VDRIVED VDRIVE GATEWAY WORK

Foxglove's client and decoder (npm, versions fixed by the lock file) offer foxglove.websocket.v1 and
decode every tick of a lock-step run: the values must equal those of `vdrive record`. Python's
websockets offers only foxglove.sdk.v1. WORK is a directory for the npm packages.
Exit code 0: all agree; 77: a judge is missing (no node, no registry, no python3-websockets).
"""
import asyncio
import csv
import json
import pathlib
import shutil
import struct
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
DOMAIN = "44"
TICKS = 400
TICKS_AT_ONCE = 20  # the status is best effort: a burst of hundreds loses samples
SKIPPED = 77


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(SKIPPED)


def fail(text):
    print(f"{pathlib.Path(sys.argv[0]).name}: {text}", file=sys.stderr)
    sys.exit(1)


def install(work, judge="foxglove"):
    """Installs the packages of a judge's lock file below `work`."""
    if not shutil.which("npm") or not shutil.which("node"):
        skip("node or npm is not installed")
    shutil.copytree(HERE / judge, work, dirs_exist_ok=True,
                    ignore=shutil.ignore_patterns("node_modules"))
    done = subprocess.run(["npm", "ci", "--no-audit", "--no-fund", "--ignore-scripts"], cwd=work,
                          capture_output=True, text=True, timeout=300)
    if done.returncode != 0:
        skip(f"npm ci failed: {done.stderr.strip()[-300:]}")


class Programs:
    """Programs that end together with the test."""

    def __init__(self):
        self.running = []

    def start(self, *command, **options):
        process = subprocess.Popen(command, text=True, **options)
        self.running.append(process)
        return process

    def end(self):
        for process in reversed(self.running):
            process.terminate()
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()


def first_tick(vdrive):
    status = subprocess.run([vdrive, "--domain", DOMAIN, "--json", "status", "1.1"], check=True,
                            capture_output=True, text=True, timeout=30)
    return json.loads(status.stdout)["tick"], json.loads(status.stdout)["name"]


def compare(recording, judged):
    """Compares every tick of the recording and every member that both have."""
    rows = 0
    for row in csv.DictReader(recording.open()):
        other = judged["ticks"].get(row["tick"])
        if other is None:
            continue  # lost by one of the two, both of which count losses
        members = set(row) & set(other)
        if len(members) < 20:
            fail(f"only {len(members)} members have common names")
        for member in members:
            if int(row[member]) != other[member]:
                fail(f"tick {row['tick']}, {member}: recorded {row[member]}, received {other[member]}")
        rows += 1
    if rows < TICKS * 9 // 10:
        fail(f"only {rows} of {TICKS} ticks came both ways")
    print(f"{rows} ticks agree")


def judge_foxglove(vdrive, port, work, programs):
    begin, name = first_tick(vdrive)
    last = begin + TICKS
    judge = programs.start("node", work / "judge.mjs", str(port), f"/bench1/{name}/trace", str(last),
                           stdout=subprocess.PIPE)
    if judge.stdout.readline() != "ready\n":
        fail("Foxglove's client got no parameter")
    recording = work / "recording.csv"
    recording.unlink(missing_ok=True)
    recorder = programs.start(vdrive, "--domain", DOMAIN, "record", recording, "1.1", "--count",
                              str(TICKS))
    # The recorder is receiving once its file has a header.
    while not (recording.exists() and recording.stat().st_size) and recorder.poll() is None:
        subprocess.run([vdrive, "--domain", DOMAIN, "step", "1"], check=True, capture_output=True)
    steps = [["step", str(TICKS_AT_ONCE)]] * (2 * TICKS // TICKS_AT_ONCE)
    for words in (["enable", "1.1"], ["move", "1.1", "200", "--no-wait"], *steps):
        subprocess.run([vdrive, "--domain", DOMAIN, *words], check=True, capture_output=True,
                       timeout=60)
    if recorder.wait(timeout=60) != 0:
        fail("the recorder failed")
    output, _ = judge.communicate(timeout=60)
    judged = json.loads(output)
    compare(recording, judged)
    if judged["parameter"]["value"] != judged["read"]["values"][0]["value"]:
        fail("the parameter and /read differ in 6502h")


async def judge_websockets(port):
    try:
        import websockets
    except ImportError:
        skip("python3-websockets is not installed")
    async with websockets.connect(f"ws://127.0.0.1:{port}/", subprotocols=["foxglove.sdk.v1"],
                                  max_size=None) as socket:
        if socket.subprotocol != "foxglove.sdk.v1":
            fail(f"websockets got the sub-protocol {socket.subprotocol}")
        info = json.loads(await socket.recv())
        if info["op"] != "serverInfo":
            fail(f"the first message is {info['op']}")
        channel = None
        while channel is None:
            message = json.loads(await asyncio.wait_for(socket.recv(), 10))
            for candidate in message.get("channels", []):
                if candidate["topic"] == "/bench1/description":
                    channel = candidate
        await socket.send(json.dumps({"op": "subscribe",
                                      "subscriptions": [{"id": 3, "channelId": channel["id"]}]}))
        while True:
            message = await asyncio.wait_for(socket.recv(), 10)
            if isinstance(message, bytes) and message[0] == 1:
                break
        subscription, _ = struct.unpack_from("<IQ", message, 1)
        if subscription != 3 or json.loads(message[13:])["bench"] != 1:
            fail("websockets received another message than it subscribed")
    try:
        await websockets.connect(f"ws://127.0.0.1:{port}/", subprotocols=["another"])
        fail("another sub-protocol was accepted")
    except websockets.exceptions.InvalidStatusCode as refused:
        if refused.status_code != 400:
            fail(f"another sub-protocol was answered with {refused.status_code}")
    print("websockets agrees")


def main():
    vdrived, vdrive, gateway, work = sys.argv[1:]
    work = pathlib.Path(work)
    install(work)
    programs = Programs()
    try:
        programs.start(vdrived, "--domain", DOMAIN, "--clock", "lockstep", "--log-level", "error")
        subprocess.run([vdrive, "--domain", DOMAIN, "--timeout", "20", "list"], check=True,
                       capture_output=True, timeout=60)
        server = programs.start(gateway, "--domain", DOMAIN, "--listen", "127.0.0.1:0",
                                stdout=subprocess.PIPE)
        port = int(server.stdout.readline().split("127.0.0.1:")[1].split("/")[0])
        asyncio.run(judge_websockets(port))
        judge_foxglove(vdrive, port, work, programs)
    finally:
        programs.end()


if __name__ == "__main__":
    main()
