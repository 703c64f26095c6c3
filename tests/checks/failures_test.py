#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Each kind of failure is distinguished from the others, and only a missed deadline is repeated."""
import contextlib
import io
import json
import pathlib
import tempfile
import types
import unittest
from xml.sax.saxutils import escape

import failures

LATE = """tests/a.cpp:105: Failure
Expected: (Clock::now() - begin) < (2s), actual: 8-byte object <AA-5E D0-B2 00-00 00-00> vs 8-byte object <02-00 00-00 00-00 00-00>
"""
LATE_VALUE = """tests/a.cpp:9: Failure
Expected: (start()) < (kFirstStatus), actual: 8-byte object <AA-5E D0-B2 00-00 00-00> vs 8-byte object <E8-03 00-00 00-00 00-00>
"""
LATE_PRINTED = """tests/a.cpp:240: Failure
Expected: (start()) < (kFirstStatus), actual: 40001ms vs 2s
"""
WAITED = """[deadline] no reply in 40 s
tests/a.cpp:11: Failure
Value of: reply
  Actual: false
Expected: true
"""
WRONG = """tests/a.cpp:12: Failure
Expected equality of these values:
  tick
    Which is: 3
  4
"""
TICKS = """tests/a.cpp:128: Failure
Expected: (now().tick) < (start + 200), actual: 512 vs 400
"""
EARLY = """tests/a.cpp:13: Failure
Expected: (Clock::now() - begin) >= (300ms), actual: 8-byte object <00-00> vs 8-byte object <01-00>
"""
THROWN = """unknown file: Failure
C++ exception with description "the service did not start" thrown in the test body.
"""
THROWN_LATE = """unknown file: Failure
C++ exception with description "[deadline] there was no topic /bench1/status in 10 s" thrown in the test body.
"""
CHILD = """tests/a.cpp:20: Failure
Expected equality of these values:
  service.wait().code
    Which is: -11
  0
"""
PYTEST = """F
=========================== short test summary info ============================
FAILED test_axis.py::test_moves - {}
1 failed, 3 passed in 2.50s
"""
TRACEBACK = """Traceback (most recent call last):
  File "network_test.py", line 700, in main
    globals()[programs.case](case)
  File "hosts.py", line 35, in wait_for
    raise Late(what)
{}
"""


def gtest(*blocks):
    return "[ RUN      ] A.Test\n" + "".join(blocks) + "[  FAILED  ] A.Test (0 ms)\n[==========] 1 test\n"


def kind(output, status="Failed"):
    return failures.judge(status, output).kind


