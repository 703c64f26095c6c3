#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every field of every structure of the IDL as one row of a macro table, for C.

    generate_fields.py FILE.idl OUTPUT

A file that includes OUTPUT defines what a row does, and so handles every field without naming one.
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "idl/generator"))
import generate  # noqa: E402


def integer(kind):
    """@return "UNSIGNED" or "SIGNED" and the bits; nothing for another type."""
    name = kind.name
    if name not in generate.NUMBERS or name == "double":
        return None
    return ("UNSIGNED" if name.startswith("uint") else "SIGNED"), name.lstrip("uint")


def row(member):
    kind, number = member.type, integer(member.type)
    if kind.is_sequence and number:
        return f"SEQUENCE_OF_{number[0]}({member.name}, {number[1]}, {kind.bound})"
    if kind.is_sequence:
        return f"SEQUENCE({member.name}, {kind.name.rpartition('::')[2]}, {kind.bound})"
    if number:
        return f"{'KEY_' if member.is_key else ''}{number[0]}({member.name}, {number[1]})"
    if kind.name == "string":
        return f"STRING({member.name}, {kind.text_bound})"
    return {"double": "REAL", "boolean": "BOOLEAN"}[kind.name] + f"({member.name})"


def table(text):
    rows = []
    for item in generate.Parser(text).parse():
        if isinstance(item, generate.Struct):
            rows += [f"STRUCTURE({item.name})", *map(row, item.members), f"END({item.name})"]
    return "\n".join(rows) + "\n"


def main():
    idl, output = map(pathlib.Path, sys.argv[1:])
    output.write_text(table(idl.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
