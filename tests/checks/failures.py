#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Judges how a test failed, from the output of ctest and of the test.

  failures.py late RUN LABELS             the failed tests that .ci/run may repeat, one per line
  failures.py second RUN AGAIN LABELS     both results of each failed test; exit code 0: each one
                                          failed by a deadline at first and passed alone
  failures.py table [--markdown] RUN...   which tests failed, how often and how; exit code 1: any

RUN is the path of a run without its suffix: RUN.xml is the file of ctest's --output-junit, RUN.log
that of --output-log. LABELS is the output of `ctest --show-only=json-v1`.

The kinds of failure and their signs. The first one that applies counts:

  sanitizer     a report of a sanitizer
  signal        a signal ended the test or, by its report, a program that it ran
  exception     an exception left the test: C++, Python, JavaScript
  time limit    ctest ended the test, which may have waited forever
  not run       the test did not begin
  wrong value   any failed expectation that is not one of the next kind
  deadline      every failed expectation reports that a wait timed out or something took too long

A test may be repeated if it failed by a deadline, threw nothing, and has the label `timed`, that
is, makes a promise about wall-clock time, which a machine without a free processor cannot keep.
"""

import argparse
import collections
import dataclasses
import json
import pathlib
import re
import sys

import results

SANITIZER, SIGNAL, EXCEPTION = "sanitizer", "signal", "exception"
TIME_LIMIT, NOT_RUN, WRONG_VALUE, DEADLINE = "time limit", "not run", "wrong value", "deadline"
TIMED = "timed"  # the label, see VDRIVE_TIMED_TEST
LONGEST_TEXT = 200

# Written by waits (tests/support/deadline.hpp, hosts.py, page_test.mjs) when their time is over.
MARK = "[deadline]"

SANITIZER_REPORT = re.compile(
    r"(Address|Thread|Leak|Memory|UndefinedBehavior)Sanitizer|: runtime error: ")

# The reports of programs run by a test about a signal that ended another program.
CRASH = re.compile(
    r"Segmentation fault|core dumped|terminate called|double free|stack smashing"
    r"|malloc\(\)|free\(\): |Assertion [`'].*failed|\[signal\]"
    r"|Fatal Python error"
    r"|ended with -(4|6|7|8|11)\b|ended by signal (4|6|7|8|11)\b|(exit|return) ?code[ :=]+(-(4|6|7|8|11)|13[2456]|139)\b"
    r"|died with <Signals\.SIG(ILL|ABRT|BUS|FPE|SEGV)")
# EXPECT_EQ(finished.code, 0) for a program that was ended by a signal.
CRASH_CODE = re.compile(r"code\b[^\n]*\n\s*Which is: (-(4|6|7|8|11)|13[2456]|139)\n")

# ctest's own word for the outcome of a test, in its list of failed tests.
SIGNALS = ("SEGFAULT", "ILLEGAL", "NUMERICAL", "INTERRUPT", "OTHER_FAULT", "Bus error")
LISTED = re.compile(r"^\s+\d+ - (\S+) \((.+)\)\s*$", re.MULTILINE)

GTEST_BLOCK = re.compile(r"^(?P<place>\S+:\d+|unknown file): Failure\n(?P<body>.*?)"
                         r"(?=^\S+:\d+: Failure$|^unknown file: Failure$|^\[[ =A-Z-]{10}\]|\Z)",
                         re.MULTILINE | re.DOTALL)
# Durations are printed with their unit, time points as bytes.
TOO_LONG = re.compile(r"Expected: \(.*\) <=? \(.*\), actual: (8-byte object|\d+(ns|us|µs|ms|s|min|h) vs )")
CLOCK = re.compile(r"Expected: \(.*(steady_clock|\bClock)::now\(\).*\) <=? \(")
FUTURE = re.compile(r"\.wait_for\(.*\n(?:.*\n)*?\s*(std::)?future_status::ready")
TIMED_OUT = re.compile(r"timed out while waiting|did not answer")  # Outcome::timed_out
THROWN = re.compile(r"^C\+\+ exception|^Unknown C\+\+ exception")

PYTEST_LINE = re.compile(r"^(?:FAILED|ERROR) \S+(?: - (?P<error>.*))?$", re.MULTILINE)
TRACEBACK = re.compile(r"^Traceback \(most recent call last\):\n(?:[ \t].*\n|\n)*(?P<error>\S.*)$",
                       re.MULTILINE)
PYTHON_LATE = re.compile(r"(\w+\.)*(TimedOut|TimeoutExpired|TimeoutError|Late)\b")
PYTHON_VALUE = re.compile(r"(AssertionError\b|assert\b|Failed: DID NOT)")
NODE_ERROR = re.compile(r"^\s*(?P<error>(?:\w*Error|AssertionError)(?: \[\w+\])?: .*)$", re.MULTILINE)


@dataclasses.dataclass
class Failure:
    """How a test failed, and the first text that shows it."""
    kind: str
    text: str
    thrown: bool = False  # by C++

    def __str__(self):
        return f"{self.kind}: {self.text}" if self.text else self.kind


def shorten(text):
    text = " ".join(text.split())
    return text if len(text) <= LONGEST_TEXT else text[:LONGEST_TEXT - 3] + "..."


def line_with(pattern, output):
    """The complete line of the first match."""
    match = pattern.search(output)
    begin = output.rfind("\n", 0, match.start()) + 1
    end = output.find("\n", match.end())
    return shorten(output[begin:end if end >= 0 else len(output)])


def is_late(block, before):
    """Whether an expectation of GoogleTest failed by a deadline. A failing wait writes its mark
    before the expectation that notices it."""
    return any(pattern.search(block) for pattern in (TOO_LONG, CLOCK, FUTURE, TIMED_OUT)) or \
        MARK in block or MARK in before


def judge_gtest(output):
    failures = []
    end = 0
    for block in GTEST_BLOCK.finditer(output):
        text = shorten(f"{pathlib.PurePath(block['place']).name}: {block['body']}")
        thrown = THROWN.match(block["body"]) is not None
        if thrown:
            kind = DEADLINE if MARK in block["body"] else EXCEPTION
        else:
            kind = DEADLINE if is_late(block["body"], output[end:block.start()]) else WRONG_VALUE
        failures.append(Failure(kind, text, thrown))
        end = block.end()
    return failures


def judge_python_error(error):
    if MARK in error or PYTHON_LATE.match(error):
        return DEADLINE
    return WRONG_VALUE if PYTHON_VALUE.match(error) else EXCEPTION


def judge_errors(output):
    """The errors of pytest; if there are none, those of the Python program; otherwise those of
    node."""
    for pattern in (PYTEST_LINE, TRACEBACK):
        found = [match["error"] or "" for match in pattern.finditer(output)]
        if found:
            return [Failure(judge_python_error(error), shorten(error)) for error in found]
    found = [match["error"] for match in NODE_ERROR.finditer(output)]
    return [Failure(DEADLINE if MARK in error else WRONG_VALUE if "Assertion" in error else EXCEPTION,
                    shorten(error)) for error in found]


def judge(status, output):
    """Judges from its output how a test with this ctest status failed."""
    if SANITIZER_REPORT.search(output):
        return Failure(SANITIZER, line_with(SANITIZER_REPORT, output))
    if status in SIGNALS or status.startswith(("Subprocess", "Exception")):
        return Failure(SIGNAL, status)
    for pattern in (CRASH, CRASH_CODE):
        if pattern.search(output):
            return Failure(SIGNAL, line_with(pattern, output))
    failures = judge_gtest(output) or judge_errors(output)
    for failure in failures:
        if failure.kind == EXCEPTION:
            return failure
    if status == "Timeout":
        return Failure(TIME_LIMIT, failures[0].text if failures else "ctest ended it")
    if status == "Not Run":
        return Failure(NOT_RUN, shorten(output))
    for failure in failures:
        if failure.kind == WRONG_VALUE:
            return failure
    if failures:
        return dataclasses.replace(failures[0], thrown=any(failure.thrown for failure in failures))
    lines = output.strip().splitlines()
    return Failure(WRONG_VALUE, shorten(lines[-1]) if lines else status)


def failures_of_case(case, status):
    """The failures of the tests of a case by test name; by the name of the case if all of them
    passed."""
    if len(case.tests) < 2:
        return {case.tests[0].name: judge(status, case.output)}
    failed = {test.name: judge(status if test.verdict == results.UNFINISHED else "Failed", test.output)
              for test in case.tests if test.verdict in (results.FAILED, results.UNFINISHED)}
    return failed or {case.name: judge(status, case.output)}


def failures_of(run):
    """The failed tests of a run by name, and the number of tests run."""
    cases = {case.name: case for case in results.cases_of(f"{run}.xml")}
    log = pathlib.Path(f"{run}.log").read_text(encoding="utf-8", errors="replace")
    statuses = dict(LISTED.findall(log[log.rfind("The following tests FAILED:"):])) \
        if "The following tests FAILED:" in log else {}
    # A status that is not listed must not be lost.
    for case in cases.values():
        if case.status == "fail":
            statuses.setdefault(case.name, "Failed")
    failures = {}
    for name, status in statuses.items():
        failures.update(failures_of_case(cases[name], status) if name in cases else {name: judge(status, "")})
    return failures, sum(len(case.tests) for case in cases.values())


def timed_tests(labels):
    tests = json.loads(pathlib.Path(labels).read_text(encoding="utf-8"))["tests"]
    return {test["name"] for test in tests for row in test.get("properties", [])
            if row["name"] == "LABELS" and TIMED in row["value"]}


def late_tests(run, labels):
    timed = timed_tests(labels)
    failures, _ = failures_of(run)
    return [name for name, failure in failures.items()
            if failure.kind == DEADLINE and not failure.thrown and name in timed]


def late(arguments):
    print(*late_tests(arguments.run, arguments.labels), sep="\n")
    return 0


def second(arguments):
    """Both results of each test that failed the first time."""
    first, _ = failures_of(arguments.run)
    repeated = late_tests(arguments.run, arguments.labels)
    again = failures_of(arguments.again)[0] if repeated else {}
    print(f"Failed in the first run: {len(first)}")
    for name, failure in first.items():
        result = "not repeated" if name not in repeated else str(again.get(name, "passed"))
        print(f"  {name}\n    beside other tests: {failure}\n    alone: {result}")
    return 0 if set(first) == set(repeated) and not again else 1


def rows_of(runs):
    """(test, kind, count, first text), the most frequent first; and the number of tests of each
    run."""
    seen = collections.Counter()
    texts = {}
    counts = []
    for run in runs:
        failures, count = failures_of(run)
        counts.append(count)
        for name, failure in failures.items():
            seen[name, failure.kind] += 1
            texts.setdefault((name, failure.kind), failure.text)
    rows = [(name, kind, times, texts[name, kind]) for (name, kind), times in seen.items()]
    return sorted(rows, key=lambda row: (-row[2], row[:2])), counts


def table(arguments):
    rows, counts = rows_of(arguments.runs)
    tests = " or ".join(str(count) for count in sorted(set(counts)))
    kinds = collections.Counter()
    for _, kind, times, _ in rows:
        kinds[kind] += times
    runs = "1 run" if len(counts) == 1 else f"{len(counts)} runs"
    print(f"{runs} of {tests} tests: " +
          (", ".join(f"{times} {kind}" for kind, times in sorted(kinds.items())) or "no failure"))
    if rows and arguments.markdown:
        print("\n| test | failed | kind | first text |\n| --- | --- | --- | --- |")
    for name, kind, times, text in rows:
        row = (name, f"{times} of {len(counts)}", kind, text)
        print("| " + " | ".join(part.replace("|", "\\|") for part in row) + " |"
              if arguments.markdown else f"  {row[1]}  {kind:11}  {name}\n      {text}")
    return 1 if rows else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    for function, names in ((late, ("run", "labels")), (second, ("run", "again", "labels"))):
        command = commands.add_parser(function.__name__)
        for name in names:
            command.add_argument(name)
        command.set_defaults(function=function)
    command = commands.add_parser("table")
    command.add_argument("--markdown", action="store_true")
    command.add_argument("runs", nargs="+")
    command.set_defaults(function=table)
    arguments = parser.parse_args()
    return arguments.function(arguments)


if __name__ == "__main__":
    sys.exit(main())
