#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The datagrams of discovery among more benches than one machine can run.

  discovery_simulation.py [--benches 2 4 8] [--on HOSTS] [--wire thread|process]
  discovery_simulation.py --check MEASURED     compares with lines of discovery_traffic.py

Participants send according to Rules, which were derived from real ones; the simulation has no
randomness and no clock. Each line describes a network where all benches find each other by
multicast. Exit code 1: --check found a difference.
"""
import argparse
import dataclasses
import heapq
import json
import sys


@dataclasses.dataclass(frozen=True)
class Rules:
    """The messages of one participant of vdrive. The times are those in
    idl/src/dds/dds_participant.cpp."""

    first_announcements: int = 10
    first_period: float = 0.05  # [s]
    period: float = 0.1  # [s]
    # Loopback and the network: a multicast announcement is sent on each of them, and a datagram to
    # a participant on the same host is sent to both of its addresses.
    interfaces: int = 2
    most_known: int = 256  # participants; further ones are ignored
    # Measured: the announcements of the endpoints to a new participant, with acknowledgements.
    endpoint_datagrams: int = 12
    # The probe of a wire process creates a new reader and writer twice a second, and announces them
    # to each service. Measured, with acknowledgements.
    probe_rate: float = 2.0
    probe_datagrams: float = 6.2
    # bench_state, 20 times a second, to its own reader and to that of each other bench.
    state_rate: float = 20.0


class Participant:
    def __init__(self, start, host, is_probe):
        self.start = start
        self.host = host
        self.is_probe = is_probe
        self.known = set()
        self.copies = 0  # datagrams per announcement to all known participants
        self.announced = 0

    def receives(self, other):
        """Probes ignore each other."""
        return not (self.is_probe and other.is_probe)


class Simulation:
    """Benches that start one after the other, `spacing` [s] apart, on alternating hosts. With a
    wire process, each also has a probe."""

    def __init__(self, benches, hosts, spacing=0.0, rules=Rules(), with_probes=False):
        self.rules = rules
        self.participants = [Participant(spacing * number, number % hosts, is_probe)
                             for is_probe in ((False, True) if with_probes else (False,))
                             for number in range(benches)]
        self.events = [(one.start, number) for number, one in enumerate(self.participants)]
        heapq.heapify(self.events)
        self.multicast = 0
        self.unicast = 0.0

    def run_until(self, end):
        while self.events and self.events[0][0] < end:
            now, number = heapq.heappop(self.events)
            self.announce(number, now)
            one = self.participants[number]
            is_first = one.announced < self.rules.first_announcements
            wait = self.rules.first_period if is_first else self.rules.period
            heapq.heappush(self.events, (now + wait, number))

    def announce(self, number, now):
        """Announces to everybody by multicast, and to each known participant."""
        rules = self.rules
        one = self.participants[number]
        one.announced += 1
        self.multicast += rules.interfaces
        self.unicast += one.copies
        if one.is_probe:  # datagrams for its new endpoints within one announcement period
            self.unicast += one.copies * rules.probe_rate * rules.probe_datagrams * rules.period
        for other_number, other in enumerate(self.participants):
            if other is not one and other.start <= now and other.receives(one):
                self.meet(other_number, number)
                self.meet(number, other_number)

    def meet(self, number, met):
        """A participant that discovers another one answers with its own announcement and announces
        its endpoints."""
        one = self.participants[number]
        if met not in one.known and len(one.known) < self.rules.most_known:
            one.known.add(met)
            copies = self.rules.interfaces if one.host == self.participants[met].host else 1
            one.copies += copies
            self.unicast += copies * (1 + self.rules.endpoint_datagrams)

    def states_a_second(self):
        """@return samples of bench_state per second sent by the benches at rest."""
        benches = [one for one in self.participants if not one.is_probe]
        others = sum(self.rules.interfaces if self.participants[met].host == one.host else 1
                     for one in benches for met in one.known
                     if not self.participants[met].is_probe)
        return self.rules.state_rate * (len(benches) * self.rules.interfaces + others)

    def is_complete(self):
        """@return whether each participant knows all others that it can receive."""
        return all(len(one.known) == sum(other is not one and one.receives(other)
                                         for other in self.participants)
                   for one in self.participants)


def experiment(benches, hosts, starting=0.0, until_rest=6.0, wire="thread", rules=Rules()):
    """Simulates a measurement of discovery_traffic.py: all benches run after `starting` [s], and
    the network is at rest from `until_rest` [s] on."""
    rest = 5.0
    simulation = Simulation(benches, hosts, starting / benches, rules, wire == "process")
    simulation.run_until(until_rest)
    once = {"multicast": simulation.multicast, "unicast": round(simulation.unicast)}
    simulation.run_until(until_rest + rest)
    return {
        "benches": benches,
        "hosts": hosts,
        "wire": wire,
        "is_complete": simulation.is_complete(),
        "sent_until_rest": once,
        "sent_a_second_in_rest": {
            "multicast": round((simulation.multicast - once["multicast"]) / rest, 1),
            "unicast": round((simulation.unicast - once["unicast"]) / rest, 1),
            "data": simulation.states_a_second()}}


def received_a_second(benches, rules=Rules()):
    """@return datagrams per second that each bench receives at rest from benches on other hosts,
    with a wire thread: from each of them a multicast announcement, a unicast
    announcement and a state."""
    known = min(benches - 1, rules.most_known)
    return (benches - 1 + known) / rules.period + known * rules.state_rate


TOLERANCES = (("sent_a_second_in_rest", "multicast", 0.1), ("sent_a_second_in_rest", "unicast", 0.2),
              ("sent_a_second_in_rest", "data", 0.2), ("sent_until_rest", "multicast", 0.2),
              ("sent_until_rest", "unicast", 0.3))


def check(lines):
    """@return the differences between measured lines and their simulation, as text."""
    wrong = []
    for line in lines:
        simulated = experiment(line["benches"], line["hosts"], line["starting_s"],
                               line["until_rest_s"], line["wire"])
        for part, kind, tolerance in TOLERANCES:
            if kind == "data" and line["wire"] == "process":
                continue  # the probes also exchange states, which is not simulated
            seen, expected = line[part][kind], simulated[part][kind]
            if abs(seen - expected) > max(tolerance * max(seen, expected), 5):
                wrong.append(f'{line["benches"]} benches, wire {line["wire"]}, {part}, {kind}: '
                             f"measured {seen}, simulated {expected}")
    return wrong


def of_benches_alone(text):
    """@return the lines covered by the simulation: with multicast, without clients."""
    lines = [json.loads(line) for line in text.splitlines() if line.strip()]
    return [line for line in lines if not line["server"] and line["clients"] == 0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--benches", type=int, nargs="+", default=[2, 8, 32, 128, 256, 512])
    parser.add_argument("--on", type=int, metavar="HOSTS", help="default: a host for each bench")
    parser.add_argument("--wire", default="thread", choices=("thread", "process"))
    parser.add_argument("--check", metavar="MEASURED")
    arguments = parser.parse_args()
    if arguments.check:
        with open(arguments.check, encoding="utf-8") as file:
            lines = of_benches_alone(file.read())
        wrong = check(lines)
        print(*wrong, f"{len(lines)} measured networks compared", sep="\n")
        return 1 if wrong or not lines else 0
    for count in arguments.benches:
        found = experiment(count, arguments.on or count, wire=arguments.wire)
        found["received_a_second_by_each"] = received_a_second(count)
        print(json.dumps(found), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
