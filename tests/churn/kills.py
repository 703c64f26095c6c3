#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A bench whose wire process is killed repeatedly while programs use it.

  kills.py --service VDRIVED --client CHURN_CLIENT [--kills N] [--variant NAME]... ...

The wire process is the descendant of vdrived whose command line contains --wire-process. It is
killed at random moments: kill -9, SIGABRT, or SIGSTOP, a hang that the service must detect and end.
The kills are divided among the variants:

  motion     48 of 64 axes move at 4 UU per tick, 8 are commanded axis by axis
  streaming  a group of 4 axes receives a position in each tick
  group      moves of 4 axes on two benches; either wire is killed
  stores     parameters are stored, --state
  lockstep   one-tick steps, --clock lockstep --wire process
  closed     like motion, --security

It passes if all of this holds in each variant:
- the service is the same process and the same incarnation from the beginning to the end, without a
  jump, and every numbered tick was run;
- every sample that an observer receives shows the moving axes at their expected positions in that
  tick, as without kills;
- the programs and the observers run to the end without a restart, and every call succeeds;
  positions of a stream may be late (they are printed), but its axes end at the last position; a
  move on two benches may be refused by the one whose wire was killed, once per kill, and is
  repeated;
- each acknowledged command acted once: n moves moved an axis by n distances, n steps are n ticks,
  the stamp is the last one, and stored values are present in the next run of the service;
- the time from a kill to the next sample of the observer (in lock-step: to the answer of the step
  in progress) stays within the limits; the medians of each variant and of all are judged from ten
  kills on;
- there are at most twice as many overruns as in a run of the same length without kills, and some
  more for each kill;
- 2 s after SIGTERM no process of the service is left, nor a file in /dev/shm.

