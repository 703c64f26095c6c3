#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks docs/reference/conformance.md and conformance-canopen.md: every statement is shown by tests
that exist, ran and passed.

    tests/conformance/check.py --build DIRECTORY [--ctest PROGRAM] [--page FILE]...
    tests/conformance/check.py --results FILE [--results FILE] [--page FILE]...

    --build DIRECTORY  a build with tests: the named tests must be among them
    --results FILE     what ctest wrote for --output-junit in a run of all tests: the named tests must
                       have run and passed, in one of the files
    --page FILE        a page with the name of one of the two; default: both

A statement is an item of a list, "- **M-12** text", possibly of several lines. Its last line has the names
of its tests as tests/checks/results.py prints them, in backticks, separated by <br>. A line of names before
a list applies to each of its items that has none. Identifiers of conformance.md: O-607D:01 an object of the
manual's table, M-12 a statement of the manual, A-12 an ambiguity, R-12 a rule of interoperability; of
conformance-canopen.md: O-1017 an object of CiA 301, C-12 a clause of CiA 301, D-12 one of CiA 402 on
CANopen, M-12 a rule that masters rely on. A test that was skipped, disabled or left out does not count.
Exit code 0: no errors; otherwise each line of the output is one error.
"""
import argparse
import collections
import csv
import pathlib
import re
import sys
import xml.etree.ElementTree as ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "checks"))
import results  # pylint: disable=wrong-import-position

REFERENCE = ROOT / "docs" / "reference"
OBJECTS = ROOT / "tests" / "data" / "object-dictionary.csv"
NUMBERED = re.compile(r"([A-NP-Z])-([1-9][0-9]*)")
OBJECT = re.compile(r"O-[0-9A-F]{4}(:[0-9A-F]{2})?")
COMMUNICATION_OBJECTS = [  # of CiA 301: those of a drive, and the two of node guarding, which are absent
    "1000", "1001", "1003", "1005", "1006", "1007", "1008", "1009", "100A", "100C", "100D", "1010",
    "1011", "1014", "1015", "1016", "1017", "1018", "1019", "1020", "1029", "1200",
    *(f"{block}0{number}" for block in ("14", "16", "18", "1A") for number in range(4))]

ITEM = re.compile(r"- \*\*(\S+)\*\* (.*)")
NAMES = re.compile(r"`[^`]+`(?:<br>`[^`]+`)*")

Row = collections.namedtuple("Row", "line identifier text tests")


def parse(text):
    """The statements of the page, and the errors in their format."""
    rows, findings, common, is_item = [], [], [], False
    for number, line in enumerate(text.splitlines(), 1):
        item = ITEM.fullmatch(line)
        tests = re.findall(r"`([^`]*)`", line)
        if item:
            if not (NUMBERED.fullmatch(item[1]) or OBJECT.fullmatch(item[1])):
                findings.append(f"line {number}, {item[1]}: this is no identifier")
            rows.append(Row(number, item[1], item[2], list(common)))
            is_item = True
        elif not line.startswith("  "):
            is_item = False
            if line:
                common = tests if NAMES.fullmatch(line) else []
        elif is_item and NAMES.fullmatch(line.strip()):
            rows[-1] = rows[-1]._replace(tests=tests)
        elif is_item and line.startswith("  `") and "<br>`" in line:
            findings.append(f"line {number}, {rows[-1].identifier}: more than names in backticks: {line.strip()}")
        elif is_item:
            rows[-1] = rows[-1]._replace(text=f"{rows[-1].text} {line.strip()}")
    return rows, findings


def expected_objects():
    """Identifier -> the name of the variable, from the manual's table."""
    with open(OBJECTS, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    several = {row["index"] for row in rows if row["subindex"] != "0x00"}
    objects = {}
    for row in rows:
        name = "O-" + row["index"][2:]
        if row["index"] in several:
            name += ":" + row["subindex"][2:]
        objects[name] = row["variable_name"]
    return objects


def check_objects_of_the_manual(rows):
    objects = expected_objects()
    findings = [f"object {name} of the manual's table has no row"
                for name in objects if name not in {row.identifier for row in rows}]
    for row in rows:
        if not row.identifier.startswith("O-"):
            continue
        if row.identifier not in objects:
            findings.append(f"line {row.line}, {row.identifier}: not in the manual's table")
        elif row.text != f"`{objects[row.identifier]}`":
            findings.append(f"line {row.line}, {row.identifier}: the variable is {row.text}, "
                            f"in the manual's table {objects[row.identifier]}")
    return findings


def check_communication_objects(rows):
    wanted = {"O-" + index for index in COMMUNICATION_OBJECTS}
    present = {row.identifier for row in rows if OBJECT.fullmatch(row.identifier)}
    return ([f"object {name} of CiA 301 has no row" for name in sorted(wanted - present)]
            + [f"object {name} is none of CiA 301 that a drive has" for name in sorted(present - wanted)])


# Per page: letter -> (kind of statement, how many there are; None: at least one), and the function
# that checks the rows about objects.
Page = collections.namedtuple("Page", "kinds check_objects")
PAGES = {
    "conformance.md": Page({"M": ("statement of the manual", None), "A": ("ambiguity", 48),
                            "R": ("rule", 12)}, check_objects_of_the_manual),
    "conformance-canopen.md": Page({"C": ("clause of CiA 301", None),
                                    "D": ("clause of CiA 402", None),
                                    "M": ("rule of masters", None)}, check_communication_objects),
}


def check_kind(letter, kind, count, names):
    """The errors in the numbers of one letter: they must be 1 to `count`, or start at 1 with no gap."""
    present = {int(match[2]) for match in map(NUMBERED.fullmatch, names)
               if match and match[1] == letter}
    wanted = set(range(1, (count or max(present, default=0)) + 1))
    findings = [f"{kind} {letter}-{number} has no row" for number in sorted(wanted - present)]
    findings += [f"{kind} {letter}-{number} is beyond the last" for number in sorted(present - wanted)]
    return findings if present or count else [f"there is no {kind}"]


def check_page(text, page=PAGES["conformance.md"]):
    """@return the rows, and the errors in the page itself."""
    rows, findings = parse(text)
    lines = collections.defaultdict(list)
    for row in rows:
        lines[row.identifier].append(row.line)
        if not row.tests:
            findings.append(f"line {row.line}, {row.identifier}: no test holds it")
    for identifier, where in lines.items():
        if len(where) > 1:
            findings.append(f"{identifier} is used in lines {', '.join(map(str, where))}")
    for letter, (kind, count) in page.kinds.items():
        findings += check_kind(letter, kind, count, lines)
    findings += [f"{name} is no identifier of this page" for name in lines
                 if NUMBERED.fullmatch(name) and name[0] not in page.kinds]
    return rows, findings + page.check_objects(rows)


def verdicts(reports):
    """Name -> None if the test ran and passed in one of the reports, otherwise why not."""
    result = {}
    for report in reports:
        for test in (test for case in results.cases_of(report) for test in case.tests):
            if test.verdict == results.PASSED:
                result[test.name] = None
            elif result.get(test.name, "") is not None:
                result[test.name] = test.verdict
    return result


def check_named(rows, tests):
    """The errors of the tests that the rows name, and the number of tests without errors."""
    findings = []
    places = collections.defaultdict(list)
    for row in rows:
        for name in row.tests:
            places[name].append(f"line {row.line}, {row.identifier}")
    for name, where in places.items():
        wrong = tests.get(name, "is not there")
        if wrong:
            findings.append(f"{where[0]}: {name} {wrong}")
    return findings, len(places) - len(findings)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--build", type=pathlib.Path)
    source.add_argument("--results", type=pathlib.Path, action="append")
    parser.add_argument("--ctest", default="ctest")
    parser.add_argument("--page", type=pathlib.Path, action="append")
    arguments = parser.parse_args()

    pages = arguments.page or [REFERENCE / name for name in PAGES]
    for page in pages:
        if page.name not in PAGES:
            parser.error(f"--page {page}: its name is none of {', '.join(PAGES)}")

    if arguments.results:
        try:
            tests, state = verdicts(arguments.results), "ran and passed"
        except (OSError, ElementTree.ParseError) as error:
            parser.error(f"--results: {error}")
    else:
        tests = dict.fromkeys(results.names_of(arguments.build.resolve(), arguments.ctest))
        state = "are there"
    errors = 0
    for page in pages:
        rows, findings = check_page(page.read_text(encoding="utf-8"), PAGES[page.name])
        wrong, good = check_named(rows, tests)
        findings += wrong
        for finding in findings:
            print(f"{page.name}: {finding}")
        print(f"{page.name}: {len(rows)} rows, {good} tests {state}, {len(findings)} findings")
        errors += len(findings)
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