class Kinds(unittest.TestCase):
    def test_a_duration_above_its_limit_is_a_deadline(self):
        self.assertEqual(kind(gtest(LATE)), "deadline")
        self.assertEqual(kind(gtest(LATE_VALUE)), "deadline")
        self.assertEqual(kind(gtest(LATE_PRINTED)), "deadline")

    def test_a_wait_that_wrote_its_mark_is_a_deadline(self):
        self.assertEqual(kind(gtest(WAITED)), "deadline")
        self.assertEqual(kind(gtest(WAITED.replace("[deadline] no reply in 40 s\n", ""))), "wrong value")

    def test_an_outcome_that_timed_out_is_a_deadline(self):
        block = "a.cpp:1: Failure\nValue of: moved\n  Actual: false\nExpected: true\naxis 1.1: timed out while waiting for 'x'\n"
        self.assertEqual(kind(gtest(block)), "deadline")

    def test_a_future_that_is_not_ready_in_time_is_a_deadline(self):
        block = ("a.cpp:1: Failure\nExpected equality of these values:\n  ended.wait_for(kLong)\n"
                 "    Which is: 4-byte object <01-00 00-00>\n  std::future_status::ready\n"
                 "    Which is: 4-byte object <00-00 00-00>\n")
        self.assertEqual(kind(gtest(block)), "deadline")

    def test_another_expectation_is_a_wrong_value(self):
        for block in (WRONG, TICKS, EARLY):
            self.assertEqual(kind(gtest(block)), "wrong value", block)

    def test_a_wrong_value_beside_a_deadline_is_a_wrong_value(self):
        for blocks in ((LATE, WRONG), (WRONG, LATE), (WAITED, WRONG)):
            self.assertEqual(kind(gtest(*blocks)), "wrong value")
        self.assertEqual(failures.judge("Failed", gtest(LATE, WRONG)).text.split(":")[0], "a.cpp")

    def test_an_exception_is_an_exception_also_beside_a_deadline(self):
        self.assertEqual(kind(gtest(THROWN)), "exception")
        self.assertEqual(kind(gtest(LATE, THROWN)), "exception")

    def test_an_exception_of_a_wait_is_a_deadline_and_not_repeated(self):
        failure = failures.judge("Failed", gtest(THROWN_LATE))
        self.assertEqual((failure.kind, failure.thrown), ("deadline", True))
        self.assertTrue(failures.judge("Failed", gtest(LATE, THROWN_LATE)).thrown)

    def test_a_signal_is_a_signal_whatever_was_written(self):
        for status in ("SEGFAULT", "Subprocess aborted", "Subprocess killed", "Bus error", "NUMERICAL",
                       "ILLEGAL", "OTHER_FAULT"):
            self.assertEqual(kind(gtest(LATE), status), "signal", status)

    def test_a_program_of_the_test_that_a_signal_ended_is_a_signal(self):
        self.assertEqual(kind(gtest(CHILD)), "signal")
        self.assertEqual(kind(gtest(CHILD.replace("-11", "1"))), "wrong value")
        self.assertEqual(kind(gtest("[signal] vdrived was ended by signal 11\n", WAITED)), "signal")
        self.assertEqual(kind("service2 ended with -6\n" + TRACEBACK.format("hosts.Late: after 5 s")), "signal")

    def test_a_report_of_a_sanitizer_is_a_sanitizer(self):
        for line in ("==12==ERROR: AddressSanitizer: heap-use-after-free on address 0x6\n",
                     "WARNING: ThreadSanitizer: data race (pid=1)\n",
                     "a.cpp:3:5: runtime error: signed integer overflow\n"):
            self.assertEqual(kind(gtest(LATE) + line, "Subprocess aborted"), "sanitizer", line)

    def test_a_test_that_ctest_ended_may_have_waited_for_ever(self):
        self.assertEqual(kind("[ RUN      ] A.Test\n", "Timeout"), "time limit")
        self.assertEqual(kind(gtest(LATE), "Timeout"), "time limit")

    def test_a_test_that_did_not_begin_is_not_run(self):
        self.assertEqual(kind("Unable to find executable: none", "Not Run"), "not run")

    def test_pytest(self):
        for error, expected in (("AssertionError: assert 3 == 4", "wrong value"),
                                ("assert 3 == 4", "wrong value"),
                                ("vdrive.TimedOut: axis 1.1: timed out while waiting", "deadline"),
                                ("subprocess.TimeoutExpired: Command", "deadline"),
                                ("Failed: DID NOT RAISE <class 'X'>", "wrong value"),
                                ("KeyError: 'x'", "exception")):
            self.assertEqual(kind(PYTEST.format(error)), expected, error)

    def test_pytest_with_a_deadline_and_another_failure(self):
        both = PYTEST.format("vdrive.TimedOut: x\nFAILED test_axis.py::test_b - KeyError: 1")
        self.assertEqual(kind(both), "exception")

    def test_a_traceback(self):
        for error, expected in (("hosts.Late: after 5 s still no move [deadline]", "deadline"),
                                ("AssertionError: a stale command ran", "wrong value"),
                                ("json.decoder.JSONDecodeError: Expecting value", "exception")):
            self.assertEqual(kind(TRACEBACK.format(error)), expected, error)

    def test_node(self):
        for error, expected in (("  AssertionError [ERR_ASSERTION]: 3 !== 4", "wrong value"),
                                ("  AssertionError [ERR_ASSERTION]: [deadline] \"x\" does not match", "deadline"),
                                ("  TypeError: x is undefined", "exception")):
            self.assertEqual(kind(error + "\n"), expected, error)

    def test_what_nobody_knows_is_a_wrong_value(self):
        self.assertEqual(kind("something\nlast line\n"), "wrong value")
        self.assertEqual(failures.judge("Failed", "first\nlast line\n").text, "last line")


