# SPDX-License-Identifier: Apache-2.0
"""A minimal CANopen master that knows only CAN: a client of socketcand.

The protocol is that of doc/protocol.md in linux-can/socketcand; the services are those of CiA
301."""
import collections
import select
import socket
import struct
import time
from typing import NamedTuple

PATIENCE = 60.0  # [s] generous, for busy machines

START, STOP, PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION = 0x01, 0x02, 0x80, 0x81, 0x82
SYNC, EMCY, TPDO, RPDO, SDO_ANSWER, SDO_REQUEST, HEARTBEAT = 0x80, 0x80, 0x180, 0x200, 0x580, 0x600, 0x700
NOT_VALID = 1 << 31  # bit of the COB-ID of a PDO


class Frame(NamedTuple):
    """A data frame of the base format."""

    id: int
    data: bytes = b""

    def __repr__(self):
        return f"{self.id:03X}#{self.data.hex()}"


class SdoAbort(Exception):
    """The node aborted a transfer."""

    def __init__(self, index, sub, code):
        super().__init__(f"{index:04X}h:{sub:02X}: abort 0x{code:08X}")
        self.code = code


class CanClient:
    """A connection to a socketcand server in raw mode. Received frames are in `seen`, the latest
    of each identifier in `latest`."""

    def __init__(self, host, port, channel="can0", patience=PATIENCE):
        self._socket = socket.create_connection((host, port), timeout=patience)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._text = b""
        self.patience = patience
        self.seen = []
        self.latest = {}
        self.received = collections.Counter()
        self._expect("< hi >")
        for request in (f"< open {channel} >", "< rawmode >"):
            self._socket.sendall(request.encode())
            self._expect("< ok >")

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def close(self):
        self._socket.close()

    # Words.

    def _word(self, timeout):
        """The next word, or None on a time-out."""
        deadline = time.monotonic() + timeout
        while b">" not in self._text:
            left = max(0.0, deadline - time.monotonic())
            if not select.select([self._socket], [], [], left)[0]:
                return None
            part = self._socket.recv(65536)
            if not part:
                raise ConnectionError("the server has closed the connection")
            self._text += part
        word, _, self._text = self._text.partition(b">")
        return word.decode().strip() + " >"

    def _expect(self, expected):
        word = self._word(self.patience)
        assert word == expected, f"{word!r} instead of {expected!r}"

    # Frames.

    def send(self, identifier, data=b""):
        words = ["send", f"{identifier:03X}", str(len(data)), *(f"{byte:02X}" for byte in data)]
        self._socket.sendall(f"< {' '.join(words)} >".encode())

    def receive(self, timeout=0.0):
        """The next frame, or None on a time-out."""
        word = self._word(timeout)
        if word is None:
            return None
        parts = word.split()
        assert parts[:2] == ["<", "frame"], word
        frame = Frame(int(parts[2], 16), bytes.fromhex(parts[4]) if parts[4] != ">" else b"")
        self.seen.append(frame)
        self.latest[frame.id] = frame.data
        self.received[frame.id] += 1
        return frame

    def wait_for(self, condition, what="the frame"):
        """The next frame for which `condition(frame)` holds."""
        deadline = time.monotonic() + self.patience
        while (left := deadline - time.monotonic()) > 0:
            frame = self.receive(left)
            if frame is not None and condition(frame):
                return frame
        raise TimeoutError(f"{what} did not come within {self.patience} s")

    def drain(self):
        """Receive all frames that have arrived."""
        while self.receive() is not None:
            pass

    # NMT, SYNC.

    def nmt(self, command, node=0):
        self.send(0x000, bytes([command, node]))

    def sync(self, counter=None):
        self.send(SYNC, b"" if counter is None else bytes([counter]))

    def boot(self, node):
        """Reset the communication of a node and wait for its boot-up."""
        self.nmt(RESET_COMMUNICATION, node)
        self.wait_for(lambda frame: frame == Frame(HEARTBEAT + node, b"\0"), f"boot-up of node {node}")

    # SDO client (CiA 301, 7.2.4.3): expedited and segmented transfers.

    def _answer(self, node, index, sub):
        answer = self.wait_for(lambda frame: frame.id == SDO_ANSWER + node, f"the SDO answer of node {node}")
        assert len(answer.data) == 8, answer
        if answer.data[0] == 0x80:
            assert answer.data[1:4] == struct.pack("<HB", index, sub), answer
            raise SdoAbort(index, sub, struct.unpack("<I", answer.data[4:])[0])
        return answer.data

    def request(self, node, data):
        self.send(SDO_REQUEST + node, data.ljust(8, b"\0"))

    def upload(self, node, index, sub=0):
        self.request(node, struct.pack("<BHB", 0x40, index, sub))
        first = self._answer(node, index, sub)
        assert first[0] & 0xE0 == 0x40 and first[1:4] == struct.pack("<HB", index, sub), first.hex()
        if first[0] & 0x02:
            size = 4 - (first[0] >> 2 & 3) if first[0] & 0x01 else 4
            return first[4:4 + size]
        size = struct.unpack("<I", first[4:])[0] if first[0] & 0x01 else None
        data, toggle, is_last = b"", 0x00, False
        while not is_last:
            self.request(node, bytes([0x60 | toggle]))
            part = self._answer(node, index, sub)
            assert part[0] & 0xF0 == toggle, part.hex()
            data += part[1:8 - (part[0] >> 1 & 7)]
            is_last = bool(part[0] & 0x01)
            toggle ^= 0x10
        assert size in (None, len(data)), (size, data)
        return data

    def download(self, node, index, sub, data):
        if len(data) <= 4:
            self.request(node, struct.pack("<BHB", 0x23 | (4 - len(data)) << 2, index, sub) + data)
            self._answer(node, index, sub)
            return
        self.request(node, struct.pack("<BHBI", 0x21, index, sub, len(data)))
        self._answer(node, index, sub)
        toggle = 0x00
        for place in range(0, len(data), 7):
            part = data[place:place + 7]
            is_last = place + 7 >= len(data)
            self.request(node, bytes([toggle | (7 - len(part)) << 1 | is_last]) + part)
            answer = self._answer(node, index, sub)
            assert answer[0] == 0x20 | toggle, answer.hex()
            toggle ^= 0x10

    def read(self, node, index, sub=0, signed=False):
        return int.from_bytes(self.upload(node, index, sub), "little", signed=signed)

    def write(self, node, index, sub, value, size):
        self.download(node, index, sub, value.to_bytes(size, "little", signed=value < 0))

    # PDOs.

    def map_pdo(self, node, communication, cob_id, objects, transmission=None, inhibit=None):
        """Remap a PDO by the procedure of CiA 301, 7.5.2.36 and 7.5.2.38.

        communication: index of its communication parameter. objects: (index, sub-index, bits) each.
        inhibit: of a TPDO, in multiples of 100 us.
        """
        mapping = communication + 0x200
        self.write(node, communication, 1, NOT_VALID | cob_id, 4)
        if transmission is not None:
            self.write(node, communication, 2, transmission, 1)
        if inhibit is not None:
            self.write(node, communication, 3, inhibit, 2)
        self.write(node, mapping, 0, 0, 1)
        for place, (index, sub, bits) in enumerate(objects, 1):
            self.write(node, mapping, place, index << 16 | sub << 8 | bits, 4)
        self.write(node, mapping, 0, len(objects), 1)
        self.write(node, communication, 1, cob_id, 4)


class Time:
    """The clock of a master on a bus with one node, where SYNC lets a period pass. It counts drive
    time, so that the time-outs of the master also hold on a busy machine."""

    def __init__(self, client, period, node):
        self._client, self.period, self._node = client, period, node
        self.now = 0.0  # [s]

    def deadline(self, seconds):
        return self.now + seconds

    def boot(self):
        """Reset the communication of the node, and wait for its boot-up."""
        self._client.boot(self._node)

    def cycle(self):
        """One period. Frames that the node sends at SYNC arrive before the answer to the SDO that
        follows it."""
        self._client.sync()
        self._client.read(self._node, 0x1000)
        self.now += self.period


class RealTime(Time):
    """The same where SYNC lets no time pass: the clock is the heartbeat of the node, which counts
    drive time."""

    def __init__(self, client, period, node):
        super().__init__(client, period, node)
        self._begin()

    def _begin(self):
        self._client.write(self._node, 0x1017, 0, round(self.period * 1000), 2)

    def boot(self):
        super().boot()
        self._begin()

    def cycle(self):
        super().cycle()
        self._client.wait_for(lambda frame: frame.id == HEARTBEAT + self._node, "the heartbeat")
        self._client.drain()
