#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The check of words finds each kind of mistake, and leaves good sentences alone."""
import unittest

import check_words

# Name of a rule -> a sentence that it finds, and the line of the report about it.
BAD = {
    "behind": ("Behind a call the queue is empty.", "Behind"),
    "beside": ("It has a name beside its number.", "beside"),
    "meanwhile": ("The others wait meanwhile.", "meanwhile"),
    "anew": ("The count begins anew.", "anew"),
    "of before": ("The plan of before is void.", "of before"),
    "of then": ("It is sent with the bytes of then.", "of then"),
    "the one before": ("Each tick repeats the one before.", "the one before"),
    "is whole": ("The command line is not whole yet.", "not whole yet"),
    "heed": ("It heeds the limit.", "heeds"),
    "take leave": ("Before it ends it takes leave.", "takes leave"),
    "greet": ("The client has greeted the service.", "greeted"),
    "What as an opening": ("What a frame carries.", "What"),
    "Who as an opening": ("Who holds the axis.", "Who"),
    "who for a program": ("It answers a client who waits.", "client who"),
    "such one": ("There is no such one.", "such one"),
    "for it alone": ("The queue is for it alone.", "for it alone"),
    "at the latest after": ("It answers at the latest after 5 ms.", "at the latest after"),
    "say of": ("A line tells of the failure.", "tells of"),
    "become of": ("It shows the end, and what became of it.", "became of it"),
    "each 5 s": ("A frame is sent each 10 ms.", "each 10 ms"),
    "in the place of": ("It writes the name in the place of the number.", "in the place of"),
    "without a look": ("It moves without a look at the state.", "without a look"),
    "is to be done": ("The wire is to be started.", "is to be started"),
    "the same of": ("This is the same of one axis.", "the same of"),
    "no more": ("The reader waits no more.", "no more"),
    "whence": ("The thread whence it came.", "whence"),
}
GOOD = [
    "The axis lags behind its demand.", "The samples fall far behind.", "The load is behind a gear of 10:1.",
    "The client is behind a firewall.", "No file is left behind.", "The reasons behind these rules.",
    "Meanwhile the others wait.", "Such as 1e6 and 2.0: all are whole numbers.", "A number is whole or a fraction.",
    "User units are whole: 1.5 is refused.", "The programs behind the sessions.",
    "What is a bench?", "Whatever it costs.", "Whoever asks is told.", "The person who asks.", "Each 10 ms long.",
    "The value of each 10 ms.", "It has no more than two.", "He leaves the room.", "It is `anew`.",
]


def words_of(path, text):
    return [(finding.line, finding.words) for finding in check_words.findings_in(path, text)]


class Words(unittest.TestCase):
    def test_each_rule_finds_its_mistake_in_a_comment(self):
        self.assertEqual({rule.name for rule in check_words.RULES}, set(BAD))
        for rule in check_words.RULES:
            with self.subTest(rule.name):
                sentence, words = BAD[rule.name]
                findings = check_words.findings_in("a.hpp", f"int a;\n/// {sentence}\n")
                self.assertEqual([(2, words, rule.instead)],
                                 [(finding.line, finding.words, finding.instead) for finding in findings])

    def test_good_sentences_pass(self):
        for sentence in GOOD:
            with self.subTest(sentence):
                self.assertEqual([], words_of("a.cpp", f"// {sentence}\n"))

    def test_a_phrase_may_go_over_the_end_of_a_line(self):
        self.assertEqual([(2, "of before")], words_of("a.cpp", "// The first line, the plan\n//   of\n// before.\n"))
        self.assertEqual([(4, "of before")], words_of("a.md", "# A\n\nThe plan\nof\nbefore.\n"))

    def test_every_kind_of_comment_is_read(self):
        self.assertEqual([(1, "anew"), (2, "anew"), (3, "anew")],
                         words_of("a.cpp", "int a;  // anew\nint b;  ///< anew\n//! anew\n"))

    def test_code_and_strings_are_no_comments(self):
        self.assertEqual([], words_of("a.cpp", 'int anew; f("// anew", "\\"// anew", \'"\', 1\'000);\n'))
        self.assertEqual([], words_of("a.cpp", 'auto a = R"x(\n// anew\n" // anew )x";\n'))
        self.assertEqual([(2, "anew")], words_of("a.cpp", 'auto a = R"(\n)";  // anew\n'))

    def test_only_the_opening_of_a_comment_is_one(self):
        self.assertEqual([], words_of("a.cpp", "// It has\n// What it needs.\n"))
        self.assertEqual([(2, "What")], words_of("a.cpp", "// SPDX-License-Identifier: Apache-2.0\n// What it has.\n"))
        self.assertEqual([(3, "What")], words_of("a.cpp", "// It has it.\n//\n// What it has.\n"))
        self.assertEqual([], words_of("a.hpp", "int a;  ///< what to do about it\n"))
        self.assertEqual([], words_of("a.md", "What is a bench? What it has.\n"))

    def test_code_and_links_of_a_document_are_not_read(self):
        self.assertEqual([], words_of("a.md", "```\nanew\n```\n`anew` [a](anew.md) https://example.org/anew\n"))
        self.assertEqual([(1, "anew"), (3, "anew"), (4, "anew")],
                         words_of("a.md", "# Begin anew\n\n- [anew](a.md)\n| a | anew |\n"))

    def test_a_wide_line_of_a_document_is_found(self):
        wide = "a" * 60 + " " + "b" * 60
        self.assertEqual([(1, "121 characters")], words_of("a.md", wide + "\n"))
        self.assertEqual([(2, "123 characters")], words_of("a.md", f"| a |\n| {wide}\n"))
        self.assertEqual([], words_of("a.md", wide[:120] + "\n"))
        self.assertEqual([], words_of("a.cpp", f"// {wide}\n"))

    def test_exempt_lines_may_be_wide(self):
        names = "  `" + "a" * 120 + "`\n"
        self.assertEqual([], words_of("docs/reference/conformance.md", names))
        self.assertEqual([(1, "124 characters")], words_of("docs/reference/conformance.md", "- " + names[2:]))
        self.assertEqual([], words_of("a.md", f"- [address](https://example.org/{'a' * 120})\n"))

    def test_a_file_may_be_exempt_from_a_rule(self):
        text = "// if it is whole\n// The plan of before.\n"
        self.assertEqual([(2, "of before")], words_of("core/include/vdrive/number_text.hpp", text))
        self.assertEqual([(1, "is whole"), (2, "of before")], words_of("core/a.hpp", text.replace("\n", ".\n", 1)))

    def test_the_files_below_a_path_are_read(self):
        root = check_words.ROOT
        self.assertEqual(["README.md"], check_words.files_below([root / "README.md"]))
        files = check_words.files_below([root / "docs", root / "core" / "include"])
        self.assertIn("docs/README.md", files)
        self.assertIn("core/include/vdrive/axis_bank.hpp", files)
        self.assertFalse([name for name in files if not name.endswith((".md", ".hpp"))])

    def test_every_exemption_has_a_reason_and_a_file(self):
        files = check_words.files_below([])
        for one in check_words.EXEMPTIONS:
            with self.subTest(one.paths):
                self.assertTrue(one.reason)
                self.assertTrue([name for name in files if check_words.fnmatch.fnmatch(name, one.paths)])
                self.assertIn(one.rule, {check_words.TOO_WIDE, *(rule.name for rule in check_words.RULES)})


if __name__ == "__main__":
    unittest.main()
