#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts the datagrams of discovery among real benches and clients on separate hosts.

  discovery_traffic.py --service VDRIVED --tool VDRIVE [--server FASTDDS] [--hosts 2]
                       [--benches 1 2 4] [--clients 0] [--axes 2] [--every 1]

Prints one JSON line for each number of benches: the datagrams that all hosts together sent from the
start of the first program until discovery was complete, and per second at rest; the processor time
of each bench at rest, and the share of its ticks that ended late. Datagrams to even ports belong to
discovery (docs/guides/network.md). Benches are found by multicast; with --server by a discovery
server (the program fastdds) on a further host. Each client watches all axes of all benches, whose
status is sent every --every ticks. Needs root, like network_test.py.
"""
import argparse
import json
import os
import pathlib
import sys
import tempfile
import time

import hosts

SETTLE = 6  # [s] after the last start: by then a new participant's frequent announcements have ended
REST = 5  # [s]
METRICS = 9100  # plus the bench number: the port of its metrics
KINDS = ("multicast", "unicast", "data")


class Counters:
    """Counts what the programs on all hosts send, on any interface."""

    def __init__(self, network):
        self.network = network
        for host in network.hosts.values():
            network.load_rules(host.namespace, "inet", [
                *(f"counter {kind} {{ }}" for kind in KINDS),
                "chain output { type filter hook output priority 0",
                "meta l4proto != udp return",
                "@th,31,1 1 counter name data return",
                "ip daddr 224.0.0.0/4 counter name multicast return",
                "counter name unicast",
                "}"])

    def read(self):
        """{kind: (datagrams, bytes)}"""
        total = {kind: [0, 0] for kind in KINDS}
        for host in self.network.hosts.values():
            text = hosts.run("ip", "netns", "exec", host.namespace, "nft", "-j", "list", "counters")
            for entry in json.loads(text)["nftables"]:
                if "counter" in entry:
                    counter = entry["counter"]
                    total[counter["name"]][0] += counter["packets"]
                    total[counter["name"]][1] += counter["bytes"]
        return total


def processor_seconds(programs):
    total = 0.0
    for program in programs:
        stat = pathlib.Path(f"/proc/{program.child.pid}/stat").read_text(encoding="utf-8")
        fields = stat[stat.rindex(")") + 2:].split()
        total += (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return total


def difference(later, earlier):
    return {kind: [a - b for a, b in zip(later[kind], earlier[kind])] for kind in KINDS}


def start_bench(arguments, network, host, number, setting):
    file = network.directory / f"bench{number}.yaml"
    file.write_text(f"bench: {{number: {number}, name: bench{number}}}\n"
                    f"network: {{interfaces: [{host.address}]{setting}}}\n"
                    f"status: {{every_ticks: {arguments.every}}}\n"
                    f"metrics: {{port: {METRICS + number}}}\n", encoding="utf-8")
    return host.start(f"bench{number}", arguments.service, "--config", file, "--axes",
                      arguments.axes, "--wire", arguments.wire)


def ticks_of(machines, benches):
    """@return the number of ticks run by all benches, and how many of them ended late."""
    read = ("import sys, urllib.request\n"
            "print(urllib.request.urlopen(sys.argv[1], timeout=5).read().decode())")
    found = {"vdrive_ticks_total": 0.0, "vdrive_tick_overruns_total": 0.0}
    for n in range(benches):
        url = f"http://127.0.0.1:{METRICS + n + 1}/metrics"
        page = machines[n % len(machines)].call(sys.executable, "-c", read, url).stdout
        for line in page.splitlines():
            name = line.split("{")[0].split(" ")[0]
            if name in found:
                found[name] += float(line.split()[-1])
    return list(found.values())


def measure(arguments, directory, benches):
    with hosts.Network(directory, arguments.hosts + (arguments.server is not None)) as network:
        machines = list(network.hosts.values())
        setting = ""
        client_options = []
        if arguments.server:
            server = machines.pop()
            server.start("server", arguments.server, "discovery", "--server-id", "0",
                         "--ip-address", server.address, "--port", "11811")
            setting = f", discovery_server: ['{server.address}:11811']"
            client_options = ["--discovery-server", f"{server.address}:11811"]
            time.sleep(1)
        counters = Counters(network)
        before = counters.read()
        begin = time.monotonic()
        programs = [start_bench(arguments, network, machines[n % len(machines)], n + 1, setting)
                    for n in range(benches)]
        for program in programs:
            hosts.wait_for("bench", lambda p=program: any("incarnation=" in x for x in p.lines()), 30)
        starting = time.monotonic() - begin
        for n in range(arguments.clients):
            host = machines[n % len(machines)]
            host.start(f"client{n}", arguments.tool, "--interface", host.address, *client_options,
                       "watch", "--json")
        time.sleep(SETTLE)
        ticks = ticks_of(machines, benches)
        found = counters.read()
        middle = time.monotonic()
        processor = processor_seconds(programs)
        time.sleep(REST)
        end = counters.read()
        rest = time.monotonic() - middle
        share = (processor_seconds(programs) - processor) / rest / benches
        ticks = [a - b for a, b in zip(ticks_of(machines, benches), ticks)]
        per_second = {kind: round(difference(end, found)[kind][0] / rest, 1) for kind in KINDS}
        bytes_per_second = {kind: round(difference(end, found)[kind][1] / rest) for kind in KINDS}
        once = {kind: difference(found, before)[kind][0] for kind in KINDS}
        print(json.dumps({
            "benches": benches, "clients": arguments.clients, "hosts": len(machines),
            "server": arguments.server is not None, "wire": arguments.wire,
            "starting_s": round(starting, 2), "until_rest_s": round(middle - begin, 2),
            "sent_until_rest": once,
            "sent_a_second_in_rest": per_second, "bytes_a_second_in_rest": bytes_per_second,
            "axes": arguments.axes, "every_ticks": arguments.every,
            "processor_share_of_a_bench": round(share, 4),
            "overrun_share": round(ticks[1] / max(ticks[0], 1), 5)}),
            flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--service", required=True)
    parser.add_argument("--tool", required=True)
    parser.add_argument("--server")
    parser.add_argument("--wire", default="thread", choices=("thread", "process"))
    parser.add_argument("--hosts", type=int, default=2)
    parser.add_argument("--benches", type=int, nargs="+", default=[1, 2, 4])
    parser.add_argument("--clients", type=int, default=0)
    parser.add_argument("--axes", type=int, default=2)
    parser.add_argument("--every", type=int, default=1)
    arguments = parser.parse_args()
    for benches in arguments.benches:
        with tempfile.TemporaryDirectory() as directory:
            measure(arguments, pathlib.Path(directory), benches)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except hosts.Missing as missing:
        print(f"skipped: {missing}", file=sys.stderr)
        sys.exit(77)
