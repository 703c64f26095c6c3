# SPDX-License-Identifier: Apache-2.0
"""Where status is lost between an engine and a program: counters of the queues on the way."""
import pathlib
import re
import socket
import urllib.request


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def dropped_by_sockets():
    """Datagrams that found the buffer of a UDP socket of this network namespace full."""
    names, values = (line.split()[1:] for line in pathlib.Path("/proc/net/snmp").read_text().splitlines()
                     if line.startswith("Udp:"))
    return int(dict(zip(names, values))["RcvbufErrors"])


def of_the_service(port):
    """Status samples lost in the queues of a service with --metrics PORT, and its late ticks."""
    text = urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=5).read().decode()

    def value(pattern):
        return sum(int(float(count)) for count in re.findall(rf"^{pattern} (\S+)$", text, re.MULTILINE))

    return {"images": value(r'vdrive_status_lost_total\{.*queue="images"\}'),
            "wire": value(r'vdrive_status_lost_total\{.*queue="wire"\}'),
            "overruns": value(r"vdrive_tick_overruns_total\{.*\}"),
            "jumps": value(r"vdrive_tick_jumps_total\{.*\}"),
            "ticks": value(r"vdrive_ticks_total\{.*\}")}


class Hops:
    """The losses of each queue since this object was made."""

    def __init__(self, port):
        self._port = port
        self._sockets, self._service = dropped_by_sockets(), of_the_service(port)

    def so_far(self):
        now = of_the_service(self._port)
        lost = {name: now[name] - before for name, before in self._service.items()}
        return {**lost, "sockets": dropped_by_sockets() - self._sockets}
