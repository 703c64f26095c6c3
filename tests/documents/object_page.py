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

The object dictionary of an axis, as `vdrive dictionary` prints it. Objects are defined in
`core/include/vdrive/dictionary/object_table.hpp`; `tests/documents/object_page.py` writes this page.

- *stored*: `vdrive store` keeps the value. *effective*: when an accepted write takes effect in the drive.
- *origin*: `manual` is the manual of the profile position mode, `companion` an object that vdrive adds.

| object | variable name | type | access | range | default | unit | stored | effective | origin |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
"""


DISTURBANCES = """
## Disturbances

The effects of the test-bench inputs on an axis, as `vdrive disturb --help` prints them. They are defined in
`clients/include/vdrive/client/disturbance.hpp`. 605Eh selects how the axis stops in a fault; the fault can be reset
once its input is 0.

| `vdrive disturb` | effect on the axis |
| --- | --- |
"""


def disturbances_of(help_text):
    """The rows of the kinds: each has a line with its name and one with its effect."""
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
    address = f"{int(row['index'], 16):04X}h:{row['subindex']:02X}"
    return (f"| {address} | `{row['variable_name'] if 'variable_name' in row else row['name']}` | "
            f"{row['type']} | {row['access']} | {row['lower_limit']} to {row['upper_limit']} | "
            f"{row['default']} | {row['units']} | {'yes' if row['stored'] else ''} | "
            f"{row['effective']} | {row['origin']} |\n")


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
