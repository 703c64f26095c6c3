#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tables of the figures that the benchmarks print.

figures.py pairs FILE   lines of {"pair":1,"tree":"old","figure":...,"axes":...,"value":...}: for each
                        figure the medians of both trees, and the median, the least and the greatest
                        of the ratios new / old of the pairs
figures.py table FILE   lines of {"figure":...,"axes":...,"value":...}: one row for each figure; an "aim"
                        is shown next to the value
"""
import json
import statistics
import sys


def lines_of(file):
    with open(file, encoding="utf-8") as stream:
        return [json.loads(line) for line in stream if line.strip()]


def name_of(line):
    axes = line.get("axes")
    name = line["figure"] if axes is None else f'{line["figure"]} {axes}'
    conditions = [f"{key}={line[key]}" for key in ("over", "clients", "priority") if key in line]
    return " ".join([name, *conditions])


def number(value):
    return f"{value:.4g}"


def print_rows(rows):
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        cells = [row[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(row[1:], widths[1:])]
        print("  ".join(cells).rstrip())


def print_pairs(lines):
    values = {}
    for line in lines:
        pairs = values.setdefault(name_of(line), {})
        pairs.setdefault(line["pair"], {})[line["tree"]] = line["value"]
    rows = [("figure", "pairs", "old", "new", "new/old", "least", "greatest")]
    for name, pairs in values.items():
        both = [pair for pair in pairs.values() if "old" in pair and "new" in pair]
        if not both:
            rows.append((name, "0", "-", "-", "-", "-", "-"))
            continue
        ratios = [pair["new"] / pair["old"] for pair in both if pair["old"] != 0]
        medians = [statistics.median(pair[tree] for pair in both) for tree in ("old", "new")]
        spread = [statistics.median(ratios), min(ratios), max(ratios)] if ratios else []
        shown = [number(value) for value in spread] or ["-"] * 3
        rows.append((name, str(len(both)), *map(number, medians), *shown))
    print_rows(rows)


def print_table(lines):
    print_rows([("figure", "value", "aim")] +
               [(name_of(line), number(line["value"]), number(line["aim"]) if "aim" in line else "")
                for line in lines])


def main(arguments):
    shows = {"pairs": print_pairs, "table": print_table}
    if len(arguments) != 2 or arguments[0] not in shows:
        print(__doc__, file=sys.stderr)
        return 2
    shows[arguments[0]](lines_of(arguments[1]))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
