#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes docs/reference/objects.md from the dictionary and the disturbances that the tool prints.

  object_page.py VDRIVE [--check]

With --check the page is compared, and the exit code is 1 if it is out of date.
"""
import json
import pathlib
import subprocess
import sys

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "reference" / "objects.md"
HEAD = """# Objects

The object dictionary of an axis, as `vdrive dictionary` prints it; `tests/documents/object_page.py` writes this page.
Objects of the manual of the profile position mode are bold; vdrive adds the others.

- *access*: RO read only, RW writable; *stored*: `vdrive store` keeps the value. A write takes effect immediately;
  *at set-point*: with the next set-point; *at enable*: with the next transition to Operation enabled.
- *range*: blank = the full range of the type.

| object | variable name | type | access | default [unit] | range |
|---|---|---|---|---|---|
"""


DISTURBANCES = """
## Disturbances

The effects of the test-bench inputs, as `vdrive disturb --help` prints them. 605Eh selects how the axis stops in a
fault; the fault can be reset once its input is 0.

| `vdrive disturb` | effect on the axis |
|---|---|
"""

RANGES = {"UNS8": (0, 2**8 - 1), "UNS16": (0, 2**16 - 1), "UNS32": (0, 2**32 - 1),
          "INTEGER8": (-2**7, 2**7 - 1), "INTEGER16": (-2**15, 2**15 - 1), "INTEGER32": (-2**31, 2**31 - 1)}
MOMENTS = {"immediately": "", "read_only": "", "at_set_point": ", at set-point", "at_enable": ", at enable"}


def disturbances_of(help_text):
    """@return the rows of the table. In the help, each kind has a line with its name and one with its effect."""
    begin = help_text.index("load_torque")
    lines = [line.strip() for line in help_text[begin:].splitlines()]
    rows = []
    for kind, effect in zip(lines[::2], lines[1::2]):
        if kind == "none":
            return "".join(rows)
        name, _, unit = kind.partition(" ")
        rows.append(f"| `{name}`{' ' + unit if unit else ''} | {effect} |\n")
    raise ValueError("the help of disturb has no kind 'none'")


def row_of(row):
    address = f"{int(row['index'], 16):04X}h" + (f":{row['subindex']:02X}" if row["subindex"] else "")
    if row["origin"] == "manual":
        address = f"**{address}**"
    access = row["access"] + (", stored" if row["stored"] else "") + MOMENTS[row["effective"]]
    unit = "" if row["units"] == "-" else f" [{row['units']}]"
    limits = (row["lower_limit"], row["upper_limit"])
    span = "" if limits == RANGES[row["type"]] else f"{limits[0]} to {limits[1]} "
    return f"| {address} | `{row['name']}` | {row['type']} | {access} | {row['default']}{unit} | {span}|\n"


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--check"]):
        sys.exit(__doc__)
    output = subprocess.run([sys.argv[1], "dictionary", "--json"], check=True, capture_output=True,
                            text=True).stdout
    help_text = subprocess.run([sys.argv[1], "disturb", "--help"], check=True, capture_output=True,
                               text=True).stdout
    text = HEAD + "".join(row_of(json.loads(line)) for line in output.splitlines()) + DISTURBANCES + \
        disturbances_of(help_text)
    if len(sys.argv) == 2:
        PAGE.write_text(text, encoding="utf-8")
        return 0
    if PAGE.is_file() and PAGE.read_text(encoding="utf-8") == text:
        return 0
    print("docs/reference/objects.md is not current; this writes it: "
          f"tests/documents/object_page.py {sys.argv[1]}")
    return 1


if __name__ == "__main__":
    sys.exit(main())
