#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A machine that stood still is distinguished from one that did not, by its kernel and by a clock
gap."""
import signal
import subprocess
import sys
import unittest
import unittest.mock

import standstill

LOG = """[    1.349077] EXT4-fs (vda): mounted filesystem r/w without journal.
[  100.000000] watchdog: BUG: soft lockup - CPU#1 stuck for 22s! [swapper/1:0]
[ 2000.250000] BUG: workqueue lockup - pool cpus=0 node=0 flags=0x0 nice=0 stuck for 35s!
[ 2000.300000] Showing busy workqueues and worker pools:
[ 2004.000000] watchdog: BUG: soft lockup - CPU#0 stuck for 38s! [cc1plus:812]
[ 3000.000000] rcu: INFO: rcu_preempt detected stalls on CPUs/tasks:
[ 3000.000100] rcu: 	0-...!: (0 ticks this GP) idle=0b4/0/0x0 softirq=1/1 fqs=0
[ 4000.000000] rcu: INFO: rcu_sched self-detected stall on CPU
[ 5000.000000] rcu: rcu_preempt kthread starved for 9003 jiffies! g7 f0x0 RCU_GP_WAIT_FQS(5)
[ 6000.000000] rcu: Hierarchical SRCU implementation.
"""


class FakeClock:
    def __init__(self):
        self.time = 1000.0

    def __call__(self):
        return self.time


class Standstills(unittest.TestCase):
    def setUp(self):
        self.clock = FakeClock()
        self.log = ("", "")
        self.kernel_ahead = 0.0
        self.watch = self.new_watch()

    def new_watch(self):
        return standstill.Watch(self.clock, lambda: self.log, lambda: self.clock() + self.kernel_ahead)

    def pass_time(self, seconds):
        self.clock.time += seconds
        self.watch.note()

    def test_the_kernel_tells_of_lockups_and_stalls_during_the_run(self):
        found = standstill.of_kernel(LOG, since=1000.0)
        self.assertEqual([(one.begin, one.end) for one in found],
                         [(2000.25 - 35, 2004.0), (3000 - 21, 3000.0), (4000 - 21, 4000.0), (5000 - 21, 5000.0)])

    def test_what_was_logged_before_the_run_does_not_count(self):
        self.assertEqual(standstill.of_kernel(LOG, since=5000.0), [])

    def test_a_gap_of_the_clock_is_a_standstill(self):
        self.pass_time(0.1)
        self.pass_time(standstill.LONGEST_SLEEP)
        self.pass_time(31.0)
        self.pass_time(0.1)
        self.assertEqual([(one.begin, one.end) for one in self.watch.all()[0]], [(1002.1, 1033.1)])

    def test_a_standstill_is_no_part_of_the_time_that_the_machine_ran(self):
        self.pass_time(31.0)
        self.pass_time(1.0)
        self.assertEqual(self.watch.ran(1030.0, 1050.0), 19.0)
        self.assertEqual(self.watch.ran(1031.5, 1050.0), 18.5)
        self.assertEqual(self.watch.ran(990.0, 1050.0), 29.0)
        self.assertEqual(self.watch.ran(1005.0, 1006.0), 0.0)

    def test_a_standstill_that_both_measures_saw_counts_once(self):
        self.pass_time(30.0)
        self.log = ("[ 1025.0] BUG: soft lockup - CPU#0 stuck for 15s!\n"
                    "[ 1047.0] BUG: soft lockup - CPU#1 stuck for 10s!", "")
        self.assertEqual(self.watch.ran(1000.0, 1050.0), 10.0)

    def test_a_standstill_that_no_note_has_seen_yet_counts(self):
        self.clock.time += 31.0
        self.assertEqual(self.watch.ran(1005.0, 1031.0), 0.0)

    def test_the_stamps_of_the_kernel_are_times_of_the_monotonic_clock(self):
        self.kernel_ahead = 50.0
        self.watch = self.new_watch()
        self.log = ("[ 1100.0] BUG: soft lockup - CPU#0 stuck for 22s!", "")
        self.assertEqual([(one.begin, one.end) for one in self.watch.all()[0]], [(1028.0, 1050.0)])
        self.log = ("[ 1040.0] BUG: soft lockup - CPU#0 stuck for 22s!", "")  # before the watch
        self.assertEqual(self.watch.all()[0], [])

    def test_a_gap_of_two_seconds_excuses_no_program_that_hangs(self):
        waits = []

        def hang(timeout):
            waits.append(timeout)
            end = self.clock() + timeout
            if len(waits) == 1:
                self.pass_time(standstill.LONGEST_SLEEP + 0.5)
            while self.clock() < end:
                self.pass_time(0.5)
            raise subprocess.TimeoutExpired("hanging", timeout)

        hanging = unittest.mock.Mock(wait=hang)
        told = self.clock()
        self.assertFalse(self.watch.has_ended(hanging, 20.0))
        self.assertEqual(waits, [20.0, 2.5])
        self.assertEqual(self.watch.ran(told, self.clock()), 20.0)
        self.assertTrue(self.watch.has_ended(unittest.mock.Mock(), 20.0))

    def test_the_report_says_how_often_how_long_and_what_was_not_read(self):
        self.assertEqual(self.watch.report(), "standstills of the machine: 0")
        self.pass_time(31.0)
        self.log = ("", "dmesg: read kernel buffer failed: Operation not permitted")
        lines = self.watch.report().splitlines()
        self.assertEqual(lines[0], "standstills of the machine: 1")
        self.assertRegex(lines[1], r"^  \d\d:\d\d:\d\d for 31 s, by a sleep of 100 ms$")
        self.assertIn("was not read: dmesg: read kernel buffer failed", lines[2])

    def test_the_program_reports_when_it_is_told_to_end(self):
        # The program inherits the mask, so a signal that arrives before it waits is not lost.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
        with subprocess.Popen([sys.executable, "-B", standstill.__file__, "watch"],
                              stdout=subprocess.PIPE, text=True) as program:
            program.send_signal(signal.SIGTERM)
            self.assertRegex(program.communicate(timeout=60)[0], "^standstills of the machine: ")


if __name__ == "__main__":
    unittest.main()
