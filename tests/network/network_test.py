#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Two services and a client on three hosts.

  network_test.py CASE --service VDRIVED --tool VDRIVE --client NETWORK_CLIENT --gateway VDRIVE-GATEWAY

Exit code 0: passed, 1: failed, 77: skipped, with the reason.
"""

import argparse
import json
import math
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback

import hosts

HANDED_OVER = 25  # [ticks] for which a datagram may be in transit on a busy machine
WATCHDOG = 200  # [ticks] of 1 ms: a busy machine stalls a client for up to 100 ms
START = 30  # [s] for starting and finding a program on a busy machine
PATIENCE = 15  # [s] for events without a promised time: moves continue, requests are answered
LEASE = 2  # [s] after which two hosts that receive nothing from each other forget each other
REST = 10  # [user units] of 4096 per revolution: the largest deviation of an axis at rest
SILENCE = 1.5  # [s] after which a client considers a service lost
TICKS_PER_SECOND = 1000
CONNECTION_LOST = 0x8130
STALE_EPOCH = 2
GATEWAY_PATIENCE = 2  # [s] after which a gateway gives up a holder whose host acknowledges nothing
SKIPPED = 77
GROUP = "group"  # the name of the group's calls in the output of the client
LONGEST = 100  # [s] after which a case cleans up and fails


def expect(condition, message):
    if not condition:
        raise AssertionError(message)


def expect_in_time(took, limit, message):
    if took > limit:
        raise hosts.Late(f"{message}: limit {limit}")


class Lateness(threading.Thread):
    """Measures how late this machine runs a thread that is due every millisecond."""

    def __init__(self):
        super().__init__(daemon=True)
        self.delays = []  # (end, duration) of each delay of more than a millisecond [s]
        self.start()

    def run(self):
        wanted = time.monotonic()
        while True:
            wanted = max(wanted + 0.001, time.monotonic() - 0.001)
            time.sleep(max(0.0, wanted - time.monotonic()))
            now = time.monotonic()
            if now - wanted > 0.001:
                self.delays.append((now, now - wanted))
                wanted = now

    def longest(self, since):
        """The longest delay that ended after `since` [ticks]."""
        return TICKS_PER_SECOND * max((delay for when, delay in self.delays if when >= since), default=0)


class Bench:
    """A service on its own host, next to an observer that no link failure can cut off."""

    def __init__(self, case, host, number, network="", watchdog=WATCHDOG):
        self.number = number
        self.host = host
        file = case.directory / f"bench{number}.yaml"
        file.write_text(
            f"bench: {{number: {number}, name: bench{number}}}\n"
            f"watchdog: {{timeout_ms: {watchdog}}}\n"
            f"network: {{interfaces: [{host.address}]{network}}}\n", encoding="utf-8")
        self.service = host.start(f"service{number}", case.programs.service, "--config", file,
                                  "--log-level", "debug")

    def observe(self, case, *axes):
        self.observer = self.host.start(
            f"observer{self.number}", case.programs.client, "--interface", self.host.address,
            "observe", *axes)
        hosts.wait_for("observation", lambda: self.seen(axes[0]), START)

    def events(self, since=0):
        """(tick, text) of each event in the log from line `since` on."""
        lines = self.service.lines()[since:]
        found = (re.search(r'tick=(\d+) .*text="(.*)"', line) for line in lines)
        return [(int(match[1]), match[2]) for match in found if match]

    def mark(self):
        return len(self.service.lines())

    def seen(self, axis):
        """The observer's lines about the axis, oldest first."""
        lines = [json.loads(line) for line in self.observer.lines()]
        return [line for line in lines if line.get("axis") == axis]


