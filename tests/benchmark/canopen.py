#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The cost of CANopen nodes, as a master on the socketcand server of a private bench sees it.

  canopen.py [--only bus|sdo|steps] [--nodes 127] [--seconds 10] [--reads 5000] [--rounds 3]
             [--build build/release]

  bus     every node sends four TPDOs at each SYNC, 100 times a second in real time, while its axis
          turns: cores of the program and of this client, TPDOs lost, and the time from a SYNC to its
          last TPDO
  sdo     SDO uploads of an object of the drive in real time at ticks of 1 ms, one after the other:
          round trip with a pause of random length before each, and without
  steps   three nodes follow positions at 1 kHz, stepped by SYNC: the wall time of 10 s of drive time

Prints one JSON line for each figure; the rest, such as the program's counts, goes to standard error.
Needs the target vdrive-canopen, and a machine without other work.
"""
import argparse
import collections
import json
import math
import os
import pathlib
import random
import re
import select
import signal
import socket
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
FRAME = re.compile(rb"< frame ([0-9A-Fa-f]+) [0-9.]+ ([0-9A-Fa-f]*) ?>")
PATIENCE = 10  # s; for any single wait of this program
SYNC = b"< send 080 0  >"
START_ALL = (0x000, b"\x01\x00")


def figure(name, value, nodes):
    print(json.dumps({"figure": name, "axes": nodes, "value": round(value, 4)}), flush=True)


def processor_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def quantile(times, share):
    return sorted(times)[min(len(times) - 1, int(len(times) * share))]


class Program:
    """vdrive-canopen with a private bench, until the end of the block."""

    def __init__(self, build, nodes, *options):
        self._process = subprocess.Popen(
            [build / "bin/vdrive-canopen", "--private", "--axes", str(nodes), "--socketcand",
             "127.0.0.1:0", *options], stdout=subprocess.PIPE, text=True)
        self.pid = self._process.pid
        line = self._process.stdout.readline()
        port = re.search(r"socketcand 127\.0\.0\.1:(\d+)", line)
        if not port:
            raise RuntimeError(f"vdrive-canopen does not name its port: {line!r}")
        self.port = int(port[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.send_signal(signal.SIGINT)
        print(self._process.communicate(timeout=PATIENCE)[0], end="", file=sys.stderr)


class Bus:
    """A client of the socketcand server. Frames are pairs of identifier and data."""

    def __init__(self, port):
        self._socket = socket.create_connection(("127.0.0.1", port), PATIENCE)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._text = b""
        for request in (b"", b"< open can0 >", b"< rawmode >"):
            self._socket.sendall(request)
            while b">" not in self._text:
                self._text += self._socket.recv(4096)
            self._text = b""

    def send_text(self, text):
        self._socket.sendall(text)

    def send(self, *frames):
        self.send_text(b"".join(text_of(*frame) for frame in frames))

    def receive(self, seconds):
        """Waits at most this time for frames. @return those that have arrived"""
        if not select.select([self._socket], [], [], max(0, seconds))[0]:
            return []
        received = self._socket.recv(1 << 20)
        if not received:
            raise EOFError("the server closed the connection")
        whole, bracket, self._text = (self._text + received).rpartition(b">")
        return [(int(cob_id, 16), data) for cob_id, data in FRAME.findall(whole + bracket)]

    def receive_frames(self, beginning, count):
        """@return the text of at least `count` frames with this beginning, and of any others between them"""
        text = b""
        while text.count(beginning) < count or not text.endswith(b">"):
            received = self._socket.recv(1 << 16)
            if not received:
                raise EOFError("the server closed the connection")
            text += received
        return text

    def transfer(self, node, request):
        """Sends an SDO request of one frame. @return the answer"""
        self.send((0x600 + node, request))
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            for cob_id, data in self.receive(deadline - time.monotonic()):
                if cob_id == 0x580 + node:
                    answer = bytes.fromhex(data.decode())
                    if answer[0] == 0x80:
                        raise RuntimeError(f"node {node} aborts {request.hex()}: {answer.hex()}")
                    return answer
        raise TimeoutError(f"node {node} does not answer {request.hex()}")

    def write(self, node, index, subindex, value, size):
        specifier = {1: 0x2F, 2: 0x2B, 4: 0x23}[size]
        self.transfer(node, bytes([specifier, index & 0xFF, index >> 8, subindex])
                      + value.to_bytes(size, "little", signed=value < 0).ljust(4, b"\0"))

    def read(self, node, index, subindex=0):
        answer = self.transfer(node, bytes([0x40, index & 0xFF, index >> 8, subindex, 0, 0, 0, 0]))
        return int.from_bytes(answer[4:8 - (answer[0] >> 2 & 3)], "little", signed=True)


def text_of(cob_id, data):
    return b"< send %03X %d %s >" % (cob_id, len(data), data.hex(" ").encode())


def enable(bus, nodes, mode):
    for node in nodes:
        bus.write(node, 0x6060, 0, mode, 1)
        for word in (0x06, 0x0F):
            bus.write(node, 0x6040, 0, word, 2)


def tpdos(frames):
    """How many of the frames are TPDOs of the predefined connection set."""
    return sum(1 for cob_id, _ in frames if 0x180 < cob_id < 0x500 and cob_id & 0x80)


def synchronise(bus, seconds, period, expected):
    """Sends a SYNC each period. @return the number of SYNCs, the number of TPDOs, and the time from SYNC to
    last TPDO [s] for each SYNC whose TPDOs all came before the next SYNC"""
    syncs, received, times = 0, 0, []
    begin = due = time.monotonic()
    sent, missing = begin, 0
    while True:
        now = time.monotonic()
        if now >= due:
            if now - begin >= seconds:
                break
            bus.send_text(SYNC)
            syncs, sent, missing, due = syncs + 1, now, expected, due + period
        arrived = tpdos(bus.receive(due - time.monotonic()))
        received += arrived
        missing -= arrived
        if arrived and missing == 0:
            times.append(time.monotonic() - sent)
    deadline = time.monotonic() + 1
    while received < syncs * expected and time.monotonic() < deadline:
        received += tpdos(bus.receive(0.1))
    return syncs, received, times


def measure_bus(options):
    nodes = range(1, options.nodes + 1)
    with Program(options.build, options.nodes, "--clock", "realtime") as program:
        bus = Bus(program.port)
        for node in nodes:
            for number in range(4):
                bus.write(node, 0x1800 + number, 2, 1, 1)
        enable(bus, nodes, 3)
        for node in nodes:
            bus.write(node, 0x60FF, 0, 1000 + 10 * node, 4)
        spent = processor_seconds(program.pid)
        time.sleep(options.seconds)
        resting = processor_seconds(program.pid) - spent
        bus.send(START_ALL)
        own, spent = time.process_time(), processor_seconds(program.pid)
        syncs, received, times = synchronise(bus, options.seconds, 0.01, 4 * options.nodes)
        spent, own = processor_seconds(program.pid) - spent, time.process_time() - own
    figure("canopen_bus_without_sync_cores", resting / options.seconds, options.nodes)
    figure("canopen_bus_cores", spent / options.seconds, options.nodes)
    figure("canopen_bus_client_cores", own / options.seconds, options.nodes)
    figure("canopen_bus_frames_per_second", received / options.seconds, options.nodes)
    figure("canopen_bus_lost", syncs * 4 * options.nodes - received, options.nodes)
    figure("canopen_bus_syncs_not_answered_in_time", syncs - len(times), options.nodes)
    if times:
        figure("canopen_bus_last_tpdo_p50_ms", 1000 * statistics.median(times), options.nodes)
        figure("canopen_bus_last_tpdo_p99_ms", 1000 * quantile(times, 0.99), options.nodes)
        figure("canopen_bus_last_tpdo_longest_ms", 1000 * max(times), options.nodes)


def round_trips(bus, reads, longest_pause):
    """The times of SDO uploads [s], with a pause of random length before each."""
    pauses = random.Random(1)
    times = []
    for _ in range(reads):
        if longest_pause:
            time.sleep(pauses.uniform(0, longest_pause))
        begin = time.perf_counter()
        bus.read(1, 0x6041)
        times.append(time.perf_counter() - begin)
    return times


def measure_sdo(options):
    with Program(options.build, 1, "--clock", "realtime") as program:
        bus = Bus(program.port)
        for name, longest_pause in (("canopen_sdo", 0.002), ("canopen_sdo_at_once", 0)):
            times = round_trips(bus, options.reads, longest_pause)
            figure(f"{name}_p50_ms", 1000 * statistics.median(times), 1)
            figure(f"{name}_p99_ms", 1000 * quantile(times, 0.99), 1)


def follow(bus, nodes, targets):
    """Sends a target to each node, then SYNC, and waits for the TPDO of each node, again and again. The
    frames are made before the measured time and decoded after it.
    @return that time [s], and the highest position that a node showed"""
    commands = [b"\x0f\x00" + target.to_bytes(4, "little", signed=True) for target in targets]
    messages = [b"".join(text_of(0x400 + node, command) for node in nodes) + SYNC
                for command in commands]
    received = []
    begin = time.monotonic()
    for message in messages:
        bus.send_text(message)
        received.append(bus.receive_frames(b"< frame 38", len(nodes)))
    duration = time.monotonic() - begin
    statuswords, highest = collections.Counter(), 0
    for _, data in FRAME.findall(b"".join(received)):
        shown = bytes.fromhex(data.decode())
        statuswords[f"{int.from_bytes(shown[:2], 'little'):04X}"] += 1
        highest = max(highest, int.from_bytes(shown[2:], "little", signed=True))
    print(f"statuswords: {dict(statuswords)}", file=sys.stderr)
    return duration, highest


def measure_steps(options):
    nodes = range(1, 4)
    top = 4000
    to_and_fro = [round(top / 2 * (1 - math.cos(2 * math.pi * step / 10_000)))
                  for step in range(1, 10_001)]
    with Program(options.build, 3, "--sync-steps", "1ms") as program:
        bus = Bus(program.port)
        for node in nodes:
            bus.write(node, 0x1402, 2, 1, 1)  # RPDO3: 6040h and 607Ah
            bus.write(node, 0x1802, 2, 1, 1)  # TPDO3: 6041h and 6064h
            for number in (0, 1, 3):  # bit 31: not used
                bus.write(node, 0x1800 + number, 1, 0x80000180 + 0x100 * number + node, 4)
            bus.write(node, 0x6060, 0, 8, 1)
        bus.send(START_ALL)
        follow(bus, nodes, [0] * 100)  # in this time the axes become enabled
        for _ in range(options.rounds):
            own, spent = time.process_time(), processor_seconds(program.pid)
            duration, highest = follow(bus, nodes, to_and_fro)
            spent, own = processor_seconds(program.pid) - spent, time.process_time() - own
            figure("canopen_steps_10_s_in_s", duration, 3)
            figure("canopen_steps_10_s_processor_s", spent, 3)
            figure("canopen_steps_10_s_processor_of_client_s", own, 3)
            if abs(highest - top) > 50:
                raise RuntimeError(f"the nodes did not follow to {top}, but to {highest}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--only", choices=("bus", "sdo", "steps"))
    parser.add_argument("--nodes", type=int, default=127)
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--reads", type=int, default=5000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    options = parser.parse_args()
    for name, measure in (("bus", measure_bus), ("sdo", measure_sdo), ("steps", measure_steps)):
        if options.only in (None, name):
            measure(options)


if __name__ == "__main__":
    main()
