#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The man page has each example of the tool's help on a separate line, and its sections.

  man_page_test.py PAGE VDRIVE
"""
import pathlib
import re
import subprocess
import sys


def main():
    page, tool = sys.argv[1:]
    text = subprocess.run([tool, "--help"], check=True, capture_output=True, text=True).stdout
    examples = re.search(r"\nExamples:\n(.*?)\n\n", text, re.DOTALL).group(1).splitlines()
    source = pathlib.Path(page).read_text(encoding="utf-8").replace("\\-", "-")
    # roff leaves the lines between .nf and .fi unchanged.
    kept = "\n".join(re.findall(r"^\.nf\n(.*?)^\.fi$", source, re.DOTALL | re.MULTILINE)).splitlines()
    missing = [example.strip() for example in examples if example not in kept]
    missing += [title for title in ("EXAMPLES", "ENVIRONMENT", '"EXIT STATUS"')
                if f".SH {title}\n" not in source]
    for text in missing:
        print(f"{page} has no line '{text}'")
    return 1 if missing or len(examples) < 5 else 0


if __name__ == "__main__":
    sys.exit(main())