class Case:
    """Three hosts and their programs; everything ends with the object."""

    def __init__(self, programs, directory):
        self.programs = programs
        self.directory = pathlib.Path(directory)
        self.network = hosts.Network(directory)

    def __enter__(self):
        self.network.__enter__()
        self.a, self.b, self.c = (self.network[letter] for letter in "abc")
        self.options = ["--interface", self.c.address]
        self.lateness = Lateness()
        return self

    def __exit__(self, kind, *_):
        if kind is not None:
            self.show_logs()
        self.network.close()

    def show_logs(self):
        for process in self.network.processes:
            lines = [line for line in process.lines() if not re.search(r"too late|ended .*late", line)]
            print(f"--- {process.name}, last of {len(lines)} lines", *lines[-60:], sep="\n")

    def start_benches(self, network=""):
        self.benches = [Bench(self, self.a, 1, network), Bench(self, self.b, 2, network)]
        for bench in self.benches:
            hosts.wait_for("start of the service",
                           lambda b=bench: any("incarnation=" in x for x in b.service.lines()), START)

    def tool(self, *words, timeout=30):
        done = self.c.call(self.programs.tool, *self.options, *words, timeout=timeout)
        return done.returncode, done.stdout, done.stderr

    def start_cycle(self):
        self.cycle = self.c.start("cycle", self.programs.client, *self.options, "cycle", "1.1",
                                  "2.1")
        self.wait_for_moves(0, START)

    def start_group(self):
        self.cycle = self.c.start("group", self.programs.client, *self.options, "group", "1.1",
                                  "2.1")
        self.wait_for_moves(0, START, axes=(GROUP,))

    def calls(self, axis, since=0.0):
        """Calls of the moving client that ended after `since`."""
        lines = [json.loads(line) for line in self.cycle.lines()]
        return [line for line in lines
                if line.get("axis") == axis and "call" in line and line["time"] > since]

    def moves(self, axis, since=0.0):
        return [call for call in self.calls(axis, since)
                if call["call"] == "move" and call["outcome"] == "ok"]

    def failures(self, axis, since=0.0):
        return [call for call in self.calls(axis, since) if call["outcome"] != "ok"]

    def wait_for_moves(self, since, timeout, count=1, axes=("1.1", "2.1")):
        for axis in axes:
            hosts.wait_for(f"{count} moves of axis {axis}",
                           lambda a=axis: len(self.moves(a, since)) >= count,
                           since + timeout - time.monotonic() if since else timeout)

    def stream(self, axis):
        """The client's latest count of the status stream: samples, missed, skipped, first, last."""
        lines = [json.loads(line) for line in self.cycle.lines()]
        for line in lines:
            expect("invented" not in line, f"a sample twice or out of order: {line}")
        counts = [line for line in lines if line.get("axis") == axis and "samples" in line]
        return counts[-1] if counts else None

    def expect_nothing_restarted(self):
        for process in self.network.processes:
            expect(process.is_running() or process.name.startswith("holder"),
                   f"{process.name} ended with {process.child.poll()}")


# ---- discovery -----------------------------------------------------------------------------------


def find_and_move(case):
    # The tool lists the benches that answer within 2 s. A bench just started on a busy machine may
    # answer later.
    def both_are_listed():
        began = time.monotonic()
        code, out, _ = case.tool("list", "--json")
        took = time.monotonic() - began
        return code == 0 and {json.loads(line)["bench"] for line in out.splitlines()} == {1, 2} and took
    took = hosts.wait_for("a list of both benches", both_are_listed, START)
    print(f"both benches listed after {took:.2f} s")
    for axis in ("1.1", "2.1"):
        # The axes lose their master on a machine that stalls for 100 ms: try again.
        expect(any(case.tool("reset", axis)[0] == case.tool("enable", axis)[0] ==
                   case.tool("move", axis, "4096", "--velocity", "40960")[0] == 0
                   for _ in range(3)), f"axis {axis} did not move, three times of three")
        code, out, err = case.tool("status", axis, "--json")
        status = json.loads(out)
        expect(status["state"] == "Operation enabled", out)
        expect(abs(status["load_position_actual_value"] - 4096) <= REST, out)


def TwoBenchesAreFoundAndMovedByMulticast(case):
    case.start_benches()
    find_and_move(case)


def TwoBenchesAreFoundAndMovedByPeersWithoutMulticast(case):
    for host in (case.a, case.b, case.c):
        host.block_multicast()
    case.start_benches()
    # Without peers no participant is found, since discovery needs them.
    code, _, _ = case.tool("--timeout", "0.5", "list")
    expect(code == 3, f"found without peers: exit code {code}")
    case.options += ["--peer", case.a.address, "--peer", case.b.address]
    find_and_move(case)


def TwoBenchesAreFoundAndMovedByADiscoveryServerWithoutMulticast(case):
    if shutil.which("fastdds") is None:
        raise hosts.Missing("needs fastdds (package fastdds-tools)")
    for host in (case.a, case.b, case.c):
        host.block_multicast()
    address = f"{case.a.address}:11811"
    server = case.a.start("server", "fastdds", "discovery", "--server-id", 0, "--ip-address",
                          case.a.address, "--port", 11811)
    hosts.wait_for("discovery server", lambda: any("running" in x for x in server.lines()), 10)
    case.start_benches(f', discovery_server: ["{address}"]')
    code, _, _ = case.tool("--timeout", "0.5", "list")
    expect(code == 3, f"found without the server: exit code {code}")
    case.options += ["--discovery-server", address]
    find_and_move(case)


