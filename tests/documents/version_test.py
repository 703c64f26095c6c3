#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The version number is defined in CMakeLists.txt, and everything that shows it agrees."""
import json
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
VERSION = re.search(r"^  VERSION (\d+\.\d+\.\d+)$", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE).group(1)
PROGRAMS = sys.argv[1:]


class Version(unittest.TestCase):
    def test_each_program_shows_number_commit_and_library(self):
        self.assertTrue(PROGRAMS)
        for program in PROGRAMS:
            shown = subprocess.run([program, "--version"], capture_output=True, text=True, timeout=30, check=True).stdout
            name = pathlib.Path(program).name
            self.assertRegex(shown, rf"^{name} {re.escape(VERSION)} \((commit ([0-9a-f]{{12,}}|unknown)|release), "
                                    r"Fast DDS \d+\.\d+\.\d+\)\n$")

    def test_the_changelog_begins_with_it_or_with_what_is_unreleased(self):
        first = re.search(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE).group(1)
        self.assertIn(first, (VERSION, "Unreleased"))

    def test_packages_of_npm_have_no_number_of_their_own(self):
        for path in ("clients/gateway/page", "tests/browser"):
            for file in ("package.json", "package-lock.json"):
                self.assertNotIn("version", json.loads((ROOT / path / file).read_text()), f"{path}/{file}")

    def test_the_wire_carries_it_whole(self):
        self.assertLessEqual(len(VERSION), 16, "string<16> service_version of BenchDescription")


unittest.main(argv=sys.argv[:1])
