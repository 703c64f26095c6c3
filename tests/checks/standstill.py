#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reports when the machine stood still.

A host may leave a virtual machine without a processor for many seconds, which makes every deadline
in it fail.

  standstill.py watch    observes until SIGTERM, then prints a report

There are two sources. A loop that sleeps 100 ms notes each gap above 2 s; it needs no privileges,
and also notices that the program was starved. Where the kernel's log may be read, its watchdogs
report stalls there.

The time stamps of the log are not CLOCK_MONOTONIC: their clock is never corrected, so they differ
by some seconds after a week. CLOCK_MONOTONIC_RAW is not corrected either, and uses the same counter
of the processor, so its difference to CLOCK_MONOTONIC is subtracted from the stamps. The remaining
error is one part in a million, 1 s in 11 days; no program can read the clock of the log itself.
"""

import argparse
import dataclasses
import re
import signal
import subprocess
import sys
import threading
import time

PERIOD = 0.1  # [s]
LONGEST_SLEEP = 2.0  # [s] a busy machine delays a sleep of 100 ms by less

# A stalled processor causes several lines, some of which the kernel writes seconds later.
SAME_STANDSTILL = 10.0  # [s]
# A line about RCU counts jiffies of unknown length; the watchdog's default is 21 s.
RCU_STALL = 21.0  # [s]

KERNEL_LINE = re.compile(r"^\[\s*(?P<time>\d+\.\d+)\] (?P<text>.*)$", re.MULTILINE)
WATCHDOG = re.compile(r"workqueue lockup|soft lockup|rcu\S*:? .*(detected stall|self-detected stall|kthread starved)"
                      r"|rcu_\S+ .*stall")
STUCK = re.compile(r"stuck for (\d+)s")


@dataclasses.dataclass
class Standstill:
    """A period in which nothing ran, by the monotonic clock."""
    begin: float  # [s]
    end: float  # [s]
    shown_by: str

    def __str__(self):
        began = time.localtime(time.time() - time.monotonic() + self.begin)
        return f"{time.strftime('%T', began)} for {self.end - self.begin:.0f} s, by {self.shown_by}"


def of_kernel(log, since, ahead=0.0):
    """The standstills reported in the text of `dmesg`, those after `since` by the monotonic clock.
    The clock of the log is `ahead` [s] of that clock."""
    found = []
    for line in KERNEL_LINE.finditer(log):
        end = float(line["time"]) - ahead
        if end <= since or not WATCHDOG.search(line["text"]):
            continue
        stuck = STUCK.search(line["text"])
        begin = end - (float(stuck[1]) if stuck else RCU_STALL)
        if found and begin - found[-1].end <= SAME_STANDSTILL:
            found[-1].begin = min(found[-1].begin, begin)
            found[-1].end = end
        else:
            found.append(Standstill(begin, end, f"the kernel: {line['text']}"))
    return found


def read_kernel_log():
    """The kernel's log, or the reason why it cannot be read."""
    try:
        done = subprocess.run(["dmesg"], check=False, capture_output=True, text=True, errors="replace")
    except OSError as error:
        return "", str(error)
    return (done.stdout, "") if done.returncode == 0 else ("", done.stderr.strip())


def uncorrected():
    return time.clock_gettime(time.CLOCK_MONOTONIC_RAW)


class Watch:
    """Observes from construction to end()."""

    def __init__(self, clock=time.monotonic, kernel_log=read_kernel_log, kernel_clock=uncorrected):
        self.clock = clock
        self.kernel_log = kernel_log
        self.kernel_ahead = kernel_clock() - clock()
        self.lock = threading.Lock()
        self.ends = threading.Event()
        self.begin = self.last = clock()
        self.gaps = []
        self.thread = threading.Thread(target=self.run, daemon=True)

    def start(self):
        self.thread.start()
        return self

    def run(self):
        while not self.ends.wait(PERIOD):
            self.note()

    def note(self):
        """Notes that the program is running."""
        with self.lock:
            present = self.clock()
            if present - self.last > LONGEST_SLEEP:
                self.gaps.append(Standstill(self.last, present, "a sleep of 100 ms"))
            self.last = present

    def end(self):
        self.ends.set()
        self.thread.join()
        self.note()

    def all(self):
        """The standstills so far, and the reason why the kernel's log cannot be read."""
        self.note()
        log, problem = self.kernel_log()
        return self.gaps + of_kernel(log, self.begin, self.kernel_ahead), problem

    def ran(self, begin, end):
        """How long [s] the machine ran between two times of the clock."""
        ran = 0.0
        counted = begin  # up to this time
        for one in sorted(self.all()[0], key=lambda each: each.begin):
            ran += max(0.0, min(one.begin, end) - counted)
            counted = max(counted, one.end)
        return ran + max(0.0, end - counted)

    def has_ended(self, process, patience):
        """Wait for a process to end, for `patience` [s] without the standstills. The kernel may report
        a standstill even later: see ran()."""
        begin = self.clock()
        left = patience
        while left > 0.0:
            try:
                process.wait(left)
                return True
            except subprocess.TimeoutExpired:
                left = patience - self.ran(begin, self.clock())
        return False

    def report(self):
        found, problem = self.all()
        found.sort(key=lambda one: one.begin)
        lines = [f"standstills of the machine: {len(found)}"]
        lines += [f"  {one}" for one in found]
        if problem:
            lines.append(f"  the kernel's log was not read: {problem}")
        return "\n".join(lines)


def watch():
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    observed = Watch().start()
    signal.sigwait({signal.SIGTERM})
    observed.end()
    print(observed.report())
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["watch"])
    parser.parse_args()
    return watch()


if __name__ == "__main__":
    sys.exit(main())
