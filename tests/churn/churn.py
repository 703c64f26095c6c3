#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A bench with moving axes, while clients come and go.

  churn.py --service VDRIVED --client CHURN_CLIENT [--seconds N] [--axes N] [--clients N] ...

Most axes move at 4 UU per tick from beginning to end, without an owner. An observer follows every
tick of all axes. The other axes are visited: a visitor is a process that joins, acquires an axis,
commands it for about 200 ms, and leaves. Some visitors are killed (kill -9), and some hang
(SIGSTOP) and are killed afterwards.

It passes if all of this holds:
- the service is the same process and the same incarnation from the beginning to the end;
- no tick is missing: the tick number and the number of ticks run grew equally, without a jump
  (--allow-jumps), and every sample that the observer received shows each moving axis at its
  expected position in that tick;
- the observer was never without a sample for longer than --longest-silence;
- every visitor that was not killed got an answer to each command, and each command acted once:
  n relative moves moved the axis by n steps, and the stamp is the last one written. After a killed
  visitor, the next one finds the acknowledged moves and stamp, or those plus the one in progress;
- the watchdog took no axis from a visitor that was not killed;
- after the warm-up, memory, descriptors and threads of the service and its descendants grew within
  the bounds;
- 2 s after SIGTERM no process of the service is left, nor a file in /dev/shm.

