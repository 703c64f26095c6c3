#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""run.sh and repeat.sh in a project of four small tests: which tests fail, and which run twice."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

TESTS = pathlib.Path(__file__).resolve().parents[1]

PRESETS = """{"version": 6,
 "configurePresets": [
  {"name": "quick", "generator": "Ninja", "binaryDir": "${sourceDir}/build/quick"},
  {"name": "release", "inherits": "quick", "binaryDir": "${sourceDir}/build/release"}],
 "testPresets": [
  {"name": "quick", "configurePreset": "quick", "output": {"outputOnFailure": true},
   "execution": {"noTestsAction": "error", "jobs": 4}},
  {"name": "release", "inherits": "quick", "configurePreset": "release"}]}
"""

# Each test fails at its first run and passes at the second.
PROJECT = """cmake_minimum_required(VERSION 3.25)
project(small NONE)
enable_testing()
foreach(row IN LISTS ROWS)
  string(REPLACE ":" ";" row ${row})
  list(POP_FRONT row name how)
  add_test(NAME ${name} COMMAND sh ${CMAKE_SOURCE_DIR}/test.sh ${name} ${how})
  set_tests_properties(${name} PROPERTIES LABELS "${row}")
endforeach()
"""

PROGRAM = """test "$2" = good && exit 0
test -e "$1.ran" && exit 0
touch "$1.ran"
case $2 in
  late) printf 'a.cpp:105: Failure\\nExpected: (Clock::now() - begin) < (2s), actual: 2300ms vs 2s\\n' ;;
  wrong) printf 'a.cpp:12: Failure\\nExpected equality of these values:\\n  3\\n  4\\n' ;;
  crash) kill -SEGV $$ ;;
esac
exit 1
"""

# Replaces tests/conformance/check.py: a statement lacks its test if there is a file "missing".
CONFORMANCE = """#!/bin/sh
for option in "$@"; do echo "reads ${option##*/}"; done
test ! -e missing
"""


class Scripts(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        (self.root / "tests/checks").mkdir(parents=True)
        (self.root / "deploy").mkdir()
        for name in ("run.sh", "repeat.sh", "checks/failures.py", "checks/results.py", "checks/standstill.py"):
            shutil.copy(TESTS / name, self.root / "tests" / name)
        for name in ("setup.sh", "build.sh"):
            (self.root / "deploy" / name).write_text("#!/bin/sh\n", encoding="utf-8")
            (self.root / "deploy" / name).chmod(0o755)
        (self.root / "tests/conformance").mkdir()
        (self.root / "tests/conformance/check.py").write_text(CONFORMANCE, encoding="utf-8")
        (self.root / "tests/conformance/check.py").chmod(0o755)
        for name, text in (("CMakePresets.json", PRESETS), ("CMakeLists.txt", PROJECT), ("test.sh", PROGRAM)):
            (self.root / name).write_text(text, encoding="utf-8")

    def run_script(self, rows, script, *options):
        """`rows`: NAME:HOW:LABEL[:LABEL]. Returns the exit code and all output."""
        environment = {name: value for name, value in os.environ.items() if not name.startswith("CTEST")}
        rows = "ROWS=" + ";".join(rows)
        for command in (["cmake", "--preset", "quick", "-D", rows], ["cmake", "--preset", "release", "-D", rows],
                        [f"tests/{script}", *options]):
            done = subprocess.run(command, cwd=self.root, env=environment, text=True, check=False,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        return done.returncode, done.stdout

    def test_a_late_test_is_red(self):
        self.assertEqual(self.run_script(["A.Late:late:dds:timed", "A.Good:good:unit"], "run.sh")[0], 1)

    def test_a_good_run_is_green(self):
        code, text = self.run_script(["A.Good:good:unit"], "run.sh", "--retry-deadlines")
        self.assertEqual((code, text.splitlines()[-1]), (0, "1 tests: 1 passed, 0 failed, 0 did not run"), text)

    def test_with_the_option_a_late_promise_runs_once_more_and_both_results_are_last(self):
        code, text = self.run_script(["A.Late:late:dds:timed"], "run.sh", "--retry-deadlines")
        self.assertEqual(code, 0, text)
        self.assertEqual(text.splitlines()[-4:], [
            "Failed in the first run: 1", "  A.Late",
            "    beside other tests: deadline: a.cpp:105: Expected: (Clock::now() - begin) < (2s), actual: 2300ms vs 2s",
            "    alone: passed"])

    def test_nothing_else_runs_twice(self):
        for row in ("A.Wrong:wrong:dds:timed", "A.Crash:crash:dds:timed", "A.Late:late:dds"):
            code, text = self.run_script([row], "run.sh", "--retry-deadlines")
            self.assertEqual(code, 1, text)
            self.assertIn("alone: not repeated", text)

    def test_a_crash_beside_a_late_promise_stays_red(self):
        code, text = self.run_script(["A.Late:late:dds:timed", "A.Crash:crash:dds"], "run.sh", "--retry-deadlines")
        self.assertEqual(code, 1, text)
        self.assertIn("beside other tests: signal: SEGFAULT", text)

    def test_a_full_run_reads_from_its_results_that_each_statement_is_held(self):
        code, text = self.run_script(["A.Good:good:unit"], "run.sh", "--full")
        self.assertEqual((code, text.splitlines()[-1:]), (0, ["reads first.xml"]), text)
        (self.root / "missing").touch()
        self.assertEqual(self.run_script(["A.Good:good:unit"], "run.sh", "--full")[0], 1)

    def test_a_promise_that_passed_at_its_second_run_holds_its_statement(self):
        code, text = self.run_script(["A.Late:late:dds:timed"], "run.sh", "--full", "--retry-deadlines")
        self.assertEqual((code, text.splitlines()[-2:]), (0, ["reads first.xml", "reads again.xml"]), text)

    def test_a_run_of_chosen_tests_says_nothing_of_statements(self):
        code, text = self.run_script(["A.Good:good:unit"], "run.sh", "--full", "--tests-regex", "Good")
        self.assertEqual(code, 0, text)
        self.assertNotIn("reads", text)

    def test_a_repetition_counts_failures_and_ends_its_load(self):
        code, text = self.run_script(["A.Late:late:dds", "A.Good:good:unit"], "repeat.sh", "3", "--load", "spin:1")
        self.assertEqual(code, 1, text)
        self.assertIn("3 runs of 2 tests: 1 deadline", text)
        self.assertIn("1 of 3  deadline     A.Late", text)
        self.assertIn("\nstandstills of the machine: ", text)
        self.assertNotIn(f"{self.root}/build/repeat/load", subprocess.check_output(["ps", "-eo", "args"], text=True))

    def test_a_repetition_without_a_failure_is_green(self):
        code, text = self.run_script(["A.Good:good:unit"], "repeat.sh", "2")
        self.assertEqual((code, text.splitlines()[-2:]), (0, ["load: none", "2 runs of 1 tests: no failure"]))

    def test_a_repetition_of_nothing_is_an_error(self):
        self.assertEqual(self.run_script(["A.Good:good:unit"], "repeat.sh", "2", "-R", "none")[0], 2)


if __name__ == "__main__":
    unittest.main()
