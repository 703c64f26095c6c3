#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Debian's tshark agrees with the judge about every frame that it decodes.

  bus_log.py PRINT_FRAMES WORK

PRINT_FRAMES of this build prints the kind of each frame in a log: each identifier of the base
format once, the log of the guide, and 5,000 random frames. tshark decodes the same frames as
CANopen. Exit code 0: they agree; 77: tshark is missing.
"""
import pathlib
import random
import re
import shutil
import struct
import subprocess
import sys

from gateway import fail, skip

LINKTYPE_CAN_SOCKETCAN = 227  # https://www.tcpdump.org/linktypes.html
GUIDE = pathlib.Path(__file__).resolve().parents[2] / "docs/guides/one_move.candump"
PATIENCE = 120  # [s]

# The beginning of tshark's description, by our name of the kind.
KINDS = {"NMT Error Control": "heartbeat", "NMT": "nmt", "SYNC": "sync", "EMCY": "emergency",
         "TIME STAMP": "time_stamp", "Default-SDO (tx)": "sdo_response", "Default-SDO (rx)": "sdo_request",
         "LSS": "lss", "Unknown": "foreign"}
BROADCAST = ("nmt", "sync", "time_stamp", "lss", "foreign")


def kind_of(text):
    if re.match(r"PDO\d \(tx\)", text):
        return "transmit_pdo"
    if re.match(r"PDO\d \(rx\)", text):
        return "receive_pdo"
    for begin, kind in KINDS.items():
        if text.startswith(begin):
            return kind
    return fail(f"tshark says {text!r}, which has no row")


def usual_data(identifier):
    """Random data of the length required by the kind."""
    if identifier == 0:
        return bytes([1, 5])
    if identifier == 0x080:
        return b""
    if identifier == 0x100:
        return bytes(6)
    return bytes([5]) if identifier & 0x780 == 0x700 else bytes(8)


def frames_of_guide():
    for line in GUIDE.read_text(encoding="ascii").splitlines():
        identifier, data = line.split()[2].split("#")
        yield int(identifier, 16), bytes.fromhex(data)


def any_frames(count):
    numbers = random.Random(53)
    for _ in range(count):
        identifier = numbers.randrange(0x800)
        # tshark describes a frame of NMT error control by its content, so it needs at least one
        # byte.
        least = 1 if identifier & 0x780 == 0x700 else 0
        # Zeros: with other data, an SDO could configure PDOs with identifiers that tshark does not learn of.
        yield identifier, bytes(numbers.randint(least, 8))


def write_log(path, frames):
    lines = [f"({number // 1000:010}.{number % 1000:03}000) can0 {identifier:03X}#{data.hex().upper()}\n"
             for number, (identifier, data) in enumerate(frames)]
    path.write_text("".join(lines), encoding="ascii")


def write_capture(path, frames):
    """A pcap file of SocketCAN frames, in host byte order except for the identifier."""
    with path.open("wb") as file:
        file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, LINKTYPE_CAN_SOCKETCAN))
        for number, (identifier, data) in enumerate(frames):
            packet = struct.pack(">IBxxx", identifier, len(data)) + data
            file.write(struct.pack("<IIII", number // 1000, number % 1000, len(packet), len(packet)) + packet)


def theirs(path):
    done = subprocess.run(["tshark", "-n", "-d", "can.subdissector,canopen", "-r", path, "-T", "fields", "-e",
                           "canopen.node_id", "-e", "_ws.col.Info"], capture_output=True, text=True, timeout=PATIENCE)
    if done.returncode != 0:
        fail(f"tshark: {done.stderr.strip()}")
    for line in done.stdout.splitlines():
        node, text = line.split("\t")
        kind = kind_of(text)
        yield kind, 0 if kind in BROADCAST else int(node, 16)


def ours(program, path):
    done = subprocess.run([program, path], capture_output=True, text=True, check=True, timeout=PATIENCE)
    for line in done.stdout.splitlines():
        kind, node = line.split()
        yield kind, int(node)


def main():
    program, work = sys.argv[1], pathlib.Path(sys.argv[2])
    if not shutil.which("tshark"):
        skip("tshark is not installed")
    work.mkdir(parents=True, exist_ok=True)
    frames = [(identifier, usual_data(identifier)) for identifier in range(0x800)]
    frames += list(frames_of_guide()) + list(any_frames(5000))
    write_log(work / "frames.candump", frames)
    write_capture(work / "frames.pcap", frames)
    pairs = list(zip(frames, ours(program, work / "frames.candump"), theirs(work / "frames.pcap"), strict=True))
    for (identifier, data), our, their in pairs:
        if our != their:
            fail(f"{identifier:03X}#{data.hex()} is {our}, tshark says {their}")
    print(f"{len(pairs)} frames: tshark agrees about the kind and the node of each")


if __name__ == "__main__":
    main()