Exit code 0: passed, 1: failed, 77: this vdrived has no wire process.
"""

import argparse
import contextlib
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

import bench as benches
from bench import Failure, now, percentile

SKIPPED = 77
STEADY = 48
COMMANDED = 8
GROUP_AXES = 4
SHORTEST = 0.005  # [s] of a pause in the stream that the observer prints
NEAR = 0.25  # [s] after a kill, within which samples in transit may still arrive
ENOUGH = 10  # kills required to judge their median
HANG_LIMIT = 5.0  # [s] within which a hung wire is noticed
VARIANTS = ("motion", "streaming", "group", "stores", "lockstep", "closed")
HOW = {"kill": signal.SIGKILL, "abort": signal.SIGABRT, "hang": signal.SIGSTOP}
SHARES = (0.7, 0.15, 0.15)  # of kill, abort, hang
MAY_FAIL = {"stream": "stream", "group": "move_together"}  # role -> call with a tick as its deadline


def has_wire_option(service):
    report = subprocess.run([service, "--help"], capture_output=True, text=True, check=True).stdout
    return "--wire" in report


def make_material(directory):
    """Makes the files of closed mode. @return the directories of the service and of a controller.
    """
    scripts = pathlib.Path(__file__).parents[2] / "deploy" / "security"
    authority = pathlib.Path(directory) / "authority"

    def run(*words):
        subprocess.run([str(word) for word in words], check=True, capture_output=True)

    run(scripts / "make_authority.sh", authority)
    run(scripts / "make_member.sh", authority, "service", "bench")
    run(scripts / "make_member.sh", authority, "controller", "client")
    return authority / "members" / "bench", authority / "members" / "client"


class Variant:
    """Benches, observers and a program, and the kills of their wires."""

    def __init__(self, options, directory, domain, name):
        self.options = options
        self.directory = directory
        self.domain = domain
        self.name = name
        self.security = None
        self.benches = []
        self.watchers = {}  # bench number -> the program that prints pauses
        self.programs = []
        self.pauses = {how: [] for how in HOW}
        self.problems = []
        self.usages = []
        self.overruns = 0
        self.jumps = 0

    # ---- begin

    def start_bench(self, number, axes, *words):
        config = pathlib.Path(self.directory) / f"{self.name}.yaml"
        # The reaction of 6007h to a lost master is not tested here.
        config.write_text("watchdog: {timeout_ms: 10000}\naxes:\n  - number: 1\n",
                          encoding="utf-8")
        bench = benches.Bench(self.options.service, self.directory, self.domain, "--config", config,
                              "--axes", axes, "--wire", "process", *words, number=number)
        self.benches.append(bench)
        self.usages.append(benches.Usage(bench))
        bench.find_metrics()
        benches.wait_for("a wire process", lambda: bench.check_alive() or bench.wire_processes())

    def run_program(self, role, *words, bench=1):
        program = benches.Program(self.options.client, self.domain, role, *words, bench=bench,
                                  security=self.security)
        self.programs.append(program)
        return program

    def watch(self, number, steady):
        benches.run_role(self.options.client, self.domain, "start", "--first", 1, "--last", steady,
                         bench=number, security=self.security)
        observer = self.run_program("observe", "--first", 1, "--last", steady, bench=number)
        self.watchers[number] = observer
        benches.wait_for("the observer's first sample", lambda: observer.found("watching"))

    def begin(self):
        first = STEADY + 1
        if self.name in ("motion", "closed"):
            words = []
            if self.name == "closed":
                service, self.security = make_material(self.directory)
                words = ["--security", service]
            self.start_bench(1, STEADY + 2 * COMMANDED, *words)
            self.watch(1, STEADY)
            self.run_program("motion", "--first", first, "--last", STEADY + COMMANDED)
        elif self.name == "streaming":
            self.start_bench(1, STEADY + 2 * COMMANDED)
            self.watch(1, STEADY)
            self.run_program("stream", "--first", first, "--last", STEADY + GROUP_AXES, "--lead",
                             self.options.lead)
        elif self.name == "group":
            for number in (1, 2):
                self.start_bench(number, 16)
                self.watch(number, 12)
            self.run_program("group", "1.13", "1.14", "2.13", "2.14")
        elif self.name == "stores":
            state = pathlib.Path(self.directory) / f"state-{now()}"
            state.mkdir()
            self.state = state
            self.start_bench(1, STEADY + 2 * COMMANDED, "--state", state)
            self.watch(1, STEADY)
            self.run_program("store", "--first", first)
        else:
            self.start_bench(1, 16, "--clock", "lockstep")
            self.watchers[1] = self.run_program("step")

    # ---- kills

    def kill_once(self, chance):
        bench = chance.choice(self.benches)
        how = chance.choices(list(HOW), SHARES)[0]
        before = bench.wire_processes()
        if not before:
            raise Failure("there is no wire process to kill")
        moment = now()
        for pid in before:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, HOW[how])
        limit = self.options.longest + (HANG_LIMIT if how == "hang" else 0.0)

        def is_replaced():
            bench.check_alive()
            wires = bench.wire_processes()
            return wires and not set(wires) & set(before)

        try:
            benches.wait_for("another wire process", is_replaced, limit)
            back = now()
            self.pauses[how].append(self.pause_after(bench, moment, back, limit))
        except Failure as failure:
            raise Failure(f"{how} of a wire process: {failure}") from failure

    def pause_after(self, bench, moment, back, limit):
        """@return seconds from `moment` to the end of the longest pause caused by the kill."""
        watcher = self.watchers[bench.number]
        benches.wait_for("the next sample", lambda: [
            line for line in watcher.found("seen")[-1:] if line["time"] > max(back, moment + NEAR)
        ], max(1.0, moment + limit - back))
        # A pause is printed before the sample that ends it is counted. If none was printed, samples
        # continued without one.
        pauses = [line["pause"] for line in watcher.found("pause")
                  if line["pause"][1] > moment and line["pause"][0] < moment + NEAR]
        longest = max(pauses, key=lambda pause: pause[1] - pause[0], default=None)
        return longest[1] - moment if longest else SHORTEST

    def run(self, kills, seconds, chance):
        """Kills this number of wires; for none, waits `seconds`. @return the duration [s]."""
        self.begin()
        before = [bench.account() for bench in self.benches]
        begin = now()
        sampled = begin
        done = 0
        while done < kills or now() - begin < seconds:
            wait = chance.uniform(*self.options.interval)
            time.sleep(wait if kills else min(0.5, wait))
            for bench in self.benches:
                bench.check_alive()
            if done < kills:
                self.kill_once(chance)
                done += 1
            if now() - sampled >= 1.0:
                sampled = now()
                for usage in self.usages:
                    usage.sample()
        length = now() - begin
        self.end_programs()
        self.compare(before, [bench.account() for bench in self.benches])
        self.end_observers()
        for bench in self.benches:
            bench.stop()
        if self.name == "stores":
            self.judge_durable()
        return length

    # ---- end

    def end_programs(self):
        for program in self.programs:
            if program in self.watchers.values() and program.role == "observe":
                continue
            self.judge_program(program, program.end(60))

    def end_observers(self):
        for program in self.programs:
            if program.role == "observe":
                self.judge_observer(program, program.end())

    def judge_program(self, program, code):
        if code != 0:
            self.problems.append(f"the program '{program.role}' ended with {code}: "
                                 f"{program.errors.strip()[-200:]}")
        failed = [line for line in program.found("failed")
                  if MAY_FAIL.get(program.role) != line["failed"]]
        if failed:
            self.problems.append(f"{len(failed)} calls of '{program.role}' failed: "
                                 f"{failed[0]['failed']}: {failed[0]['kind']}: "
                                 f"{failed[0]['message']}")
        getattr(self, f"judge_{program.role}")(program)

    def judge_count(self, what, acted, line):
        least = line["acknowledged"]
        if not least <= acted <= least + line["uncertain"]:
            self.problems.append(f"{what}: {least} acknowledged, {line['uncertain']} without an "
                                 f"answer, {acted:g} acted")
        if not least:
            self.problems.append(f"{what}: nothing was acknowledged")

    def judge_motion(self, program):
        axes = program.found("axis")
        if len(axes) != COMMANDED:
            self.problems.append(f"{len(axes)} axes of {COMMANDED} came to their end")
        for line in axes:
            self.judge_count(f"moves of axis {line['axis']}", line["moved"] / line["distance"], line)
            if not line["last_stamp"] - line["uncertain_stamps"] <= line["stamp"] <= line["last_stamp"]:
                self.problems.append(f"axis {line['axis']} has the stamp {line['stamp']}, the last "
                                     f"written was {line['last_stamp']}")
        print(f"  {sum(line['acknowledged'] for line in axes)} moves and "
              f"{sum(line['stamps'] for line in axes)} writes acknowledged")

    def judge_stream(self, program):
        line = program.found("positions")[-1]
        print(f"  {line['positions']} positions streamed, {line['interruptions']} interruptions")
        if line.get("off") != 0.0:
            self.problems.append("the axes did not end on the last streamed position: "
                                 f"{line.get('off', 'no position')} UU off")
        self.judge_late(f"{line['interruptions']} interruptions of the stream",
                        line["interruptions"])

    def judge_late(self, what, count):
        """On a machine that stalls, set-points are late, too."""
        if count > sum(map(len, self.pauses.values())) and not self.options.allow_jumps:
            self.problems.append(f"{what}, more than kills")

    def judge_group(self, program):
        line = program.found("acknowledged")[-1]
        print(f"  {line['acknowledged']} moves of the group, {line['refused']} refused and repeated")
        if not line["least"] == line["most"] == line["acknowledged"] > 0:
            self.problems.append(f"{line['acknowledged']} moves of the group were acknowledged, its "
                                 f"axes have moved {line['least']:g} to {line['most']:g} ways")
        self.judge_late(f"{line['refused']} moves of the group were refused", line["refused"])

    def judge_store(self, program):
        self.stored = program.found("durable")[-1]
        print(f"  {self.stored['acknowledged']} stores acknowledged")
        if not self.stored["acknowledged"]:
            self.problems.append("no store was acknowledged")

    def judge_step(self, program):
        line = program.found("ticks")[-1]
        print(f"  {line['acknowledged']} steps")
        self.judge_count("one-tick steps", line["ticks"], line)
        if line["wrong"]:
            self.problems.append(f"{line['wrong']} steps led to another tick than the next")

    def judge_durable(self):
        """Another run of the service has the stamp that was stored last."""
        self.begin_again = benches.Bench(self.options.service, self.directory, self.domain,
                                         "--axes", STEADY + 2 * COMMANDED, "--state", self.state)
        self.benches.append(self.begin_again)
        line = benches.run_role(self.options.client, self.domain, "read", "--axis", STEADY + 1,
                                "--object", 0x6067)[-1]
        if not self.stored["durable"] <= line["value"] <= self.stored["last_stamp"]:
            self.problems.append(f"stored was {self.stored['durable']}, the next run of the service "
                                 f"has {line['value']}")
        self.begin_again.stop()

    def judge_observer(self, observer, code):
        totals = observer.found("total")
        if code != 0 or not totals:
            self.problems.append(f"the observer ended with {code}")
            return
        total = totals[-1]
        print(f"  observer: {total['total']} ticks received, {total['missed']} not received, "
              f"{total['deviations']} in which a moving axis was not in its place")
        if total["deviations"] > self.jumps:
            report = observer.found("deviation")[0]
            self.problems.append(f"tick {report['tick']}: {report['deviation']}")
        if total["backwards"]:
            self.problems.append(f"{total['backwards']} ticks came twice or out of order")

    def compare(self, before, after):
        for old, new in zip(before, after):
            self.overruns += int(new["vdrive_tick_overruns_total"]
                                 - old["vdrive_tick_overruns_total"])
            jumps = int(new["vdrive_tick_jumps_total"] - old["vdrive_tick_jumps_total"])
            self.jumps += jumps
            left_out = new["numbered_not_run"] - old["numbered_not_run"]
            if old["incarnation"] != new["incarnation"]:
                self.problems.append("the service has another incarnation")
            if jumps and not self.options.allow_jumps:
                self.problems.append(f"{jumps} jumps of the tick")
            if left_out and not jumps:
                self.problems.append(f"{left_out} ticks were numbered and not run")

    def clean_up(self):
        for program in self.programs:
            program.kill()
        for bench in self.benches:
            bench.kill()


def report_pauses(pauses, options):
    """@return the values beyond the limits."""
    problems = []
    quick = pauses["kill"] + pauses["abort"]
    for name, values in (("killed or aborted", quick), ("hung", pauses["hang"])):
        if values:
            print(f"  {name}: {len(values)}, to the next sample p50 {percentile(values, 0.5):.3f} s, "
                  f"p99 {percentile(values, 0.99):.3f} s, max {max(values):.3f} s")
    # In closed mode the library repeats some authentication messages after a second, so two slow
    # kills in a row prove nothing.
    if len(quick) >= ENOUGH and percentile(quick, 0.5) > options.usual:
        problems.append(f"half of the kills took more than {options.usual:g} s")
    return problems


def run_once(options, directory, domain, name, kills, seconds):
    """@return (length, overruns, pauses, problems)."""
    variant = Variant(options, directory, domain, name)
    try:
        length = variant.run(kills, seconds, random.Random(f"{options.seed}{name}"))
        variant.problems += report_pauses(variant.pauses, options)
        for usage in variant.usages:
            if kills:
                variant.problems += usage.report(options.warm_up, (
                    options.memory_growth, options.descriptor_growth, options.thread_growth))
        return length, variant.overruns, variant.pauses, variant.problems
    except Failure as failure:
        return 0.0, 0, variant.pauses, [*variant.problems, str(failure)]
    finally:
        variant.clean_up()


def run_variant(options, directory, domain, name, kills):
    print(f"{name}: {kills} kills", flush=True)
    length, overruns, pauses, problems = run_once(options, directory, domain, name, kills, 0.0)
    if length and name in options.reference:
        print(f"{name}: without kills", flush=True)
        _, usual, _, others = run_once(options, directory, domain, name, 0, length)
        bound = 2 * usual + options.overruns_per_kill * kills
        print(f"  overruns in {length:.0f} s: {overruns} with kills, {usual} without "
              f"(bound {bound:g})")
        if overruns > bound:
            problems.append(f"{overruns} overruns with kills, {usual} without")
        problems += [f"without kills: {problem}" for problem in others]
    elif length:
        print(f"  overruns in {length:.0f} s: {overruns}")
    return pauses, [f"{name}: {problem}" for problem in problems]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--service", required=True, help="path of vdrived")
    parser.add_argument("--client", required=True, help="path of churn_client")
    parser.add_argument("--kills", type=int, default=20, help="in all variants together")
    parser.add_argument("--variant", action="append", choices=VARIANTS, help="default all")
    parser.add_argument("--reference", action="append", choices=VARIANTS,
                        help="variants that are run without kills too; default all")
    parser.add_argument("--no-reference", action="store_true")
    parser.add_argument("--interval", type=float, nargs=2, default=(1.1, 2.5),
                        metavar=("LEAST", "MOST"),
                        help="time between kills [s]; wires that end within a second again and "
                        "again are a crash loop, in which the service waits before each start")
    parser.add_argument("--usual", type=float, default=0.5,
                        help="half of the kills: to the next sample [s]")
    parser.add_argument("--longest", type=float, default=3.0,
                        help="every kill: to the next sample [s]; a hang 5 s more")
    parser.add_argument("--overruns-per-kill", type=float, default=10)
    parser.add_argument("--lead", type=int, default=10, help="of the stream [ms]")
    parser.add_argument("--allow-jumps", action="store_true",
                        help="a jump is forgiven, and so is what comes late; one deviation of the "
                        "observer for each jump that the service counted")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--warm-up", type=float, default=20)
    parser.add_argument("--memory-growth", type=float, default=16, help="[MiB]")
    parser.add_argument("--descriptor-growth", type=float, default=8)
    parser.add_argument("--thread-growth", type=float, default=4)
    parser.add_argument("--brief", action="store_true",
                        help="sizes of a check that runs with every change: 20 kills, none without, "
                        "--allow-jumps; with VDRIVE_NIGHTLY=1 those of a night: 1,000")
    options = parser.parse_args()
    if options.brief:
        is_nightly = benches.is_nightly()
        options.kills = 1000 if is_nightly else 20
        options.no_reference = not is_nightly
        options.allow_jumps |= not is_nightly  # changes are checked on machines that stall
        options.interval = options.interval if is_nightly else (0.1, 0.5)
    options.variant = options.variant or list(VARIANTS)
    options.reference = [] if options.no_reference else options.reference or list(VARIANTS)
    return options


def main():
    options = arguments()
    # Ending this program ends the programs that it started.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by SIGTERM"))
    if not has_wire_option(options.service):
        print("SKIP this vdrived has no --wire: there is no wire process to kill")
        return SKIPPED
    problems = []
    pauses = {how: [] for how in HOW}
    with tempfile.TemporaryDirectory(prefix="vdrive-kills-") as directory, \
            benches.claimed_domain() as domain:
        for place, name in enumerate(options.variant):
            count = len(options.variant)
            kills = options.kills // count + (place < options.kills % count)
            if not kills:
                continue
            found, wrong = run_variant(options, directory, domain, name, kills)
            problems += wrong
            for how, values in found.items():
                pauses[how] += values
    print("all variants:")
    problems += [f"all variants: {problem}" for problem in report_pauses(pauses, options)]
    for problem in problems[1:]:
        print(f"also: {problem}")
    if problems:
        print(f"FAIL {problems[0]}")
        return 1
    print(f"PASS {sum(map(len, pauses.values()))} kills")
    return 0


if __name__ == "__main__":
    sys.exit(main())
