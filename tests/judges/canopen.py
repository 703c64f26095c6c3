#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Independent judges of the CANopen nodes.

  canopen.py VDRIVE VDRIVE_CANOPEN WORK

In both clocks: the master of the package canopen (npm, versions fixed by the lock file) loads the
DCF of each node, boots three nodes, reads all objects in the DCF, remaps PDOs, moves by SDO and by
PDO, streams positions, homes, causes a fault and resets it. Debian's python3-can listens on the
same bus: it must receive every frame in the order in which the master has sent and received them,
and as many as the program counts. Debian's tshark decodes the capture as CANopen and must find no
malformed frame. Then the package's own tests of SDO and PDO run against 126 nodes, as far as
possible, with a line for the outcome of each. WORK is a directory for the npm packages. Exit code
0: all agree; 77: a judge is missing (no node, no registry, no python3-can, no tshark).
"""
import json
import logging
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import threading
import time

from gateway import Programs, fail, install, skip

NODES = 3
NODES_OF_OWN_TESTS = 126
PERIOD = "10ms"
PATIENCE = 120  # [s]
OF_WORDS = re.compile(r"handshake-|state-|homing-|motion-[1239]$")
LINKTYPE_CAN_SOCKETCAN = 227  # https://www.tcpdump.org/linktypes.html
HIGHEST_BASE_ID = 0x7FF


def load_can():
    """python-can; without it the test is skipped."""
    try:
        import can
    except ImportError:
        skip("python3-can is not installed")
    logging.getLogger("can").setLevel(logging.ERROR)  # it warns of each word that comes in two parts
    return can


class Bus:
    """vdrive-canopen with a private bench."""

    def __init__(self, program, clock, programs, nodes=NODES, more=()):
        options = ["--clock", clock] + (["--sync-steps", PERIOD] if clock == "lockstep" else [])
        options += more
        self.process = programs.start(program, "--private", "--axes", str(nodes), "--socketcand",
                                      "127.0.0.1:0", *options, stdout=subprocess.PIPE)
        line = self.process.stdout.readline()
        place = re.search(r"socketcand ([\d.]+):(\d+)", line)
        if place is None:
            fail(f"the first line of vdrive-canopen: {line!r}")
        self.host, self.port = place[1], int(place[2])

    def end(self):
        """End the program; return the number of frames that it counted."""
        self.process.terminate()
        output, _ = self.process.communicate(timeout=PATIENCE)
        counted = re.search(r"(\d+) frames", output)
        if self.process.returncode != 0 or counted is None:
            fail(f"vdrive-canopen ended with {self.process.returncode}: {output!r}")
        return int(counted[1])


class Listener:
    """python3-can on the bus, in a separate thread."""

    def __init__(self, can, bus):
        self.messages = []
        self._bus = can.Bus(interface="socketcand", host=bus.host, port=bus.port, channel="can0")
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._listen)
        self._thread.start()

    def _listen(self):
        while not self._is_over.is_set():
            message = self._bus.recv(timeout=0.1)
            if message is not None:
                self.messages.append(message)

    def wait_until(self, condition):
        deadline = time.monotonic() + PATIENCE
        while not condition(self.messages) and time.monotonic() < deadline:
            time.sleep(0.05)

    def close(self):
        self._is_over.set()
        self._thread.join()
        self._bus.shutdown()


def frame_of(message):
    return [message.arbitration_id, bytes(message.data).hex()]


def is_of_master(frame):
    """NMT, SYNC, RPDOs, SDO requests: frames that nodes do not send (CiA 301, table 39)."""
    return frame[0] in (0x000, 0x080) or frame[0] & 0x780 in (0x200, 0x300, 0x400, 0x500, 0x600)


def compare(seen, judged, counted):
    """Compare the frames received by python3-can with those of the master and with the count of
    the bus."""
    for name, frames in (("sent", [frame for frame in seen if is_of_master(frame)]),
                         ("received", [frame for frame in seen if not is_of_master(frame)])):
        expected = judged[name]
        if name == "received":
            frames = frames[:len(expected)]  # nodes may send while the master ends
        for place, (ours, theirs) in enumerate(zip(frames, expected)):
            if ours != theirs:
                fail(f"frame {place} that the master has {name} is {theirs}, python3-can has {ours}")
        if len(frames) != len(expected):
            fail(f"python3-can has {len(frames)} of {len(expected)} frames that the master has {name}")
    # The boot-ups precede python3-can's connection.
    if counted != len(seen) + NODES:
        fail(f"the bus counted {counted} frames: {NODES} boot-ups and {len(seen)} that python3-can received")


def write_capture(path, messages):
    """A pcap file of SocketCAN frames, in host byte order except for the identifier."""
    with path.open("wb") as file:
        file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, LINKTYPE_CAN_SOCKETCAN))
        for message in messages:
            if message.arbitration_id > HIGHEST_BASE_ID:
                fail(f"an identifier of 29 bits: {message}")
            data = bytes(message.data)
            packet = struct.pack(">IBxxx", message.arbitration_id, len(data)) + data
            seconds = int(message.timestamp)
            microseconds = min(999_999, round((message.timestamp - seconds) * 1e6))
            file.write(struct.pack("<IIII", seconds, microseconds, len(packet), len(packet)) + packet)


def count_of(tshark, path, condition):
    done = subprocess.run([*tshark, "-r", path, "-Y", condition, "-T", "fields", "-e", "frame.number"],
                          capture_output=True, text=True, timeout=PATIENCE)
    if done.returncode != 0:
        fail(f"tshark: {done.stderr.strip()}")
    return len(done.stdout.split())


def decode(path, frames):
    tshark = ["tshark", "-n", "-d", "can.subdissector,canopen"]
    decoded = count_of(tshark, path, "canopen")
    if decoded != frames:
        fail(f"tshark decodes {decoded} of {frames} frames as CANopen")
    malformed = count_of(tshark, path, "_ws.malformed || _ws.expert.severity == error")
    if malformed:
        fail(f"tshark finds {malformed} malformed frames in {path}")


def verdict_of(vdrive, file):
    """The judge's findings, as rule and axis number, and the rules that it could not judge."""
    done = subprocess.run([vdrive, "judge", file, "--json", "--fail-on", "never"], capture_output=True, text=True,
                          timeout=PATIENCE)
    if done.returncode != 0:
        fail(f"vdrive judge {file}: {done.stderr.strip()}")
    *findings, summary = [json.loads(line) for line in done.stdout.splitlines()]
    unjudged = {rule for each in summary["not_judged"] for rule in each["rules"]}
    return {(each["rule"], re.findall(r"\d+", each["axis"])[-1]) for each in findings}, unjudged