def start_discovery_server(host, name):
    if shutil.which("fastdds") is None:
        raise hosts.Missing("needs fastdds (package fastdds-tools)")
    profile = pathlib.Path(__file__).parents[2] / "deploy/network/discovery-server.xml"
    server = host.start(name, "fastdds", "discovery", "-x", profile, "--server-id", 0,
                        "--ip-address", host.address, "--port", 11811)
    hosts.wait_for("discovery server", lambda: any("running" in x for x in server.lines()), 10)
    return server


def BenchesAreFoundByTheNamesOfPeersAndInterfaces(case):
    for host in (case.a, case.b, case.c):
        host.block_multicast()
    case.c.serve_names()
    case.network.names({"bench-a.lab": [case.a.address], "bench-b.lab": [case.b.address]})
    case.start_benches()
    case.options = ["--interface", "net", "--peer", "bench-a.lab", "--peer", "bench-b.lab"]
    find_and_move(case)
    case.options = ["--interface", "net", "--peer", "nobody.lab"]
    code, _, err = case.tool("--timeout", "1", "list")
    expect(code == 3 and "the host name 'nobody.lab' does not resolve" in err, f"{code}: {err}")


def TheDiscoveryServerReturnsElsewhereAndIsFoundByItsName(case):
    for host in (case.a, case.b, case.c):
        host.block_multicast()
    case.c.serve_names()
    # Both are started before the server, and before its name resolves.
    server = "discovery.lab:11811"
    case.benches = [Bench(case, host, number, f', discovery_server: ["{server}"]')
                    for host, number in ((case.a, 1), (case.b, 2))]
    for bench in case.benches:
        hosts.wait_for("line about the name in the log",
                       lambda b=bench: any("discovery.lab" in x and "does not resolve" in x
                                           for x in b.service.lines()), START)
    case.options += ["--discovery-server", server]
    first = start_discovery_server(case.a, "server_a")
    case.network.names({"discovery.lab": [case.a.address]})
    find_and_move(case)
    case.start_cycle()

    def both_are_listed():
        code, out, _ = case.tool("list", "--json")
        return code == 0 and {json.loads(line)["bench"] for line in out.splitlines()} == {1, 2}

    first.kill()
    ended = time.monotonic()
    hosts.wait_for("moves without the server",
                   lambda: all(case.moves(axis, ended + 3) for axis in ("1.1", "2.1")), START)
    former = None
    # The server returns on another host after the lease of the former one; then within its lease, first
    # on another host, then at the same address.
    for name, host in (("server_b", case.b), ("server_c", case.c), ("server_c2", case.c)):
        if former:
            former.kill()
        case.network.names({"discovery.lab": [host.address]})
        former = start_discovery_server(host, name)
        back = time.monotonic()
        hosts.wait_for(f"a list of both benches by {name}", both_are_listed, START)
        print(f"found through {name} after {time.monotonic() - back:.1f} s")
    expect(not case.failures("1.1", ended) and not case.failures("2.1", ended),
           "the master's moves failed while the server moved")
    for bench in case.benches:
        expect(not any("was started again" in text for _, text in bench.events()),
               f"the network process of bench {bench.number} was started again")


def ABenchThatEndsWithoutADiscoveryServerStopsNoOtherOne(case):
    for host in (case.a, case.b, case.c):
        host.block_multicast()
    server = start_discovery_server(case.c, "server")
    address = f"{case.c.address}:11811"
    case.start_benches(f', discovery_server: ["{address}"]')
    case.options += ["--discovery-server", address]
    case.start_cycle()
    server.kill()
    hosts.wait_for("the loss of the server in the log",
                   lambda: any("no discovery server" in x for x in case.benches[1].service.lines()), START)
    # No server is left to report its end, and it no longer acknowledges anything.
    case.benches[1].service.kill()
    killed = time.monotonic()
    hosts.wait_for("moves of the other bench 20 s later", lambda: case.moves("1.1", killed + 20), 40)
    expect(not case.failures("1.1", killed), f"failed: {case.failures('1.1', killed)}")


# ---- links that go down --------------------------------------------------------------------------


