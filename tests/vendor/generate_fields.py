#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every field of every structure of the IDL as one row of a macro table.

    generate_fields.py FILE.idl OUTPUT

A file that includes OUTPUT defines what a row does, once for each language, and so handles every
field without naming one. Knows the subset of IDL that docs/reference/wire.md permits and refuses
the rest, so that nothing is left out without an error.
"""
import pathlib
import re
import sys

COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
CONSTANT = re.compile(r"const \w+ (\w+) = (\d+);")
STRUCTURE = re.compile(r"@final struct (\w+) \{(.*?)\};", re.DOTALL)
MEMBER = re.compile(r"\s*(@key\s+)?([\w<>, ]+?)\s+(\w+)$", re.DOTALL)
INTEGER = re.compile(r"(u?)int(8|16|32|64)")
STRING = re.compile(r"string<(\w+)>")
SEQUENCE = re.compile(r"sequence<(\w+), *(\w+)>")


def fail(what):
    sys.exit(f"generate_fields: {what}")


def number(text, constants):
    return text if text.isdigit() else constants.get(text) or fail(f"no constant {text}")


def row(structure, member, structures, constants):
    match = MEMBER.match(member)
    if not match:
        fail(f"{structure}: cannot read '{member.strip()}'")
    key, kind, name = match.groups()
    prefix = "KEY_" if key else ""
    if integer := INTEGER.fullmatch(kind):
        return f"{prefix}{'UNSIGNED' if integer[1] else 'SIGNED'}({name}, {integer[2]})"
    if key:
        fail(f"{structure}.{name}: a key is an integer")
    if kind == "double":
        return f"REAL({name})"
    if kind == "boolean":
        return f"BOOLEAN({name})"
    if string := STRING.fullmatch(kind):
        return f"STRING({name}, {number(string[1], constants)})"
    if sequence := SEQUENCE.fullmatch(kind):
        element, bound = sequence[1], number(sequence[2], constants)
        if integer := INTEGER.fullmatch(element):
            sign = "UNSIGNED" if integer[1] else "SIGNED"
            return f"SEQUENCE_OF_{sign}({name}, {integer[2]}, {bound})"
        if element in structures:
            return f"SEQUENCE({name}, {element}, {bound})"
    fail(f"{structure}.{name}: type '{kind}' is outside the subset that two vendors read alike")


def table(text):
    text = COMMENT.sub("", text)
    constants = dict(CONSTANT.findall(text))
    structures = STRUCTURE.findall(text)
    if not structures or len(structures) != len(re.findall(r"\bstruct\b", text)):
        fail("a structure that is not '@final struct Name { ... };'")
    lines = []
    known = set()  # a structure is declared before its use
    for name, body in structures:
        members = [member for member in body.split(";") if member.strip()]
        lines.append(f"STRUCTURE({name})")
        lines += [row(name, member, known, constants) for member in members]
        lines.append(f"END({name})")
        known.add(name)
    return "\n".join(lines) + "\n"


def main():
    idl, output = sys.argv[1:]
    rows = table(pathlib.Path(idl).read_text(encoding="utf-8"))
    pathlib.Path(output).write_text(rows, encoding="utf-8")


if __name__ == "__main__":
    main()
