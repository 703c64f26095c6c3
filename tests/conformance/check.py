#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks docs/reference/conformance.md: every statement is shown by tests that exist, run and pass.

    tests/conformance/check.py --build DIRECTORY [--ctest PROGRAM] [--page FILE] [--list]

    --build DIRECTORY  a build with tests; their programs are built and run there
    --list             only what the page itself shows: runs nothing

Each table of the page that begins with a column "id" ends with a column "held by": GoogleTest names
as ctest prints them, in backticks, separated by <br>. Identifiers: O-607D:01 an object of the
manual's table, M-12 a statement of the manual, A-12 an ambiguity, R-12 a rule of interoperability.
The named tests are run again here, and each must have run and passed: a test that was skipped or
filtered away holds nothing. Exit code 0: all is well; otherwise each line of the output is one thing
that is wrong.
"""
import argparse
import collections
import concurrent.futures
import csv
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
OBJECTS = ROOT / "tests" / "data" / "object-dictionary.csv"
AMBIGUITIES = 48
RULES = 12
IDENTIFIER = re.compile(r"O-[0-9A-F]{4}(:[0-9A-F]{2})?|[MAR]-[1-9][0-9]*")
PROGRAMS_AT_ONCE = 2
TESTS_A_RUN = 4  # short runs share two processors better than one long run of the scenarios

Row = collections.namedtuple("Row", "line identifier cells tests")


def cells_of(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def parse(text):
    """The rows of the page's tables, and the errors of their form."""
    rows, findings, header = [], [], None
    for number, line in enumerate(text.splitlines(), 1):
        if not line.startswith("|"):
            header = None
            continue
        cells = cells_of(line)
        if header is None:
            header = cells
            continue
        if header[0] != "id" or set("".join(cells)) <= set("-: "):
            continue
        place = f"line {number}, {cells[0]}"
        if header[-1] != "held by" or len(cells) != len(header):
            findings.append(f"{place}: {len(cells)} cells under the header {' | '.join(header)}")
            continue
        if not IDENTIFIER.fullmatch(cells[0]):
            findings.append(f"{place}: this is no identifier")
        tests = re.findall(r"`([^`]*)`", cells[-1])
        rest = re.sub(r"`[^`]*`|<br>", "", cells[-1]).strip()
        if rest:
            findings.append(f"{place}: 'held by' has more than names in backticks: {rest}")
        rows.append(Row(number, cells[0], dict(zip(header, cells)), tests))
    return rows, findings