def ABridgeOfRosIsFoundAcrossHostsByItsInterfaceAndPeers(case):
    for host in (case.a, case.b, case.c):
        host.block_multicast()
    bench = Bench(case, case.a, 1)
    hosts.wait_for("start of the service",
                   lambda: any("incarnation=" in line for line in bench.service.lines()), START)
    # The bridge on host b finds the bench on host a; the doctor on host c reads the topics that the
    # bridge publishes for ROS nodes.
    bridge = case.b.start("bridge", case.programs.ros2, "--enable", "--interface", case.b.address,
                          "--peer", case.a.address)

    def findings():
        _, text, _ = case.tool("--json", "--peer", case.b.address, "doctor")
        lines = [json.loads(line) for line in text.splitlines() if line.startswith("{")]
        return [line["text"] for line in lines if line["subject"] == "ROS 2"]

    def serves():
        return [text for text in findings() if "bench 1 running, controlled by this bridge" in text]

    found = hosts.wait_for("a bridge that serves the bench", serves, 30)
    expect(case.b.address in found[0], found)
    case.options = ["--interface", case.c.address]
    _, text, _ = case.tool("--json", "doctor")
    expect("no vdrive-ros2" in text, f"found without peers: {text}")
    expect(bridge.stop() == 0, "the bridge did not end well")


def position(bench, axis):
    return bench.seen(axis)[-1]["position"]


def start_holder(case, name):
    """Tries again if the machine stalled while it took the axis."""
    attempts = 10
    for attempt in range(1, attempts + 1):
        try:
            return try_holder(case, name)
        except hosts.Late:
            if attempt == attempts:
                raise


def try_holder(case, name):
    holder = case.c.start(f"holder{name}", case.programs.client, *case.options, "hold", "1.2",
                          stdin=subprocess.PIPE)
    held = hosts.wait_for("held axis", lambda: [x for x in holder.lines() if "held" in x], START)
    session = json.loads(held[0])["session"]

    def is_enabled():
        seen = case.benches[0].seen("1.2")[-1]
        return seen["owner"] == session and seen["state"] == "Operation enabled"

    try:
        hosts.wait_for("held axis to be enabled", is_enabled, 2)  # one that was lost stays lost
    except AssertionError:
        holder.kill()
        raise
    return holder


def send_target(holder, target):
    """Sends a set-point and returns its number in the session."""
    count = len(holder.lines())
    holder.child.stdin.write(f"{target}\n".encode())
    holder.child.stdin.flush()

    def sent():
        lines = [json.loads(line) for line in holder.lines()[count:]]
        return next((line["sent"] for line in lines if "sent" in line), None)

    return hosts.wait_for("set-point on its way", sent, PATIENCE)


def reply(holder, number):
    lines = [json.loads(line) for line in holder.lines()]
    return next((line for line in lines if line.get("reply") == number), None)


def expect_story(events, axis, what):
    """The events report the complete sequence, in this order."""
    story = ["nothing was received", "Fault reaction active", f"fault 0x{CONNECTION_LOST:04X}",
             "Fault", "controlled by session", f"fault 0x{CONNECTION_LOST:04X} reset",
             "Operation enabled"]
    texts = [text for _, text in events if text.startswith(f"axis {axis}: ")]
    place = 0
    for text in texts:
        if place < len(story) and story[place] in text:
            place += 1
    expect(place == len(story), f"{what}: the events of axis {axis} do not contain '"
           f"{story[place] if place < len(story) else ''}': {texts}")


def expect_safe_stop(case, bench, events, axis, tick, what):
    """Expects that the watchdog stopped the axis in time. Returns the times of fault and rest
    [ticks]."""
    silences = (re.match(rf"axis {axis}: nothing was received from .* for (\d+) ms", text)
                for _, text in events)
    silence = next((int(match[1]) for match in silences if match), None)
    expect(silence is not None, f"{what}: bench {bench.number} did not lose its master: {events}")
    expect(silence <= WATCHDOG + 2, f"{what}: its master was silent for {silence} ms")
    faults = [t for t, text in events if f"axis {axis}: fault 0x{CONNECTION_LOST:04X}" == text]
    expect(faults, f"{what}: no fault 0x8130: {events}")
    # The last message of the master arrived before the link went down. The fault follows after the
    # time-out and 2 ticks of drive time, which does not pass while the machine stalls and the tick
    # number jumps.
    jumps = (re.match(r"tick number jumped by (\d+)", text) for t, text in events if t <= faults[0])
    jumped = sum(int(match[1]) for match in jumps if match)
    # A message that arrives between two ticks is processed in the next one. A machine that delays
    # threads delays both the message and this test's time stamp. The threads of the wire have more
    # work than the one that measures the delay, and wait longer.
    late = math.ceil(case.lateness.longest(time.monotonic() - time.time() + tick / TICKS_PER_SECOND - 0.5))
    expect_in_time(faults[0] - jumped - math.ceil(tick), WATCHDOG + 2 + HANDED_OVER + 2 * late,
                   f"{what}: fault {faults[0] - tick} ticks after the link was down, {jumped} jumped")
    name = f"{bench.number}.{axis}"
    at_rest = next((x for x in bench.seen(name) if x["tick"] >= faults[0] and
                    x["state"] == "Fault" and not x["moving"]), None)
    expect(at_rest, f"{what}: axis {name} did not come to rest in Fault")
    expect(at_rest["error"] == CONNECTION_LOST, f"{what}: {at_rest}")
    return faults[0] - tick, at_rest["tick"] - tick


