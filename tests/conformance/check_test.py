#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Shows that the check of the conformance page can fail: it finds and names each planted mistake."""
import pathlib
import re
import tempfile
import unittest

import check

PAGE = (check.REFERENCE / "conformance.md").read_text(encoding="utf-8")
CANOPEN_PAGE = (check.REFERENCE / "conformance-canopen.md").read_text(encoding="utf-8")


def findings_of(text):
    return check.check_page(text)[1]


def row_of(identifier, page=PAGE):
    """The lines of a statement."""
    return re.search(rf"^- \*\*{re.escape(identifier)}\*\* .*\n(?:  .*\n)*", page, flags=re.MULTILINE).group()


def without_row(identifier):
    return PAGE.replace(row_of(identifier), "")


def without_tests(row):
    return re.sub(r"  `.*\n$", "", row)


class ThePage(unittest.TestCase):
    def test_the_present_page_has_no_finding(self):
        self.assertEqual(findings_of(PAGE), [])

    def test_a_missing_row_of_an_ambiguity_is_found(self):
        self.assertIn("ambiguity A-17 has no row", findings_of(without_row("A-17")))

    def test_a_missing_row_of_a_rule_is_found(self):
        self.assertIn("rule R-12 has no row", findings_of(without_row("R-12")))

    def test_an_additional_ambiguity_is_found(self):
        page = PAGE.replace("**A-48**", "**A-49**")
        self.assertEqual({"ambiguity A-48 has no row", "ambiguity A-49 is beyond the last"},
                         set(findings_of(page)))

    def test_a_missing_row_of_an_object_is_found(self):
        self.assertIn("object O-607D:02 of the manual's table has no row",
                      findings_of(without_row("O-607D:02")))

    def test_another_variable_of_an_object_is_found(self):
        page = PAGE.replace(row_of("O-6081"), row_of("O-6083").replace("6083", "6081"))
        self.assertIn("the variable is `profile_acc`, in the manual's table profile_velocity",
                      findings_of(page)[0])

    def test_objects_without_a_test_are_found(self):
        page = PAGE.replace(f"`{check.parse(PAGE)[0][2].tests[0]}`<br>", "See `", 1)
        self.assertRegex(findings_of(page)[0], r"line \d+, O-3005: no test holds it")

    def test_a_duplicate_identifier_is_found(self):
        page = PAGE.replace(row_of("A-2"), row_of("A-2") * 2)
        self.assertRegex(findings_of(page)[0], r"A-2 is used in lines \d+, \d+")

    def test_a_statement_without_a_test_is_found(self):
        row = row_of("A-3")
        page = PAGE.replace(row, without_tests(row))
        self.assertRegex(findings_of(page)[0], r"line \d+, A-3: no test holds it")

    def test_words_beside_the_names_are_found(self):
        row = row_of("A-3")
        page = PAGE.replace(row, row.rstrip() + " and by hand\n")
        self.assertRegex(findings_of(page)[0], r"A-3: more than names")

    def test_another_identifier_is_found(self):
        page = PAGE.replace("**A-3**", "**A3**")
        self.assertRegex(findings_of(page)[0], r"A3: this is no identifier")


class ThePageOfCanopen(unittest.TestCase):
    def findings_of(self, identifier, change):
        """The errors of the page after `change` has changed a statement."""
        row = row_of(identifier, CANOPEN_PAGE)
        page = CANOPEN_PAGE.replace(row, change(row))
        return check.check_page(page, check.PAGES["conformance-canopen.md"])[1]

    def test_the_present_page_has_no_finding(self):
        self.assertEqual(self.findings_of("C-1", lambda row: row), [])

    def test_a_missing_row_of_an_object_is_found(self):
        self.assertEqual(self.findings_of("O-1017", lambda row: ""), ["object O-1017 of CiA 301 has no row"])

    def test_an_object_that_no_drive_has_is_found(self):
        self.assertEqual(self.findings_of("O-1017", lambda row: row + row.replace("1017", "1012")),
                         ["object O-1012 is none of CiA 301 that a drive has"])

    def test_a_number_that_is_left_out_is_found(self):
        self.assertEqual(self.findings_of("C-2", lambda row: ""), ["clause of CiA 301 C-2 has no row"])

    def test_an_identifier_of_the_other_page_is_found(self):
        self.assertEqual(self.findings_of("C-1", lambda row: row + row.replace("C-1**", "A-1**")),
                         ["A-1 is no identifier of this page"])

    def test_a_clause_without_a_test_is_found(self):
        findings = self.findings_of("D-1", without_tests)
        self.assertRegex(findings[0], r"line \d+, D-1: no test holds it")


# As ctest 3.25 writes them.
RESULTS = """<testsuite name="Linux-c++" tests="6">
  <testcase name="Suite.Passes" classname="Suite.Passes" time="0.1" status="run"/>
  <testcase name="Suite.Fails" classname="Suite.Fails" time="0.1" status="fail"><failure message=""/></testcase>
  <testcase name="Suite.Skips" classname="Suite.Skips" time="0.1" status="notrun">
    <skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/></testcase>
  <testcase name="Suite.IsDisabled" classname="Suite.IsDisabled" time="0" status="disabled"/>
  <testcase name="a_test.Whole/Other" classname="a_test.Whole/Other" time="0.1" status="fail"><system-out>
[ RUN      ] Whole/Other.Passes/0
[       OK ] Whole/Other.Passes/0 (0 ms)
[ RUN      ] Whole/Other.Skips
[  SKIPPED ] Whole/Other.Skips (0 ms)
[ RUN      ] Whole/Other.Fails
[  FAILED  ] Whole/Other.Fails (0 ms)
[ RUN      ] Whole/Other.Crashes
</system-out></testcase>
</testsuite>
"""


class ANamedTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def findings_of(self, test, *results):
        files = []
        for number, text in enumerate(results or [RESULTS]):
            files.append(self.folder / f"{number}.xml")
            files[-1].write_text(text, encoding="utf-8")
        return check.check_named([check.Row(7, "M-1", "", [test])], check.verdicts(files))[0]

    def test_a_passing_test_gives_no_finding(self):
        self.assertEqual(self.findings_of("Suite.Passes"), [])

    def test_a_missing_test_is_found(self):
        self.assertEqual(self.findings_of("Suite.Renamed"), ["line 7, M-1: Suite.Renamed is not there"])

    def test_a_failing_test_is_found(self):
        self.assertEqual(self.findings_of("Suite.Fails"), ["line 7, M-1: Suite.Fails failed"])

    def test_a_skipped_test_is_found(self):
        self.assertEqual(self.findings_of("Suite.Skips"), ["line 7, M-1: Suite.Skips did not run"])

    def test_a_disabled_test_is_found(self):
        self.assertEqual(self.findings_of("Suite.IsDisabled"), ["line 7, M-1: Suite.IsDisabled did not run"])

    def test_each_test_of_a_suite_is_read_from_its_output(self):
        for name, finding in (("Passes/0", None), ("Skips", "did not run"), ("Fails", "failed"),
                              ("Crashes", "did not end"), ("IsNotThere", "is not there")):
            self.assertEqual(self.findings_of("Whole/Other." + name),
                             [f"line 7, M-1: Whole/Other.{name} {finding}"] if finding else [])

    def test_a_test_that_passed_in_one_of_two_runs_gives_no_finding(self):
        again = RESULTS.replace("Suite.Fails", "Suite.Other").replace("Suite.Passes", "Suite.Fails")
        for results in (RESULTS, again), (again, RESULTS):
            self.assertEqual(self.findings_of("Suite.Fails", *results), [])


if __name__ == "__main__":
    unittest.main()
