#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_links.py finds each kind of mistake."""
import pathlib
import tempfile
import unittest

import check_links


class Links(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = pathlib.Path(self.folder.name).resolve()
        (self.root / "docs").mkdir()
        self.write("docs/page.md", "# Page\n\n## A `part` of it\n")

    def write(self, name, text):
        (self.root / name).write_text(text, encoding="utf-8")

    def findings(self):
        return check_links.findings_in(self.root)

    def test_good_links_pass(self):
        self.write("README.md", "[a](docs/page.md) [b](docs/page.md#a-part-of-it) <x> "
                                "[c](https://example.org/x.md) see docs/page.md\n")
        self.assertEqual(self.findings(), [])

    def test_a_missing_file_is_found(self):
        self.write("README.md", "[a](docs/none.txt)\n")
        self.assertEqual(self.findings(), ["README.md: link docs/none.txt: there is no such file"])

    def test_a_missing_heading_is_found(self):
        self.write("docs/other.md", "[a](page.md#nothing)\n")
        self.assertEqual(self.findings(),
                         ["docs/other.md: link page.md#nothing: the page has no such heading"])

    def test_a_missing_path_in_a_source_is_found(self):
        self.write("a.cpp", "// as docs/gone.md has it\n")
        self.assertEqual(self.findings(), ["a.cpp: docs/gone.md does not exist"])

    def test_code_blocks_have_no_links_and_no_headings(self):
        self.write("docs/other.md", "```\n[a](none.md)\n# x\n```\n[b](#x)\n")
        self.assertEqual(self.findings(), ["docs/other.md: link #x: the page has no such heading"])


if __name__ == "__main__":
    unittest.main()