def short_cut(case):
    """Returns whether everything continued; a machine that stalls may prolong the cut."""
    began = time.monotonic()
    marks = [bench.mark() for bench in case.benches]
    case.c.block_for(0.05)
    case.wait_for_moves(time.monotonic(), PATIENCE, count=2)

    def lost():
        return [text for bench, mark in zip(case.benches, marks) for _, text in bench.events(mark)
                if "nothing was received" in text and "axis 1:" in text]

    def failed():
        return [call for axis in ("1.1", "2.1") for call in case.failures(axis, began)]

    # A call reports its failure after the bench does, so for a while only one side may know of a
    # loss.
    hosts.wait_for("agreement of benches and client about a lost master",
                   lambda: bool(lost()) == bool(failed()), PATIENCE)
    return not lost()


def long_cut(case, seconds):
    what = f"link down for {seconds} s"
    holder = start_holder(case, str(seconds))
    case.wait_for_moves(time.monotonic(), PATIENCE)
    before = position(case.benches[0], "1.2")
    marks = [bench.mark() for bench in case.benches]
    began = time.monotonic()
    case.c.unplug()
    tick = time.time() * TICKS_PER_SECOND  # tick 0 is the epoch
    hosts.wait_for("loss of the holder's axis", lambda: [
        text for _, text in case.benches[0].events(marks[0])
        if "nothing was received" in text and "axis 2:" in text], PATIENCE)
    number = send_target(holder, before + 4096)
    time.sleep(max(0.0, began + seconds - time.monotonic()))
    case.c.plug()
    plugged = time.monotonic()
    case.wait_for_moves(plugged, PATIENCE)
    again = max(case.moves(axis, plugged)[0]["time"] for axis in ("1.1", "2.1")) - plugged
    for bench, mark in zip(case.benches, marks):
        events = bench.events(mark)
        times = expect_safe_stop(case, bench, events, 1, tick, what)
        expect_story(events, 1, f"{what}, bench {bench.number}")
        print(f"{what}: bench {bench.number} fault after {times[0]:.0f} ms, at rest after "
              f"{times[1]:.0f} ms, axes move again {again:.2f} s after the link is back")
    for axis in ("1.1", "2.1"):
        failures = case.failures(axis, began)
        expect(failures, f"{what}: the client did not notice for axis {axis}")
        noticed = failures[0]["time"] - began
        # The client notices the silence of the bench, or else its messages once they arrive again: when the
        # host has requested its neighbour's address, which it does once a second.
        limit = 0.5 + (SILENCE if seconds > 2 * SILENCE else seconds + 1)
        expect_in_time(noticed, limit, f"{what}: axis {axis} noticed after {noticed:.2f} s")
        expect(failures[0]["outcome"] in ("lost", "failed", "refused"), failures[0])
        print(f"{what}: axis {axis} {failures[0]['outcome']} after {noticed:.2f} s")
    if seconds < LEASE:  # messages sent meanwhile are delivered and answered
        answer = hosts.wait_for("answer to the late set-point", lambda: reply(holder, number), PATIENCE)
        expect(answer.get("reason") == STALE_EPOCH, f"{what}: late set-point: {answer}")
        hosts.wait_for("event of the refusal", lambda: any(
            "refused: the epoch" in text for _, text in case.benches[0].events(marks[0])), PATIENCE)
    last = case.benches[0].seen("1.2")[-1]
    expect(abs(last["position"] - before) <= REST and not last["moving"],
           f"{what}: a stale command ran: {last}, was at {before}")
    holder.kill()


