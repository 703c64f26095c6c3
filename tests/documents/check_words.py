#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds words in documents and comments that read like a translation, and lines of documents that are too wide.

  check_words.py [--count] [PATH]...

Reads the *.md files and the comments (//, ///) of the *.cpp and *.hpp files below each PATH, by default
all. Each finding is a line "file:line: words: what to write instead". RULES is the list of words,
EXEMPTIONS the list of places where a rule does not apply, each with its reason. With --count only the
number of findings of each folder is printed.
"""
import argparse
import collections
import fnmatch
import pathlib
import re
import sys

import check_links

ROOT = pathlib.Path(__file__).resolve().parents[2]
WIDTH = 120
OPENING = "@opening "  # precedes the first line of a comment

END = r"(?=[.,;:)]|$)"  # of a clause
MACHINE = (r"(?:(?:a|an|the|its|both|this|such a|reducing|elastic|holding) )*(?:gears?\b|\d+(?:\.\d+)? ?: ?1|shaft|"
           r"motor|load|coupling|spring|transmission|encoder|belt|reducing|elastic)")
HIDDEN = (r"(?:(?:a|an|the|its|this|one|another|socketcand) )*(?:guard|firewall|router|NAT\b|proxy|ingress|load balancer|"
          r"switch\b|tunnel|server|wire\b|nodes?\b|CANopen|bridge|facade|interface|session\b|descriptor|handle)")

# name: for EXEMPTIONS and the test. pattern: the words in a paragraph, whose lines are joined. instead: the
# advice. allowed: pattern -> reason why words that it overlaps are good.
Rule = collections.namedtuple("Rule", "name pattern instead allowed")


def rule(name, pattern, instead, allowed=None):
    allowed = {re.compile(text, re.IGNORECASE): reason for text, reason in (allowed or {}).items()}
    return Rule(name, re.compile(pattern, re.IGNORECASE), instead, allowed)


RULES = [
    rule("behind", r"\bbehind\b", "after, following, past", {
        r"\b(?:lag|fall|leave|stay|keep|wait)(?:s|ing|ed)?\b(?: [\w.,/-]+){0,4} behind": "idioms",
        r"\b(?:fell|fallen|left|kept)\b(?: [\w.,/-]+){0,4} behind|\bone behind the other|\bfrom behind" + END: "idioms",
        r"\b(?:reasons?|numbers?|figures?|ideas?|programs?) behind": "idioms",
        r"\b(?:is|are|was|were) (?:[\w.,]+ )?behind" + END: "late",
        r"\d (?:ticks|ms|UU) behind|\b(?:far|never) behind|\bahead\b[^.]{0,60}\bbehind": "late, how much",
        r"\bbehind (?:the|their|its) (?:time|demand|target|axis|others?|bench|clock|master|newest)\b": "late",
        r"\bbehind (?:both|it) (?:by|at)\b": "late",
        r"\bbehind " + MACHINE: "on the far side of a part of the machine",
        r"\bbehind " + HIDDEN: "protected or hidden by it",
        r"\bWhat is behind\b": "hidden by an interface",
    }),
    rule("beside", r"\bbeside\b", "next to, with, besides, apart from"),
    rule("meanwhile", r"\bmeanwhile\b" + END, "while ..., in the meantime"),
    rule("anew", r"\banew\b", "again"),
    rule("of before", r"\bof before\b", "previous, earlier"),
    rule("of then", r"\bof then\b", "at that moment"),
    rule("the one before", r"\bthe (?:one|ones|call|entry|frame|line|message|record|run|sample|segment|state|step|"
                           r"tick|value|word)s? before(?:" + END + r"| it\b)", "the previous one"),
    rule("is whole", r"\b(?:be|been|is|are|was|were|not|arrives?|arrived|comes?|came|stays?|stayed) whole\b"
                     r"(?: yet\b| again\b|" + END + ")", "complete", {
        r"[\d`] are whole\b|\bnumber\b[^.;]{0,40}\bwhole\b|\bwhole\b[^.;]{0,40}\bfraction|"
        r"\bunits are whole\b": "a whole number",
    }),
    rule("heed", r"\bheed(?:s|ed|ing)?\b", "consider, obey, react to"),
    rule("take leave", r"\b(?:take|takes|took|taking|taken) leave\b|\b(?-i:parting)\b", "announce the end, disconnect"),
    rule("greet", r"\bgreet(?:s|ed)?\b", "announce itself, answer the first message"),
    rule("What as an opening", "^" + OPENING + r"(?-i:What)\b(?!'s)(?![^.]*\?)", "The ..., Returns ..., or a verb"),
    rule("Who as an opening", "^" + OPENING + r"(?-i:Who)\b(?!'s)(?![^.]*\?)", "The ..., or a noun such as owner"),
    rule("who for a program", r"\b(?:axis|bench|caller|client|drive|master|process|program|reader|server|service|session|"
                              r"thread|writer)s?,? who\b", "that, which"),
    rule("such one", r"\b(?:such a one|such one)\b", "one like this"),
    rule("for it alone", r"\bfor (?:it|him|her|them) alone\b", "only for it"),
    rule("at the latest after", r"\bat the latest (?:after|when)\b", "within, no later than"),
    rule("say of", r"\b(?:says?|said|tells?) of\b", "says about, reports"),
    rule("become of", r"\b(?:becomes?|became|come|comes|came) of (?:it|its|that|this|them|each|every|a|an|the)\b",
         "effect, result, outcome"),
    rule("each 5 s", r"\beach (?:\d[\d.,]*|n) ?(?:us|ms|s|min|h|ticks|seconds|milliseconds|hours)\b", "every", {
        r"\beach \S+ ?\w+ (?:apart|late|later|long|wide)\b|\bof each\b": "each of several",
    }),
    rule("in the place of", r"\bin the place of\b", "instead of"),
    rule("without a look", r"\bwithout a look\b", "without reading, without checking"),
    rule("is to be done", r"\b(?:is|are|was|were) to be \w+(?:ed|en|wn|nt|un|ut|ad)\b", "must be, should be"),
    rule("the same of", r"\bthe same of\b", "the same for"),
    rule("no more", r"\bno more\b" + END, "no longer", {
        r"\b(?:and|but|or) no more\b": "as in: one, and no more",
    }),
    rule("whence", r"\b(?:whence|thence|hither|thither|hitherto|henceforth|thereof|whereof|wherein|forthwith)\b",
         "a modern word"),
]

# Where a rule does not apply. paths: a pattern of fnmatch; line: a pattern of lines of the file.
Exemption = collections.namedtuple("Exemption", "paths rule line reason")
TOO_WIDE = "too wide"
EXEMPTIONS = [
    Exemption("docs/reference/objects.md", TOO_WIDE, r"^\| ", "tests/documents/object_page.py writes these rows"),
    Exemption("docs/reference/judge-rules.md", TOO_WIDE, r"", "vdrive judge --rules writes this page"),
    Exemption("docs/reference/conformance*.md", TOO_WIDE, r"^ *`",
              "tests/conformance/check.py reads the names of the tests of a statement as one line"),
    Exemption("core/include/vdrive/number_text.hpp", "is whole", r"", "whole numbers are its subject"),
    Exemption("*.md", TOO_WIDE, r"^\W*(?:\[[^\]]*\]\()?https?://\S+$", "an address cannot be broken"),
]

Finding = collections.namedtuple("Finding", "path line words instead")


def comments_of(text):
    """@return (line, whether nothing stands before it, text) of each comment with // or ///."""
    comments, end_of_raw = [], None
    for number, line in enumerate(text.split("\n"), 1):
        place, quote = 0, None
        while place < len(line):
            if end_of_raw:
                end = line.find(end_of_raw, place)
                if end < 0:
                    break
                place, end_of_raw = end + len(end_of_raw), None
                continue
            sign = line[place]
            if quote:
                if sign == "\\":
                    place += 1
                elif sign == quote:
                    quote = None
            elif line.startswith("//", place):
                comment = re.sub(r"^//[/!]?<? ?", "", line[place:]).strip()
                comments.append((number, not line[:place].strip(), comment))
                break
            elif sign == '"' and line[:place].endswith("R") and "(" in line[place:]:
                bracket = line.index("(", place)
                end_of_raw = ")" + line[place + 1:bracket] + '"'
                place = bracket
            elif sign == '"' or (sign == "'" and not line[place - 1:place].isalnum()):
                quote = sign
            place += 1
    return comments


def without_code(line):
    """Code and the targets of links are no prose."""
    line = re.sub(r"`[^`]*`", "`0`", line)
    return re.sub(r"https?://\S+", "", re.sub(r"\]\([^)]*\)", "]", line))


def blocks_of_source(text):
    """Comments that belong together, each a list of (line, text)."""
    block, last = [], 0
    for number, is_alone, comment in comments_of(text):
        is_tag = re.match(r"SPDX-|NOLINT|clang-format", comment)
        if block and (not is_alone or number != last + 1 or not comment or is_tag):
            yield block
            block = []
        if comment and not is_tag:
            block.append((number, ("" if block else OPENING) + without_code(comment)))
        last = number
    if block:
        yield block


def blocks_of_document(text):
    """Paragraphs, items, headings and rows of tables, each a list of (line, text)."""
    block, is_code = [], False
    for number, line in enumerate(text.split("\n"), 1):
        fence = re.match(r"\s*(?:```|~~~)", line)
        is_code = is_code != bool(fence)
        begins = re.match(r"\s*(?:#|\||[-*+] |\d+\. )", line)
        if block and (is_code or fence or begins or not line.strip()):
            yield block
            block = []
        if not is_code and not fence and line.strip():
            block.append((number, without_code(line).strip()))
    if block:
        yield block


def is_exempt(path, name, line):
    return any(fnmatch.fnmatch(path, one.paths) and one.rule == name and re.search(one.line, line)
               for one in EXEMPTIONS)


def uses_in(block):
    """@return (line, rule, words) of each use of words of RULES in a paragraph."""
    text, lines = "", []
    for number, line in block:
        text += (" " if text else "") + line
        lines += [number] * (len(text) - len(lines))
    for one in RULES:
        for match in one.pattern.finditer(text):
            if not any(good.start() < match.end() and match.start() < good.end()
                       for pattern in one.allowed for good in pattern.finditer(text)):
                yield lines[match.start()], one, match[0].replace(OPENING, "")


def findings_in(path, text):
    """@param path below the root of the tree, with / between folders"""
    lines = text.split("\n")
    is_document = path.endswith(".md")
    blocks = blocks_of_document(text) if is_document else blocks_of_source(text)
    found = [(number, words, one.instead) for block in blocks for number, one, words in uses_in(block)
             if not is_exempt(path, one.name, lines[number - 1])]
    if is_document:
        found += [(number, f"{len(line)} characters", f"at most {WIDTH}")
                  for number, line in enumerate(lines, 1)
                  if len(line) > WIDTH and not is_exempt(path, TOO_WIDE, line)]
    return [Finding(path, *one) for one in sorted(found)]


def files_below(paths):
    """@return the files to be read, relative to the root, with / between folders."""
    wanted = [path.resolve() for path in paths] or [ROOT]
    return [file.relative_to(ROOT).as_posix() for file in check_links.files_of(ROOT)
            if file.suffix in (".md", ".cpp", ".hpp") and any(file.is_relative_to(path) for path in wanted)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", action="store_true", help="only the number of findings of each folder")
    parser.add_argument("paths", metavar="PATH", nargs="*", type=pathlib.Path)
    arguments = parser.parse_args()
    findings = [finding for name in files_below(arguments.paths)
                for finding in findings_in(name, (ROOT / name).read_text(encoding="utf-8"))]
    if arguments.count:
        rooms = collections.Counter("/".join(finding.path.split("/")[:-1][:2]) or "." for finding in findings)
        for room, number in sorted(rooms.items()):
            print(f"{number:5} {room}")
    else:
        for finding in findings:
            print(f"{finding.path}:{finding.line}: {finding.words}: write {finding.instead}")
    print(f"{len(findings)} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
