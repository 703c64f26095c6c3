#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Programs search for benches while services, tools and plain participants come, go and are killed.

Ten programs make a session, search, read an object and close, again and again, in one domain with
two benches that stay, on a loaded machine. No program may crash, no search may miss a bench that
stays, and each program ends when it is told to; a time in which the machine stood still does not
count. Part of tests/run.sh --full (60 s), nightly for an hour.
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
import threading

TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTS / "churn"), str(TESTS / "checks")]
import bench as benches  # pylint: disable=wrong-import-position
import standstill  # pylint: disable=wrong-import-position
from bench import Failure, now  # pylint: disable=wrong-import-position

STAYING = (1, 2)
FIRST_OF_COMING = 11
KEPT_PROBLEMS = 20
NICENESS = 5
TOOL_PATIENCE = 120.0  # [s]
LINE_PERIOD = 60.0  # [s] between progress reports of a long run
FEWEST = 50  # searches; fewer prove nothing


def threads_of(pid):
    """The state of each thread and the kernel function in which it waits, such as "S futex_wait_queue"."""
    found = []
    for task in pathlib.Path(f"/proc/{pid}/task").glob("*"):
        with contextlib.suppress(OSError):
            state = (task / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0]
            found.append(f"{state} {(task / 'wchan').read_text(encoding='utf-8')}")
    return ", ".join(sorted(found))


class Coming:
    """A thread that starts a program, ends or kills it, and starts the next."""

    def __init__(self, stress, start, killed):
        self.stress = stress
        self.start_program = start
        self.killed = killed
        self.random = random.Random(f"{stress.options.seed} {start} {len(stress.coming)}")
        self.starts = 0
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        while not self.stress.ends.is_set():
            process = self.start_program(self.random)
            self.starts += 1
            self.stress.ends.wait(self.random.uniform(0.0, 2.0))
            kills = self.random.random() < self.killed
            self.end(process, signal.SIGKILL if kills else signal.SIGTERM)

    def end(self, process, how):
        everybody = benches.descendants(process.pid) if how == signal.SIGKILL else []
        told = now()
        process.send_signal(how)
        for pid in everybody:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, how)
        if self.stress.standstills.has_ended(process, benches.PATIENCE):
            self.stress.judge(process, how)
        else:
            self.stress.kill_late(process, told, benches.PATIENCE)