def ALinkFailureEndsInASafeStopAndTheClientContinues(case):
    case.start_benches()
    case.benches[0].observe(case, "1.1", "1.2")
    case.benches[1].observe(case, "2.1")
    case.start_cycle()
    # 50 ms plus the delays of a busy machine may exceed the watchdog, but not every time.
    expect(any(short_cut(case) for _ in range(10)),
           "a link that is down for less than the watchdog stopped the axes, ten times of ten")
    for seconds in (0.3, 1, 5):
        long_cut(case, seconds)
    case.expect_nothing_restarted()


def cut_off_bench_2(case):
    """Returns whether bench 1 continued undisturbed."""
    case.wait_for_moves(time.monotonic(), PATIENCE)
    mark = case.benches[1].mark()
    began = time.monotonic()
    case.b.ip("link", "set", "net", "down")
    tick = time.time() * TICKS_PER_SECOND
    noticed = hosts.wait_for("lost bench 2", lambda: case.failures("2.1", began), 3)[0]
    if noticed["outcome"] == "failed":  # the axis stopped before the bench was silent: the machine stalled
        case.b.ip("link", "set", "net", "up")
        case.wait_for_moves(time.monotonic(), PATIENCE)
        return False
    expect(noticed["outcome"] == "lost", noticed)
    print(f"bench 2 {noticed['outcome']} after {noticed['time'] - began:.2f} s")
    # A client does not count time in which it was stopped.
    late = case.lateness.longest(began) / TICKS_PER_SECOND
    expect_in_time(noticed["time"] - began, SILENCE + 0.3 + late, f"noticed late: {noticed}")
    time.sleep(max(0.0, began + 3 - time.monotonic()))  # beyond the participants' lease
    case.b.ip("link", "set", "net", "up")
    back = time.monotonic()
    case.wait_for_moves(back, PATIENCE, axes=("2.1",))
    found = next(x for x in case.calls("2.1", back) if x["call"] == "acquire")
    expect_in_time(found["time"] - back, 2, f"found again after {found['time'] - back:.2f} s")
    print(f"bench 2 found again after {found['time'] - back:.2f} s")
    events = case.benches[1].events(mark)
    times = expect_safe_stop(case, case.benches[1], events, 1, tick, "bench 2 cut off")
    expect_story(events, 1, "bench 2 cut off")
    print(f"bench 2: fault after {times[0]:.0f} ms, at rest after {times[1]:.0f} ms")
    if case.failures("1.1", began):
        return False
    expect(len(case.moves("1.1", began)) >= 3, "bench 1 did not continue")
    return True


def ABenchThatIsCutOffStopsAloneAndIsFoundAgain(case):
    case.start_benches()
    case.benches[0].observe(case, "1.1")
    case.benches[1].observe(case, "2.1")
    case.start_cycle()
    # A machine that stalls for 100 ms also stops bench 1: try again.
    expect(any(cut_off_bench_2(case) for _ in range(3)), "bench 1 suffered, three times of three")
    case.expect_nothing_restarted()


# ---- a group -------------------------------------------------------------------------------------


def ticks_of_motion(bench, axis, since):
    """The ticks after `since` at which motion of the axis began and ended."""
    began, ended = set(), set()
    was_moving = False
    for line in bench.seen(axis):
        if line["moving"] != was_moving and line["tick"] > since:
            (began if line["moving"] else ended).add(line["tick"])
        was_moving = line["moving"]
    return began, ended


def expect_one_line(case, what):
    """Both axes began and ended their moves in the same ticks."""
    for _ in range(10):
        marks = [bench.mark() for bench in case.benches]
        since = max(bench.seen(f"{bench.number}.1")[-1]["tick"] for bench in case.benches)
        case.wait_for_moves(time.monotonic(), 20, count=6, axes=(GROUP,))
        jumps = [text for bench, mark in zip(case.benches, marks) for _, text in bench.events(mark)
                 if "jumped" in text]
        if not jumps:  # a machine that stalls makes the tick number jump, and the bench drops its plan
            break
    first, second = (ticks_of_motion(bench, f"{bench.number}.1", since) for bench in case.benches)
    for name, one, other in zip(("begin", "end"), first, second):
        # One side may not have seen the latest move yet, and a sample may have been missed.
        common = len(one & other)
        expect(common >= 3, f"{what}: axes {name} apart: {sorted(one)} and {sorted(other)}")
        print(f"{what}: {common} of {max(len(one), len(other))} moves {name} on one tick")


def expect_group_goes_on(case, since, what):
    case.wait_for_moves(since, PATIENCE, axes=(GROUP,))
    print(f"{what}: the group moves again {case.moves(GROUP, since)[0]['time'] - since:.2f} s "
          "after the link is back")
    expect_one_line(case, what)