Exit code 0: passed, 1: failed, with the reason.
"""

import argparse
import contextlib
import dataclasses
import random
import signal
import sys
import tempfile
import threading
import time

import bench as benches
from bench import Failure, now, percentile

STEP = 16  # [UU] of a relative move of a visitor
WATCHDOG = 3.0  # [s] after which an axis whose master is silent is free
FREE_AGAIN = WATCHDOG + 2  # [s] from a kill until its axis is visited again
LONGEST_VISIT = 60.0  # [s]
KEPT_FAILURES = 20


@dataclasses.dataclass
class Ledger:
    """The state in which the next visitor must find an axis."""

    base: int | None = None  # [UU] where the last visitor began; None = unknown
    done: int = 0  # acknowledged moves
    begun: int = 0  # moves sent: as many, or one more
    stamps: set = dataclasses.field(default_factory=set)  # the possible values; empty = any
    next_stamp: int = 1000
    free_at: float = 0.0


@dataclasses.dataclass
class Counts:
    visits: int = 0
    clean: int = 0
    killed: int = 0
    hung: int = 0
    moves: int = 0
    stamps: int = 0
    found: int = 0
    after_kill: int = 0
    unreleased: int = 0


class Visitors:
    """Slots, in each of which one visitor follows another."""

    def __init__(self, options, domain, axes, is_bench_alive):
        self.options = options
        self.domain = domain
        self.ledgers = {axis: Ledger() for axis in axes}
        self.is_bench_alive = is_bench_alive
        self.counts = Counts()
        self.join_times = []
        self.failures = []
        self.lock = threading.Lock()
        self.is_over = threading.Event()
        self.begin = now()
        self.threads = [threading.Thread(target=self.serve, args=(slot,))
                        for slot in range(options.clients)]

    def start(self):
        for thread in self.threads:
            thread.start()

    def stop(self):
        self.is_over.set()
        for thread in self.threads:
            thread.join()

    def fail(self, text):
        """Notes a failure, unless the bench has ended: that is reported once, elsewhere."""
        with self.lock:
            if self.is_bench_alive():
                self.failures.append(f"{text} ({now() - self.begin:.0f} s after the first visit)")

    def serve(self, slot):
        chance = random.Random(self.options.seed * 1000 + slot)
        while not self.is_over.is_set() and self.is_bench_alive():
            axis = self.take_axis(chance)
            if axis is None:
                time.sleep(0.05)
                continue
            try:
                self.visit(axis, chance)
            except Exception as problem:  # pylint: disable=broad-except
                self.fail(f"visit of axis {axis}: {type(problem).__name__}: {problem}")
                self.give_back(axis, FREE_AGAIN)

    def take_axis(self, chance):
        with self.lock:
            free = [axis for axis, ledger in self.ledgers.items() if ledger.free_at <= now()]
            if not free:
                return None
            axis = chance.choice(free)
            self.ledgers[axis].free_at = float("inf")
            return axis

    def give_back(self, axis, delay):
        with self.lock:
            self.ledgers[axis].free_at = now() + delay

    def visit(self, axis, chance):
        ledger = self.ledgers[axis]
        fate = chance.random()
        is_killed = fate < self.options.killed
        is_hung = not is_killed and fate < self.options.killed + self.options.hung
        begin = now()
        program = benches.Program(self.options.client, self.domain, "visit", "--axis", axis,
                                  "--duration", self.options.visit, "--stamp", ledger.next_stamp,
                                  niceness=benches.VISITOR_NICENESS)
        if is_killed or is_hung:
            self.end_early(program, chance, is_hung)
        code = program.end(LONGEST_VISIT)
        was_killed = code == -signal.SIGKILL
        self.judge(axis, ledger, program, begin, code, was_killed)
        is_unreleased = bool(program.found("unreleased"))
        self.give_back(axis, FREE_AGAIN if code != 0 or is_unreleased else 0.0)
        with self.lock:
            self.counts.unreleased += is_unreleased
            self.counts.visits += 1
            self.counts.clean += code == 0
            self.counts.killed += was_killed and is_killed
            self.counts.hung += was_killed and is_hung

    def end_early(self, program, chance, is_hung):
        """Kills it at any moment: while it joins, commands or leaves."""
        with contextlib.suppress(Exception):
            program.process.wait(chance.uniform(0.0, 1.0 + self.options.visit / 1000))
        if is_hung and program.process.poll() is None:
            program.process.send_signal(signal.SIGSTOP)
            self.is_over.wait(chance.uniform(0.5, 3.0))
        if program.process.poll() is None:
            program.process.kill()

    def judge(self, axis, ledger, program, begin, code, was_killed):
        lines = list(program.lines)
        where = f"axis {axis}"
        if code != 0 and not was_killed:
            report = program.found("failed")
            why = (f"{report[-1]['failed']}: {report[-1]['kind']}: {report[-1]['message']}" if report
                   else f"code {code}: {program.errors.strip()[-200:]}")
            self.fail(f"a visitor of {where} that was not killed was not served: {why}")
        for line in lines:
            if "found" in line:
                self.judge_found(where, ledger, line)
            elif "base" in line:
                ledger.base, ledger.done, ledger.begun = line["base"], 0, 0
            elif line.get("start") == "move":
                ledger.begun += 1
            elif line.get("done") == "move":
                ledger.done += 1
                if ledger.done == 1:
                    self.join_times.append(line["time"] - begin)
            elif line.get("start") == "stamp":
                ledger.stamps.add(line["stamp"])
            elif line.get("done") == "stamp":
                ledger.stamps = {line["stamp"]}
            elif "read" in line and line["read"] != line["written"]:
                self.fail(f"{where}: the stamp {line['written']} was acknowledged, "
                          f"{line['read']} is there")
            elif "demand" in line and line["demand"] != ledger.base + STEP * ledger.done:
                self.fail(f"{where}: {ledger.done} moves of {STEP} UU were acknowledged, "
                          f"and it moved by {line['demand'] - ledger.base} UU")
        with self.lock:
            self.counts.moves += ledger.done if program.found("base") else 0
            self.counts.stamps += sum(line.get("done") == "stamp" for line in lines)
        ledger.next_stamp = max([ledger.next_stamp, *(stamp + 1 for stamp in ledger.stamps)])

    def judge_found(self, where, ledger, line):
        """Checks the state that the previous visitor left."""
        with self.lock:
            self.counts.found += ledger.base is not None
            self.counts.after_kill += ledger.begun > ledger.done
        if ledger.base is not None:
            moved = (line["found"] - ledger.base) / STEP
            if round(moved) not in (ledger.done, ledger.begun):
                self.fail(f"{where}: {ledger.done} moves were acknowledged of {ledger.begun} sent, "
                          f"and {moved:.2f} have acted")
        if ledger.stamps and line["stamp"] not in ledger.stamps:
            self.fail(f"{where} has the stamp {line['stamp']}, written was {sorted(ledger.stamps)}")
        ledger.stamps = {line["stamp"]}


class Churn:
    def __init__(self, options, directory, domain):
        self.options = options
        self.domain = domain
        self.problems = []
        config = f"{directory}/churn.yaml"
        with open(config, "w", encoding="utf-8") as file:
            file.write(f"watchdog: {{timeout_ms: {round(WATCHDOG * 1000)}}}\n"
                       "axes:\n  - number: 1\n")
        self.bench = benches.Bench(options.service, directory, domain, "--config", config, "--clock",
                                   "realtime", "--axes", options.axes, *options.service_option)
        self.usage = benches.Usage(self.bench)
        self.observer = None
        self.visitors = None
        self.jumps = 0

    def run(self):
        self.bench.find_metrics()
        steady = self.options.axes - self.options.visited
        benches.run_role(self.options.client, self.domain, "start", "--first", 1, "--last", steady)
        self.observer = benches.Program(self.options.client, self.domain, "observe", "--first", 1,
                                        "--last", steady)
        benches.wait_for("the observer's first sample",
                         lambda: self.bench.check_alive() or self.observer.found("watching"))
        before = self.bench.account()
        self.visitors = Visitors(self.options, self.domain,
                                 range(steady + 1, self.options.axes + 1),
                                 lambda: self.bench.process.poll() is None)
        self.visitors.start()
        try:
            self.watch()
        finally:
            self.visitors.stop()
            self.report_visits()
        self.bench.check_alive()
        self.compare(before, self.bench.account())
        self.judge_observer()
        options = self.options
        self.problems += self.usage.report(
            options.warm_up, (options.memory_growth, options.descriptor_growth,
                              options.thread_growth))
        print(f"end: {self.bench.stop():.2f} s after SIGTERM")

    def watch(self):
        end = now() + self.options.seconds
        while now() < end:
            self.bench.check_alive()
            if not self.options.keep_going:
                self.observer.check_alive()
            self.usage.sample()
            if len(self.visitors.failures) > KEPT_FAILURES and not self.options.keep_going:
                return
            time.sleep(min(1.0, max(0.0, end - now())))

    def report_visits(self):
        counts = self.visitors.counts
        joins = self.visitors.join_times
        print(f"visits: {counts.visits}, {counts.clean} to their end, {counts.killed} killed, "
              f"{counts.hung} hung and killed, {counts.unreleased} left without an answer to the "
              "release")
        print(f"commands acknowledged: {counts.moves} moves, {counts.stamps} stamps; what was left "
              f"was checked by the next visitor: {counts.found} times, {counts.after_kill} of them "
              "with a move under way at a kill")
        print(f"from the start of a program to its first acknowledged move: p50 "
              f"{percentile(joins, 0.5):.2f} s, p99 {percentile(joins, 0.99):.2f} s, "
              f"max {max(joins, default=0.0):.2f} s")
        self.problems += self.visitors.failures
        if not counts.moves:
            self.problems.append("no visitor got a move acknowledged")

    def compare(self, before, after):
        def grown(name):
            return int(after[name] - before[name])

        ticks = grown("vdrive_ticks_total")
        jumps = grown("vdrive_tick_jumps_total")
        left_out = after["numbered_not_run"] - before["numbered_not_run"]
        print(f"bench: {ticks} ticks run, {grown('vdrive_tick')} numbered, {left_out} left out, "
              f"{grown('vdrive_tick_overruns_total')} overruns, {jumps} jumps, "
              f"{grown('vdrive_watchdog_trips_total')} masters lost, "
              f"{grown('vdrive_queue_overflows_total')} queue overflows")
        counts = self.visitors.counts
        may_be_lost = counts.killed + counts.hung + counts.unreleased
        lost = grown("vdrive_watchdog_trips_total")
        if lost > may_be_lost and not self.visitors.failures and not self.forgives(jumps):
            self.problems.append(f"the watchdog found {lost} masters silent, {may_be_lost} were "
                                 "killed or left without an answer")
        if after["incarnation"] != before["incarnation"]:
            self.problems.append("the service has another incarnation")
        self.jumps = jumps
        if jumps and not self.options.allow_jumps:
            self.problems.append(f"{jumps} jumps of the tick")
        if left_out and not jumps:
            self.problems.append(f"{left_out} ticks were numbered and not run, without a jump")
        if ticks < 0.9 * self.options.seconds * benches.TICKS_PER_SECOND and not jumps:
            self.problems.append(f"only {ticks} ticks in {self.options.seconds} s")

    def forgives(self, jumps):
        """Whether losses and silences are excused: a machine that stalls silences masters, too."""
        return jumps and self.options.allow_jumps

    def judge_observer(self):
        self.observer.end()
        if not self.observer.found("total"):
            self.observer.check_alive()
        total = self.observer.found("total")[-1]
        pauses = [line["pause"][1] - line["pause"][0] for line in self.observer.found("pause")]
        print(f"observer: {total['total']} ticks received, {total['missed']} not received by the "
              f"observer, longest without a sample {max(pauses, default=0.0):.3f} s, "
              f"{total['deviations']} ticks in which a moving axis was not in its place")
        if total["backwards"]:
            self.problems.append(f"{total['backwards']} ticks came twice or out of order")
        if total["deviations"] > self.jumps:
            report = self.observer.found("deviation")[0]
            self.problems.append(f"tick {report['tick']}: {report['deviation']}")
        if max(pauses, default=0.0) > self.options.longest_silence and not self.forgives(self.jumps):
            self.problems.append(f"the observer was without a sample for {max(pauses):.2f} s")

    def clean_up(self):
        if self.observer:
            self.observer.kill()
        self.bench.kill()


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--service", required=True, help="path of vdrived")
    parser.add_argument("--client", required=True, help="path of churn_client")
    parser.add_argument("--seconds", type=float, default=180)
    parser.add_argument("--axes", type=int, default=1024)
    parser.add_argument("--visited", type=int, help="axes that are visited; default an eighth, at "
                        "least three for each client")
    parser.add_argument("--clients", type=int, default=10)
    parser.add_argument("--visit", type=int, default=200, help="time of commanding [ms]")
    parser.add_argument("--killed", type=float, default=0.15, help="part that is killed")
    parser.add_argument("--hung", type=float, default=0.05, help="part that hangs and is killed")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--allow-jumps", action="store_true", help="a jump is forgiven, and so is what comes "
                        "late; one deviation of the observer for each jump that the service counted")
    parser.add_argument("--longest-silence", type=float, default=2.0, help="of the observer [s]")
    parser.add_argument("--warm-up", type=float, default=60, help="not judged for growth [s]")
    parser.add_argument("--memory-growth", type=float, default=32, help="[MiB]")
    parser.add_argument("--descriptor-growth", type=float, default=8)
    parser.add_argument("--thread-growth", type=float, default=4)
    parser.add_argument("--keep-going", action="store_true",
                        help=f"not to end after {KEPT_FAILURES} failures")
    parser.add_argument("--service-option", action="append", default=[],
                        help="passed on to vdrived, such as --service-option=--wire=thread")
    parser.add_argument("--brief", action="store_true",
                        help="sizes of a check that runs with every change: 20 s, 256 axes, 6 "
                        "clients, --allow-jumps; with VDRIVE_NIGHTLY=1 an hour and the other defaults")
    options = parser.parse_args()
    if options.brief and benches.is_nightly():
        options.seconds = 3600
    elif options.brief:
        options.seconds, options.axes, options.clients, options.warm_up = 20, 256, 6, 10
        options.allow_jumps = True  # changes are checked on machines that stall
    if options.visited is None:
        options.visited = max(options.axes // 8, 3 * options.clients)
    return options


def main():
    options = arguments()
    # Ending this program ends the programs that it started.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by SIGTERM"))
    problems = []
    begin = now()
    with tempfile.TemporaryDirectory(prefix="vdrive-churn-") as directory, \
            benches.claimed_domain() as domain:
        churn = Churn(options, directory, domain)
        try:
            churn.run()
        except Failure as failure:
            problems.append(str(failure))
        finally:
            churn.clean_up()
        problems += churn.problems
    for problem in problems[1:KEPT_FAILURES]:
        print(f"also: {problem}")
    if problems:
        print(f"FAIL after {now() - begin:.0f} s: {problems[0]}")
        return 1
    print(f"PASS {options.axes} axes, {options.clients} clients, {options.seconds:g} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
