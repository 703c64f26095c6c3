#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The tests of a run, from the report that ctest writes for --output-junit. A case of ctest may be a
suite of GoogleTest (vdrive_add_test): its tests are read from its output.

  results.py count REPORT...     one line: how many tests passed, failed, did not run; if there are
                                 several reports, the last result of each test counts
  results.py names BUILD         the names of all tests of a build, one per line
"""

import argparse
import collections
import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

PASSED, FAILED, UNFINISHED, NOT_RUN = "passed", "failed", "did not end", "did not run"

Test = collections.namedtuple("Test", "name verdict output")
# `status` is ctest's own; `tests` contains those that began.
Case = collections.namedtuple("Case", "name status tests output")

BEGIN = re.compile(r"^\[ RUN      \] (\S+)$", re.MULTILINE)
END = re.compile(r"^\[ +(OK|FAILED|SKIPPED) +\] (\S+?)(?:, where .*)? \(\d+ ms\)$", re.MULTILINE)
VERDICTS = {"OK": PASSED, "FAILED": FAILED, "SKIPPED": NOT_RUN}


def parts(output):
    """The GoogleTest tests that began, each with its part of the output."""
    found = []
    begins = list(BEGIN.finditer(output))
    for begin, following in zip(begins, begins[1:] + [None]):
        text = output[begin.end() + 1:following.start() if following else len(output)]
        end = next((match for match in END.finditer(text) if match[2] == begin[1]), None)
        found.append(Test(begin[1], VERDICTS[end[1]] if end else UNFINISHED, text[:end.start()] if end else text))
    return found


def tests_of_case(name, verdict, output):
    """The tests of a suite; if there are none, the case itself."""
    suite = name.partition(".")[2] + "."
    found = [test for test in parts(output) if test.name.startswith(suite)]
    return found or [Test(name, verdict, output)]


def cases_of(report):
    """@throws OSError, ElementTree.ParseError"""
    cases = []
    for case in ElementTree.parse(report).getroot().iter("testcase"):
        name, status = case.get("name"), case.get("status")
        output = case.findtext("system-out") or ""
        verdict = (FAILED if status == "fail"
                   else PASSED if status == "run" and case.find("skipped") is None else NOT_RUN)
        cases.append(Case(name, status, tests_of_case(name, verdict, output), output))
    return cases


def names_of(build, ctest="ctest"):
    """The names of the tests of a build, in ctest's order."""
    shown = subprocess.run([ctest, "--test-dir", build, "--show-only=json-v1"], check=True,
                           capture_output=True, text=True)
    listed = {}  # program -> its list of tests
    names = {}
    for test in json.loads(shown.stdout)["tests"]:
        suite = test["name"].partition(".")[2]
        *_, program, chosen = ["", "", *test.get("command", [])]
        if not chosen.startswith(f"--gtest_filter={suite}.*"):
            names[test["name"]] = None
            continue
        if program not in listed:
            listed[program] = subprocess.run([program, "--gtest_list_tests"], check=True, capture_output=True,
                                             text=True).stdout
        block = re.search(rf"^{re.escape(suite)}\.(?:  #.*)?\n((?:  .*\n)*)", listed[program], re.MULTILINE)
        names.update((f"{suite}.{line.split()[0]}", None) for line in block[1].splitlines())
    return list(names)


def count(arguments):
    verdicts = {test.name: test.verdict
                for report in arguments.reports for case in cases_of(report) for test in case.tests}
    counts = collections.Counter(verdicts.values())
    print(f"{len(verdicts)} tests: {counts[PASSED]} passed, {counts[FAILED] + counts[UNFINISHED]} failed, "
          f"{counts[NOT_RUN]} did not run")
    return 0


def names(arguments):
    print(*names_of(arguments.build), sep="\n")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("count")
    command.add_argument("reports", nargs="+", metavar="REPORT")
    command.set_defaults(function=count)
    command = commands.add_parser("names")
    command.add_argument("build")
    command.set_defaults(function=names)
    arguments = parser.parse_args()
    try:
        return arguments.function(arguments)
    except (OSError, ElementTree.ParseError, subprocess.CalledProcessError) as error:
        parser.error(str(error))


if __name__ == "__main__":
    sys.exit(main())