def cut_group_client(case, seconds):
    what = f"client cut off for {seconds} s"
    marks = [bench.mark() for bench in case.benches]
    began = time.monotonic()
    case.c.unplug()
    tick = time.time() * TICKS_PER_SECOND
    for bench, mark in zip(case.benches, marks):
        hosts.wait_for(f"fault on bench {bench.number}", lambda b=bench, m=mark: [
            text for _, text in b.events(m) if text == "axis 1: fault 0x8130"], PATIENCE)
    time.sleep(max(0.0, began + seconds - time.monotonic()))
    case.c.plug()
    plugged = time.monotonic()
    case.wait_for_moves(plugged, PATIENCE, axes=(GROUP,))
    for bench, mark in zip(case.benches, marks):
        events = bench.events(mark)
        expect_safe_stop(case, bench, events, 1, tick, what)
        expect_story(events, 1, f"{what}, bench {bench.number}")
    expect_group_goes_on(case, plugged, what)


def cut_group_member(case, seconds):
    what = f"bench 2 cut off for {seconds} s"
    marks = [bench.mark() for bench in case.benches]
    began = time.monotonic()
    case.b.unplug()
    tick = time.time() * TICKS_PER_SECOND
    hosts.wait_for("fault on bench 2", lambda: [
        text for _, text in case.benches[1].events(marks[1]) if text == "axis 1: fault 0x8130"], PATIENCE)
    time.sleep(max(0.0, began + seconds - time.monotonic()))
    if seconds > 2 * SILENCE:  # time enough to notice before the link is back
        failed = case.failures(GROUP, began)
        expect(failed and "2.1" in failed[0]["message"], f"{what}: {failed}")
        noticed = failed[0]["time"] - began
        print(f"{what}: '{failed[0]['message']}' after {noticed:.2f} s")
        expect(failed[0]["outcome"] in ("lost", "failed"), failed[0])
        expect_in_time(noticed, SILENCE + 1, f"{what}: noticed after {noticed:.2f} s")
        others = case.benches[0].seen("1.1")[-1]
        expect(not others["moving"], f"{what}: axis 1.1 continues alone: {others}")
        expect(others["error"] == 0, f"{what}: the axis of the reachable bench failed: {others}")
    case.b.plug()
    plugged = time.monotonic()
    case.wait_for_moves(plugged, PATIENCE, axes=(GROUP,))
    events = case.benches[1].events(marks[1])
    expect_safe_stop(case, case.benches[1], events, 1, tick, what)
    expect_story(events, 1, what)
    expect_group_goes_on(case, plugged, what)


def lose_packets_of_group(case, percent, seconds):
    what = f"{percent} % loss"
    began = time.monotonic()
    case.c.lose(percent)
    time.sleep(seconds)
    case.c.lose(0)
    ended = time.monotonic()
    moves = len([x for x in case.moves(GROUP, began) if x["time"] < ended])
    print(f"{what}: {moves} moves, {len(case.failures(GROUP, began))} calls failed in {seconds} s")
    expect_group_goes_on(case, ended, what)


def AGroupOverTwoHostsStopsSafelyAndContinuesTogether(case):
    case.start_benches()
    for bench in case.benches:
        bench.observe(case, f"{bench.number}.1")
    case.start_group()
    expect_one_line(case, "all links up")
    cut_group_client(case, 0.3)
    cut_group_client(case, 3)
    cut_group_member(case, 0.3)
    cut_group_member(case, 3)
    lose_packets_of_group(case, 1, 3)
    lose_packets_of_group(case, 20, 5)
    case.expect_nothing_restarted()


# ---- loss ----------------------------------------------------------------------------------------


def move_with_loss(case, percent, seconds):
    """Returns the failed calls, and checks the client's counts of the stream."""
    counted = {axis: case.stream(axis) for axis in ("1.1", "2.1")}
    silences = sum("silent" in line for line in case.cycle.lines())
    marks = [bench.mark() for bench in case.benches]
    began = time.monotonic()
    case.c.lose(percent)
    time.sleep(seconds)
    ended = time.monotonic()
    case.c.lose(0)
    case.wait_for_moves(ended, PATIENCE, count=2)
    failures = []
    for axis, bench, mark in zip(("1.1", "2.1"), case.benches, marks):
        calls = case.calls(axis, began)
        times = [began, *(call["time"] for call in calls if call["time"] < ended), ended]
        gap = max(later - earlier for earlier, later in zip(times, times[1:]))
        expect_in_time(gap, 3, f"{percent} % loss: axis {axis} hung for {gap:.1f} s")
        failed = case.failures(axis, began)
        stops = [text for _, text in bench.events(mark) if text == "axis 1: fault 0x8130"]
        expect(bool(stops) or not failed, f"{percent} % loss: a call failed on an axis that did "
               f"not end safe: {failed}")
        failures += failed
        moves = len([move for move in case.moves(axis, began) if move["time"] < ended])
        line = f"{percent} % loss, axis {axis}: {moves} moves, {len(stops)} stops, longest wait " \
               f"{gap:.2f} s"
        if sum("silent" in x for x in case.cycle.lines()) == silences:
            line += f", {share_missed(case, axis, counted[axis], percent):.1f} % of frames missed"
        print(line)
    return failures


