#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that every link in a document and every path docs/... in the tree has a target.

  check_links.py [--root TREE]

Relative links of *.md files must name an existing file or folder, and their #anchor a heading of
that page. Every path below docs/ to a page or a picture in any text file must exist. CHANGELOG.md
describes history, so only its links are checked.
"""
import argparse
import pathlib
import re
import sys

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
PATH = re.compile(r"(?<![\w./-])docs/[\w./-]*\w\.(?:md|svg|yaml)\b")
CODE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
TEXTS = {".md", ".hpp", ".cpp", ".c", ".py", ".sh", ".idl", ".yaml", ".txt", ".cmake", ".service",
         ".conf", ".scn", ".json"}
SKIPPED = {"build", ".git", "corpus", "node_modules"}


def anchors_of(text):
    """@return the anchors of the headings, in the format of GitHub and others."""
    anchors = set()
    for heading in re.findall(r"^#+ (.*)$", CODE.sub("", text), re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").lower()
        anchors.add(re.sub(r"[^\w\- ]", "", plain).replace(" ", "-"))
    return anchors


def findings_in_document(root, file):
    findings = []
    text = CODE.sub("", file.read_text(encoding="utf-8"))
    for link in LINK.findall(text):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (file.parent / path).resolve() if path else file
        place = f"{file.relative_to(root)}: link {link}"
        if not target.exists():
            findings.append(f"{place}: there is no such file")
        elif anchor and target.suffix == ".md" and (
                anchor not in anchors_of(target.read_text(encoding="utf-8"))):
            findings.append(f"{place}: the page has no such heading")
    return findings


def files_of(root):
    for file in sorted(root.rglob("*")):
        if not SKIPPED.intersection(file.relative_to(root).parts) and file.suffix in TEXTS:
            if file.is_file():
                yield file


def findings_in(root):
    findings = []
    for file in files_of(root):
        if file.suffix == ".md":
            findings += findings_in_document(root, file)
        if file.name in ("CHANGELOG.md", "check_links_test.py"):
            continue
        text = file.read_text(encoding="utf-8", errors="replace")
        for path in PATH.findall(text):
            if not (root / path).exists():
                findings.append(f"{file.relative_to(root)}: {path} does not exist")
    return findings


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=pathlib.Path,
                        default=pathlib.Path(__file__).resolve().parents[2])
    findings = findings_in(parser.parse_args().root.resolve())
    print("\n".join(findings) if findings else "every link and path has a target")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