class Stress:
    def __init__(self, options, directory, domain, standstills):
        self.options = options
        self.standstills = standstills
        self.directory = pathlib.Path(directory)
        self.domain = domain
        self.ends = threading.Event()
        self.lock = threading.RLock()
        self.problems = []
        self.crashes = 0
        self.late = []  # programs that were killed because they did not end: (what, told, killed, patience)
        self.missed = 0
        self.failed = 0
        self.calls = 0  # completed calls of the tool
        self.staying = []
        self.searchers = []
        self.coming = []
        self.spinners = []
        self.next_bench = 0
        self.highest_load = 0.0

    def report(self, problem):
        with self.lock:
            if len(self.problems) < KEPT_PROBLEMS:
                self.problems.append(problem)

    def judge(self, process, how):
        """A program ends by the signal that it was sent, or by itself before that."""
        code = process.returncode
        if code in (-how, -signal.SIGTERM) or code >= 0:
            return
        self.crashes += 1
        self.report(f"{' '.join(map(str, process.args))} ended by {benches.how_it_ended(process)}")

    def kill_late(self, process, told, patience):
        """Kills a program that was told to end at `told` and did not. How long the machine ran in that time
        is known only at the end of the run, because the kernel reports a standstill late."""
        what = f"{' '.join(map(str, process.args))}, its threads: {threads_of(process.pid)}"
        killed = now()
        process.kill()
        process.wait()
        self.late.append((what, told, killed, patience))

    def report_late(self):
        """@return how many programs did not end while the machine ran for the whole patience."""
        count = 0
        for what, told, killed, patience in self.late:
            ran = self.standstills.ran(told, killed)
            if ran >= patience:
                count += 1
                self.report(f"did not end within {ran:.0f} s: {what}")
        return count

    # ---- programs

    def start(self, *words):
        return subprocess.Popen(  # pylint: disable=consider-using-with
            ["nice", "-n", str(NICENESS), *map(str, words)], stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def start_service(self, chosen):
        with self.lock:
            self.next_bench = (self.next_bench + 1) % 64
            number = FIRST_OF_COMING + self.next_bench
        return self.start(self.options.service, "--domain", self.domain, "--bench", number, "--axes",
                          chosen.choice((1, 3, 300)), "--clock",
                          chosen.choice(("lockstep", "realtime")))

    def start_plain(self, _chosen):
        # It sends requests, to no bench; without this argument it would answer requests to others.
        # The name tells a guard that it announces itself ten times a second, so it is removed 2.5 s
        # after it is killed. With another name it would keep one of the 256 places for its lease of
        # 600 s.
        return self.start(self.options.visitor, self.domain, "vdrive plain participant", "request")

    def start_tool(self, chosen):
        return self.start(self.options.tool, "--domain", self.domain,
                          *chosen.choice((["list"], ["watch", "1.1"], ["status", "2.1"])))

    def list_again_and_again(self):
        """The tool as a person calls it: each call finds what stays."""
        while not self.ends.is_set():
            process = subprocess.Popen(  # pylint: disable=consider-using-with
                ["nice", "-n", str(NICENESS), self.options.tool, "--domain", str(self.domain), "list"],
                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            try:
                output, errors = process.communicate(timeout=TOOL_PATIENCE)
            except subprocess.TimeoutExpired:
                self.missed += 1
                self.report(f"vdrive list did not end within {TOOL_PATIENCE:g} s; its threads: "
                            f"{threads_of(process.pid)}")
                process.kill()
                process.communicate()
                continue
            self.calls += 1
            if process.returncode < 0:
                self.crashes += 1
                self.report(f"vdrive list ended by {benches.how_it_ended(process)}")
            for number in STAYING:
                if f"only-of-{number}" not in output:
                    self.missed += 1
                    self.report(f"vdrive list missed bench {number}: {errors.strip()}")

    # ---- the run

    def run(self):
        for number in STAYING:
            file = self.directory / f"{number}.yaml"
            file.write_text(f"axes: [{{number: 1, name: only-of-{number}}}]\n", encoding="utf-8")
            self.staying.append(benches.Bench(
                self.options.service, self.directory, self.domain, "--config", file, "--clock",
                "realtime" if number == 1 else "lockstep", number=number))
        for bench in self.staying:
            bench.find_metrics()
        self.spinners = [self.start(sys.executable, "-c", "while True: pass")
                         for _ in range(self.options.load)]
        self.searchers = [Searcher(self) for _ in range(self.options.searchers)]
        for _ in range(3):
            self.coming.append(Coming(self, self.start_service, 0.5))
        for start in (self.start_plain, self.start_tool):
            self.coming += [Coming(self, start, 0.5) for _ in range(2)]
        caller = threading.Thread(target=self.list_again_and_again)
        caller.start()
        try:
            self.watch()
        finally:
            self.ends.set()
            caller.join()
            for one in self.coming:
                one.thread.join()
            for searcher in self.searchers:
                searcher.end()
        for bench in self.staying:
            bench.check_alive()

    def searches(self):
        return sum(searcher.searches for searcher in self.searchers) + self.calls

    def watch(self):
        begin = now()
        next_line = LINE_PERIOD
        while not self.ends.is_set() and not self.is_done(now() - begin):
            for bench in self.staying:
                bench.check_alive()
            if any(searcher.has_ended() for searcher in self.searchers):
                return
            self.highest_load = max(self.highest_load, os.getloadavg()[0])
            if now() - begin >= next_line:
                next_line += LINE_PERIOD
                print(f"after {now() - begin:.0f} s: {self.searches()} searches, {self.missed} misses, "
                      f"{self.failed} failed reads, load {os.getloadavg()[0]:.1f}", flush=True)
            self.ends.wait(0.5)

    def is_done(self, seconds):
        if self.options.searches:
            return self.searches() >= self.options.searches
        return seconds >= self.options.seconds

    def end_early(self):
        """Ends the run, which shows its figures so far."""
        self.report("ended by SIGTERM")
        self.ends.set()

    def clean_up(self):
        self.ends.set()
        for searcher in self.searchers:
            searcher.process.kill()
        for spinner in self.spinners:
            spinner.kill()
            spinner.wait()
        for bench in self.staying:
            bench.kill()


class Searcher:
    """A program that searches until its input is closed."""

    def __init__(self, stress):
        self.stress = stress
        self.searches = 0
        self.process = subprocess.Popen(  # pylint: disable=consider-using-with
            ["nice", "-n", str(NICENESS), str(stress.options.searcher), str(stress.domain),
             *map(str, STAYING)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, text=True)
        self.reader = threading.Thread(target=self.read)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            key, _, value = line.strip().partition(" ")
            if key == "searches":
                self.searches = int(value)
            elif key == "missed":
                self.stress.missed += 1
                self.stress.report(f"a search missed {value}")
            elif key == "failed":
                self.stress.failed += 1
                self.stress.report(f"a read failed: {value}")

    def has_ended(self):
        return self.process.poll() is not None

    def end(self):
        had_ended = self.has_ended()
        told = now()
        with contextlib.suppress(OSError):
            self.process.stdin.close()
        if not self.stress.standstills.has_ended(self.process, TOOL_PATIENCE):
            self.stress.kill_late(self.process, told, TOOL_PATIENCE)
            self.reader.join()
            return
        code = self.process.returncode
        self.reader.join()
        if code != 0 or had_ended:
            self.stress.crashes += 1
            self.stress.report(f"a program that searches ended by {benches.how_it_ended(self.process)} "
                               f"after {self.searches} searches")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--service", required=True, help="path of vdrived")
    parser.add_argument("--tool", required=True, help="path of vdrive")
    parser.add_argument("--searcher", required=True, help="path of stress_searcher")
    parser.add_argument("--visitor", required=True, help="path of wire_visitor")
    parser.add_argument("--searchers", type=int, default=10)
    parser.add_argument("--load", type=int, default=6, help="programs that only take processor time; "
                        "with them the load of two processors is about 12")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--searches", type=int, help="until so many searches, instead of --seconds")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if benches.is_nightly() and not options.searches:
        options.seconds = 3600
    return options


def main():
    options = arguments()
    begin = now()
    watch = standstill.Watch().start()
    problems = []
    with tempfile.TemporaryDirectory(prefix="vdrive-stress-") as directory, \
            benches.claimed_domain() as domain:
        stress = Stress(options, directory, domain, watch)
        signal.signal(signal.SIGTERM, lambda *_: stress.end_early())
        try:
            stress.run()
        except Failure as failure:
            problems.append(str(failure))
        finally:
            stress.clean_up()
        watch.end()
        late = stress.report_late()
        problems += stress.problems
    starts = sum(one.starts for one in stress.coming)
    print(f"{stress.searches()} searches in {now() - begin:.0f} s, {stress.crashes} crashes, "
          f"{stress.missed} misses, {stress.failed} failed reads, "
          f"{late} programs that did not end in time, {len(stress.late) - late} more while the machine "
          f"stood still; {starts} starts of services, tools "
          f"and plain participants beside them; highest load {stress.highest_load:.1f}")
    print(watch.report())
    if stress.searches() < FEWEST:
        problems.append(f"only {stress.searches()} searches")
    for problem in problems:
        print(f"FAIL: {problem}")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