def compare_verdicts(vdrive, log, journal):
    """The log of the bus and the journal of its bench have the same findings about words and targets.

    Rules about PDOs, SYNC and NMT apply to the bus only. To a bench, repeated PDOs are commands,
    and its journal shows each tick.
    """
    (of_log, not_log), (of_journal, not_journal) = verdict_of(vdrive, log), verdict_of(vdrive, journal)
    unknown = not_log | not_journal
    differing = {each for each in of_log ^ of_journal if each[0] not in unknown and OF_WORDS.match(each[0])}
    if differing:
        fail(f"of {log}: {sorted(of_log)}, of {journal}: {sorted(of_journal)}: they differ in {sorted(differing)}")
    return len(of_log & of_journal)


def judge(can, vdrive, program, clock, work, programs):
    output, capture = work / f"{clock}.json", work / f"{clock}.pcap"
    for node in range(1, NODES + 1):
        with (work / f"node{node}.dcf").open("w", encoding="ascii") as file:
            subprocess.run([vdrive, "dictionary", "--format", "eds", "--node", str(node)], check=True, stdout=file,
                           timeout=PATIENCE)
    log, journal = work / f"{clock}.candump", work / f"{clock}.journal"
    for file in (log, journal):
        file.unlink(missing_ok=True)
    bus = Bus(program, clock, programs, more=["--log", log, "--journal", journal])
    listener = Listener(can, bus)
    try:
        done = subprocess.run(["node", work / "judge.mjs", bus.host, str(bus.port), work, clock, output],
                              capture_output=True, text=True, timeout=600)
        if done.returncode != 0:
            fail(f"{clock}: {done.stdout}{done.stderr.strip()}")
        judged = json.loads(output.read_text(encoding="ascii"))
        listener.wait_until(lambda messages: len(messages) >= len(judged["sent"]) + len(judged["received"]))
        counted = bus.end()
        listener.wait_until(lambda messages: len(messages) >= counted - NODES)
    finally:
        listener.close()
    compare([frame_of(message) for message in listener.messages], judged, counted)
    write_capture(capture, listener.messages)
    decode(capture, len(listener.messages))
    same = compare_verdicts(vdrive, log, journal)
    print(f"{clock}: log and journal of the run have the same findings, {same} of them")
    print(f"{clock}: {'; '.join(done.stdout.splitlines())}; {len(listener.messages)} frames agree, and "
          "tshark decodes them")


def run_own_tests(program, clock, work, programs):
    bus = Bus(program, clock, programs, NODES_OF_OWN_TESTS)
    done = subprocess.run(["node", "--no-deprecation", work / "own_tests.mjs", bus.host, str(bus.port),
                           clock], capture_output=True, text=True, timeout=600)
    if done.returncode != 0:
        fail(f"{clock}: {done.stdout}{done.stderr.strip()}")
    bus.end()
    for line in done.stdout.splitlines():
        print(f"{clock}: {line}")


def main():
    vdrive, program, work = sys.argv[1:]
    can = load_can()
    if not shutil.which("tshark"):
        skip("tshark is not installed")
    work = pathlib.Path(work)
    install(work, "canopen")
    programs = Programs()
    try:
        for clock in ("realtime", "lockstep"):
            judge(can, vdrive, program, clock, work, programs)
            run_own_tests(program, clock, work, programs)
    finally:
        programs.end()


if __name__ == "__main__":
    main()
