#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A name server for the hosts of a test.

  name_server.py ADDRESS FILE

Answers DNS queries on port 53 of ADDRESS from FILE, a JSON object of names and lists of IPv4
addresses that is read again for each query. Names that are not in it do not exist (RFC 1035)."""

import json
import pathlib
import socket
import struct
import sys

A = 1
RESPONSE_RECURSION_AVAILABLE = 0x8180
NO_SUCH_NAME = 3
TIME_TO_LIVE = 0  # [s]


def answer(query, names):
    identifier, _, questions, _, _, _ = struct.unpack("!6H", query[:12])
    labels = []
    place = 12
    while query[place] != 0:
        length = query[place]
        labels.append(query[place + 1:place + 1 + length].decode("ascii").lower())
        place += 1 + length
    kind, _ = struct.unpack("!2H", query[place + 1:place + 5])
    question = query[12:place + 5]
    addresses = names.get(".".join(labels))
    found = addresses if kind == A and addresses else []
    flags = RESPONSE_RECURSION_AVAILABLE | (NO_SUCH_NAME if addresses is None else 0)
    records = b"".join(
        struct.pack("!3HIH", 0xC00C, A, 1, TIME_TO_LIVE, 4) + socket.inet_aton(address)
        for address in found)
    return struct.pack("!6H", identifier, flags, questions, len(found), 0, 0) + question + records


def main():
    address, file = sys.argv[1], pathlib.Path(sys.argv[2])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as port:
        port.bind((address, 53))
        print("ready", flush=True)
        while True:
            query, sender = port.recvfrom(512)
            port.sendto(answer(query, json.loads(file.read_text(encoding="utf-8"))), sender)


if __name__ == "__main__":
    main()