class Runs(unittest.TestCase):
    """Files in the format of ctest."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.labels = self.folder / "labels.json"
        self.labels.write_text(json.dumps({"tests": [
            {"name": name, "properties": [{"name": "LABELS", "value": labels}]}
            for name, labels in (("A.Timed", ["dds", "timed"]), ("A.Other", ["dds"]))] +
            [{"name": "A.WithoutLabel"}]}), encoding="utf-8")

    def run_of(self, name, tests):
        """`tests`: name, ctest status or None if passed, output."""
        cases = "".join(f'<testcase name="{test}" status="{"fail" if status else "run"}">'
                        f"<system-out>{escape(output)}</system-out></testcase>"
                        for test, status, output in tests)
        (self.folder / f"{name}.xml").write_text(f"<testsuite>{cases}</testsuite>", encoding="utf-8")
        listed = "".join(f"\t 12 - {test} ({status})\n" for test, status, _ in tests if status)
        (self.folder / f"{name}.log").write_text(
            "The following tests did not run:\n\t 3 - A.Skipped (Skipped)\n\n"
            f"The following tests FAILED:\n{listed}" if listed else "100% passed\n", encoding="utf-8")
        return str(self.folder / name)

    def call(self, function, **arguments):
        text = io.StringIO()
        with contextlib.redirect_stdout(text):
            code = function(types.SimpleNamespace(labels=self.labels, **arguments))
        return code, text.getvalue()

    def second(self, first, again):
        return self.call(failures.second, run=self.run_of("first", first), again=self.run_of("again", again))

    def test_only_a_timed_test_that_was_late_is_repeated(self):
        run = self.run_of("first", [("A.Timed", "Failed", gtest(LATE)), ("A.Other", "Failed", gtest(LATE)),
                                    ("A.WithoutLabel", "Failed", gtest(LATE)), ("A.Good", None, "")])
        self.assertEqual(self.call(failures.late, run=run)[1], "A.Timed\n")
        for status, output in (("SEGFAULT", gtest(LATE)), ("Failed", gtest(WRONG)), ("Failed", gtest(THROWN)),
                               ("Failed", gtest(THROWN_LATE)), ("Timeout", gtest(LATE)),
                               ("Failed", gtest(LATE, WRONG))):
            run = self.run_of("first", [("A.Timed", status, output)])
            self.assertEqual(self.call(failures.late, run=run)[1].split(), [], output)

    def test_a_late_test_that_passes_alone_is_good_and_both_results_are_shown(self):
        code, text = self.second([("A.Timed", "Failed", gtest(LATE))], [("A.Timed", None, "")])
        self.assertEqual(code, 0)
        self.assertIn("beside other tests: deadline: a.cpp:105: Expected: (Clock::now() - begin) < (2s)", text)
        self.assertIn("alone: passed", text)

    def test_a_late_test_that_fails_again_is_red(self):
        code, text = self.second([("A.Timed", "Failed", gtest(LATE))], [("A.Timed", "SEGFAULT", "")])
        self.assertEqual(code, 1)
        self.assertIn("alone: signal: SEGFAULT", text)

    def test_another_failure_stays_red(self):
        code, text = self.second([("A.Timed", "Failed", gtest(LATE)), ("A.Other", "Failed", gtest(LATE))],
                                 [("A.Timed", None, "")])
        self.assertEqual(code, 1)
        self.assertIn("alone: not repeated", text)

    def test_the_table_counts_each_test_and_kind(self):
        runs = [self.run_of("1", [("A.Timed", "Failed", gtest(LATE)), ("A.Other", None, "")]),
                self.run_of("2", [("A.Timed", "Failed", gtest(WRONG)), ("A.Other", None, "")]),
                self.run_of("3", [("A.Timed", "Failed", gtest(LATE)), ("A.Other", "SEGFAULT", "")])]
        rows, counts = failures.rows_of(runs)
        self.assertEqual([row[:3] for row in rows], [("A.Timed", "deadline", 2), ("A.Other", "signal", 1),
                                                     ("A.Timed", "wrong value", 1)])
        self.assertEqual(counts, [2, 2, 2])
        code, text = self.call(failures.table, runs=runs, markdown=False)
        self.assertEqual(code, 1)
        self.assertIn("3 runs of 2 tests: 2 deadline, 1 signal, 1 wrong value", text)
        code, text = self.call(failures.table, runs=runs, markdown=True)
        self.assertIn("| A.Timed | 2 of 3 | deadline | a.cpp:105: Expected", text)

    def test_runs_without_a_failure_are_good(self):
        code, text = self.call(failures.table, runs=[self.run_of("1", [("A.Other", None, "")])], markdown=True)
        self.assertEqual((code, text), (0, "1 run of 1 tests: no failure\n"))

    def test_the_failed_tests_of_a_suite_are_named(self):
        passed = "[ RUN      ] A.Good\n[       OK ] A.Good (0 ms)\n"
        failed = f"[ RUN      ] A.Bad/3\n{WRONG}[  FAILED  ] A.Bad/3, where GetParam() = 4 (1 ms)\n"
        ended = "[ RUN      ] A.Ends\n"
        run = self.run_of("1", [("a_test.A", "Failed", passed + failed)])
        found, count = failures.failures_of(run)
        self.assertEqual([(name, failure.kind) for name, failure in found.items()], [("A.Bad/3", "wrong value")])
        self.assertEqual(count, 2)
        found, count = failures.failures_of(self.run_of("1", [("a_test.A", "SEGFAULT", passed + failed + ended)]))
        self.assertEqual([(name, failure.kind) for name, failure in found.items()],
                         [("A.Bad/3", "wrong value"), ("A.Ends", "signal")])
        found, count = failures.failures_of(self.run_of("1", [("a_test.A", "SEGFAULT", passed + passed)]))
        self.assertEqual([(name, failure.kind) for name, failure in found.items()], [("a_test.A", "signal")])

    def test_a_failure_that_no_list_names_is_kept(self):
        run = self.run_of("1", [("A.Other", "Failed", gtest(WRONG))])
        (self.folder / "1.log").write_text("cut off", encoding="utf-8")
        self.assertEqual(failures.failures_of(run)[0]["A.Other"].kind, "wrong value")


if __name__ == "__main__":
    unittest.main()
