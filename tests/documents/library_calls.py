#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the DDS library's functions that idl/ calls with docs/explanation/library-calls.md.

    library_calls.py PAGE SOURCES ARCHIVE...

Imported functions are read from the archives with nm. Virtual ones are found in the sources, as calls
through pointers to objects of the library.
"""
import pathlib
import re
import subprocess
import sys

# Members and parameters in idl/ that point to objects of the library.
POINTERS = ("participant", "publisher", "subscriber", "publisher_", "subscriber_", "reader_", "writer_",
            "source", "low", "low_level_transport_", "channel")
CALL = re.compile(r"\b(" + "|".join(POINTERS) + r")\s*(?:->|\.)\s*(\w+)\(")
CALL_OF_BASE = re.compile(r"\b(ChainingTransport)::(\w+)\(")
# Functions of idl/ and of containers called through a name in POINTERS.
OWN_NAMES = {"entities", "begin", "end", "size", "lost", "matches", "wait_for_acknowledged"}


def rows_of(page):
    """The names in backquotes in the first column of every table."""
    names = set()
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith("| `"):
            names.update(re.findall(r"`([^`]+)`", line.split(" | ")[0]))
    return names


def short_name(symbol):
    """eprosima::fastdds::dds::DataWriter::write(void*) -> DataWriter::write"""
    name = symbol.replace("(void*)", "").replace("[abi:cxx11]", "")
    name = re.sub(r"operator\(\)", "operator", name)
    name = name.split("(")[0]
    if name.endswith("operator"):
        name += "()"
    return re.sub(r"^(eprosima::)?(fastdds|fastrtps)::((dds|rtps|xmlparser)::)?", "", name)


def imports_of(archives):
    """@return the undefined functions and constants of the library in the object files."""
    output = subprocess.run(["nm", "--demangle", "--undefined-only", *map(str, archives)], check=True,
                            capture_output=True, text=True).stdout
    found = set()
    for line in output.splitlines():
        symbol = line.strip().removeprefix("U ").strip()
        if symbol.startswith(("eprosima::", "MD5::")):
            found.add(short_name(symbol))
    return found


def calls_through_pointers(sources):
    """@return the names of the functions that the sources call through a pointer in POINTERS."""
    found = set()
    for file in sorted(pathlib.Path(sources).rglob("*.?pp")):
        text = re.sub(r"//[^\n]*", "", file.read_text(encoding="utf-8"))
        found.update(name for _, name in CALL.findall(text))
        found.update(name for _, name in CALL_OF_BASE.findall(text))
    return found - OWN_NAMES


def callbacks_in(sources):
    """@return the names of the functions by which the library calls idl/."""
    found = set()
    for file in sorted(pathlib.Path(sources).rglob("*.hpp")):
        found.update(re.findall(r"\b(on_\w+)\([^;{]*\boverride\s*[;{]", file.read_text(encoding="utf-8")))
    return found


def problems(rows, imported, called, callbacks):
    """@return a sentence for each name that is missing in the tables or in the code."""
    of_rows = {name.rpartition("::")[2]: name for name in rows}
    found = [f"{name} is called and has no row" for name in sorted(imported - rows)]
    found += [f"{name}() is called through a pointer and has no row"
              for name in sorted(called - of_rows.keys())]
    found += [f"{name}() is a callback and has no row" for name in sorted(callbacks - of_rows.keys())]
    used = called | callbacks
    found += [f"{name} has a row and is not called"
              for word, name in sorted(of_rows.items()) if name not in imported and word not in used]
    return found


def main():
    page, sources, archives = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3:]
    found = problems(rows_of(page), imports_of(archives), calls_through_pointers(sources),
                     callbacks_in(sources))
    for problem in found:
        print(f"{page.name}: {problem}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