def expected_objects():
    """Identifier -> the row of the page about the object, from the manual's table."""
    with open(OBJECTS, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    several = {row["index"] for row in rows if row["subindex"] != "0x00"}
    objects = {}
    for row in rows:
        name = "O-" + row["index"][2:]
        if row["index"] in several:
            name += ":" + row["subindex"][2:]
        objects[name] = {
            "variable": row["variable_name"],
            "type": row["data_type"],
            "access": row["access"],
            "stored": row["store_in_flash"],
            "range": f"{row['lower_limit']} to {row['upper_limit']}",
            "default": row["default_value"],
        }
    return objects


def check_objects(rows):
    objects = expected_objects()
    findings = [f"object {name} of the manual's table has no row"
                for name in objects if name not in {row.identifier for row in rows}]
    for row in rows:
        if not row.identifier.startswith("O-"):
            continue
        if row.identifier not in objects:
            findings.append(f"line {row.line}, {row.identifier}: not in the manual's table")
            continue
        for column, value in objects[row.identifier].items():
            if row.cells.get(column) != value:
                findings.append(f"line {row.line}, {row.identifier}: {column} is "
                                f"{row.cells.get(column)}, in the manual's table {value}")
    return findings


def check_page(text):
    """@return the rows, and the errors of the page alone."""
    rows, findings = parse(text)
    lines = collections.defaultdict(list)
    for row in rows:
        lines[row.identifier].append(row.line)
        if not row.tests:
            findings.append(f"line {row.line}, {row.identifier}: no test holds it")
    for identifier, where in lines.items():
        if len(where) > 1:
            findings.append(f"{identifier} is used in lines {', '.join(map(str, where))}")
    for letter, count, kind in (("A", AMBIGUITIES, "ambiguity"), ("R", RULES, "rule")):
        wanted = {f"{letter}-{i}" for i in range(1, count + 1)}
        present = {name for name in lines if name.startswith(letter + "-")}
        findings += [f"{kind} {name} has no row" for name in sorted(wanted - present)]
        findings += [f"{kind} {name} is beyond the last" for name in sorted(present - wanted)]
    if not any(name.startswith("M-") for name in lines):
        findings.append("there is no statement of the manual")
    return rows, findings + check_objects(rows)


def known_tests(ctest, build):
    """Name -> (program with what stands before it, working directory), of every GoogleTest."""
    shown = subprocess.run([ctest, "--test-dir", build, "--show-only=json-v1"], check=True,
                           capture_output=True, text=True)
    tests = {}
    for test in json.loads(shown.stdout)["tests"]:
        command = test.get("command", [])
        program = [word for word in command if not word.startswith("--gtest_")]
        if len(program) == len(command):
            continue
        properties = {p["name"]: p["value"] for p in test.get("properties", [])}
        tests[test["name"]] = (tuple(program), properties.get("WORKING_DIRECTORY", build))
    return tests


def verdicts(report):
    """Name -> None when it ran and passed, else why not; from GoogleTest's JSON report."""
    result = {}
    for suite in report.get("testsuites", []):
        for test in suite.get("testsuite", []):
            name = f"{test.get('classname', suite['name'])}.{test['name']}"
            if test.get("status") != "RUN" or test.get("result") != "COMPLETED":
                result[name] = f"did not run: {test.get('result', test.get('status'))}".lower()
            elif test.get("failures"):
                result[name] = "failed: " + " ".join(test["failures"][0]["failure"].split())
            else:
                result[name] = None
    return result


def run_program(program, directory, names):
    """Runs the named tests of one program. @return name -> None or what is wrong."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("GTEST_", "VDRIVE_"))}
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "report.json"
        done = subprocess.run(
            [*program, "--gtest_brief=1", f"--gtest_output=json:{report}",
             "--gtest_filter=" + ":".join(names)],
            cwd=directory, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, errors="replace", check=False)
        if not report.exists():
            last = (done.stdout.strip().splitlines() or ["no output"])[-1]
            return {name: f"{program[-1]} ended with {done.returncode}: {last}" for name in names}
        seen = verdicts(json.loads(report.read_text(encoding="utf-8")))
    return {name: seen.get(name, "did not run") for name in names}


def run_named(rows, tests):
    """The errors of the tests that the rows name."""
    findings = []
    places = collections.defaultdict(list)
    for row in rows:
        for name in row.tests:
            places[name].append(f"line {row.line}, {row.identifier}")
    programs = collections.defaultdict(list)
    for name, where in places.items():
        if name in tests:
            programs[tests[name]].append(name)
        else:
            findings.append(f"{where[0]}: there is no test {name}")
    with concurrent.futures.ThreadPoolExecutor(PROGRAMS_AT_ONCE) as pool:
        runs = [(program, names[i:i + TESTS_A_RUN]) for program, names in programs.items()
                for i in range(0, len(names), TESTS_A_RUN)]
        for result in pool.map(lambda run: run_program(*run[0], run[1]), runs):
            findings += [f"{places[name][0]}: {name} {why}" for name, why in result.items() if why]
    passed = len(places) - len(findings)
    return findings, passed


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path)
    parser.add_argument("--ctest", default="ctest")
    parser.add_argument("--page", type=pathlib.Path, default=ROOT / "docs" / "reference" / "conformance.md")
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    if not arguments.list and not arguments.build:
        parser.error("--build is needed to run the tests")

    rows, findings = check_page(arguments.page.read_text(encoding="utf-8"))
    passed = 0
    if not arguments.list:
        wrong, passed = run_named(rows, known_tests(arguments.ctest, arguments.build.resolve()))
        findings += wrong
    for finding in findings:
        print(f"{arguments.page.name}: {finding}")
    print(f"{len(rows)} rows, {passed} tests ran and passed, {len(findings)} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
