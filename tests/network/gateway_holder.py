#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A client of a gateway that takes control, enables an axis and answers pings until it is ended.

  gateway_holder.py HOST PORT TOKEN AXIS

Prints a line of JSON for each answer of the gateway.
"""
import base64
import json
import os
import socket
import struct
import sys

TEXT, BINARY, PING, PONG = 1, 2, 9, 10
SERVICE_REQUEST, SERVICE_RESPONSE = 2, 3


class WebSocket:
    """The part of RFC 6455 that this client needs: no fragments."""

    def __init__(self, host, port, token):
        self.socket = socket.create_connection((host, port), timeout=30)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            f"GET /?token={token} HTTP/1.1\r\nHost: {host}:{port}\r\nConnection: Upgrade\r\n"
            f"Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n"
            "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n".encode())
        self.file = self.socket.makefile("rb")
        status = self.file.readline()
        if b" 101 " not in status:
            raise RuntimeError(f"the gateway refused the connection: {status!r}")
        while self.file.readline().strip():
            pass

    def send(self, operation, payload):
        mask = os.urandom(4)
        size = len(payload)
        head = bytes([0x80 | operation])
        head += bytes([0x80 | size]) if size < 126 else bytes([0x80 | 126]) + struct.pack(">H", size)
        self.socket.sendall(head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload)))

    def receive(self):
        """The next message and its opcode. Answers pings."""
        while True:
            operation, size = self.file.read(2)
            if size == 126:
                size, = struct.unpack(">H", self.file.read(2))
            elif size == 127:
                size, = struct.unpack(">Q", self.file.read(8))
            payload = self.file.read(size)
            if operation & 15 != PING:
                return operation & 15, payload
            self.send(PONG, payload)


def main():
    host, port, token, axis = sys.argv[1:]
    web = WebSocket(host, int(port), token)
    services = {}
    calls = [("/take_control", {"name": "holder"}), ("/enable", {"axes": [axis]})]
    while True:
        operation, payload = web.receive()
        if operation == TEXT:
            message = json.loads(payload)
            if message["op"] != "advertiseServices":
                continue
            services = {service["name"]: service["id"] for service in message["services"]}
        elif operation == BINARY and payload[0] == SERVICE_RESPONSE:
            print(payload[17:].decode(), flush=True)
        else:
            continue
        if calls:
            name, request = calls.pop(0)
            body = json.dumps(request).encode()
            web.send(BINARY, struct.pack("<BIII", SERVICE_REQUEST, services[name], 1, 4) + b"json" + body)


if __name__ == "__main__":
    main()