def share_missed(case, axis, before, percent):
    """Checks that the client's counts agree with each other and with the loss [%]."""
    after = case.stream(axis)
    counted = after["samples"] - 1 + after["missed"] + after["skipped"]
    expect(after["first"] + counted == after["last"],
           f"axis {axis}: samples, misses and skipped ticks do not add up: {after}")
    ticks = after["last"] - before["last"] - (after["skipped"] - before["skipped"])
    share = 100 * (after["missed"] - before["missed"]) / ticks
    # A machine that stalls misses ticks, too.
    expect(0.3 * percent <= share <= 1.5 * percent + 15,
           f"axis {axis}: {share:.1f} % missed at {percent} % loss")
    return share


def PacketLossLosesNoCommandOrEndsInASafeStop(case):
    case.start_benches()
    case.start_cycle()
    hosts.wait_for("stream", lambda: case.stream("1.1") and case.stream("2.1"), START)
    # A machine that stalls for 100 ms has the same effect as a link that does: try again.
    expect(any(not move_with_loss(case, 1, 5) for _ in range(6)),
           "1 % loss: calls failed, six times of six")
    move_with_loss(case, 20, 10)
    case.expect_nothing_restarted()


def AGatewayClientWithACutCableIsALostMaster(case):
    # Only the gateway should judge its client, which a busy machine may delay by 200 ms.
    bench = Bench(case, case.a, 1, watchdog=1000)
    hosts.wait_for("start of the service",
                   lambda: any("incarnation=" in line for line in bench.service.lines()), START)
    bench.observe(case, "1.1")
    token = "0123456789abcdef"
    (case.directory / "token").write_text(f"{token}\n", encoding="utf-8")
    gateway = case.a.start("gateway", case.programs.gateway, "--interface", case.a.address,
                           "--listen", f"{case.a.address}:0", "--control", "--token",
                           case.directory / "token")
    hosts.wait_for("start of the gateway", lambda: gateway.lines(), 10)
    port = re.search(r":(\d+)/", gateway.lines()[0])[1]
    holder = case.c.start("holder", sys.executable, "-B",
                          pathlib.Path(__file__).with_name("gateway_holder.py"), case.a.address,
                          port, token, "1.1")
    hosts.wait_for("an enabled axis", lambda: len(holder.lines()) == 2, 20)
    expect(all(json.loads(line)["ok"] for line in holder.lines()), f"answers: {holder.lines()}")
    # An idle client that is present is not a lost master: it answers pings.
    time.sleep(GATEWAY_PATIENCE + 1)
    expect(bench.seen("1.1")[-1]["error"] == 0, "the client that answers pings was lost")

    case.c.unplug()
    cut = time.monotonic()
    hosts.wait_for("the fault of a lost master",
                   lambda: bench.seen("1.1")[-1]["error"] == CONNECTION_LOST, 20)
    after = time.monotonic() - cut
    # A client whose host answers but whose program does not is closed after 10 s.
    expect_in_time(after, 8, f"the fault came after {after:.1f} s")


# --------------------------------------------------------------------------------------------------


def give_up(number, _frame):
    raise hosts.Late(f"ended by {signal.Signals(number).name}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("case")
    for program in ("service", "tool", "client", "ros2", "gateway"):
        parser.add_argument(f"--{program}", required=True, type=pathlib.Path)
    programs = parser.parse_args()
    for number in (signal.SIGALRM, signal.SIGTERM, signal.SIGINT):
        signal.signal(number, give_up)
    signal.alarm(LONGEST)
    try:
        with tempfile.TemporaryDirectory(prefix="vdrive-network-") as directory:
            with Case(programs, directory) as case:
                globals()[programs.case](case)
    except hosts.Missing as reason:
        print(f"skipped: {reason}")
        return SKIPPED
    except AssertionError:
        traceback.print_exc(file=sys.stdout)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
