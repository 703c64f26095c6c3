#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Mutation check of core/: changes one operator, constant or table cell at a time and checks
whether the core's unit tests detect it.

    tests/mutation/run.py [--most N] [--seed N] [--jobs N] [--only TEXT] [--list]

    --most N     check at most N mutants, spread evenly by the seed (default: all)
    --only TEXT  only mutants whose "file:line" contains TEXT
    --list       print the mutants, check nothing

Prints one line per survivor and a summary; exit code 0 if every survivor is explained in
tests/mutation/survivors.txt (file, the line's text, the change, the reason; separated by " | ").
Works in build/mutation; needs the packages of deploy/setup.sh --tests.
"""
import argparse
import concurrent.futures
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import threading

ROOT = pathlib.Path(__file__).resolve().parents[2]
OUT = ROOT / "build" / "mutation"
FOLDERS = ["core/src/cia402", "core/src/motion", "core/src/dictionary"]
TABLE = "core/include/vdrive/dictionary/object_table.hpp"
FLAGS = ["-std=c++20", "-O1", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math",
         "-DVDRIVE_NO_TARGET_CLONES", "-DVDRIVE_ASSERTS", f"-DVDRIVE_SOURCE_DIR=\"{ROOT}\"",
         "-isystem", "/usr/include/eigen3"]
INCLUDES = [f"-I{ROOT}/core/include", f"-I{ROOT}/core/src", f"-I{ROOT}/tests"]
TIMEOUT_S = 60

# The replacements. Each rule is tried wherever its pattern occurs in code.
RULES = [
    (r"==", ["!="]), (r"!=", ["=="]), (r"(?<![<>=-])<=(?!>)", ["<"]), (r"(?<![<>=-])>=", [">"]),
    (r"(?<= )<(?= )", ["<=", ">"]), (r"(?<= )>(?= )", [">=", "<"]),
    (r"(?<= )\+(?= )", ["-"]), (r"(?<= )-(?= )", ["+"]),
    (r"(?<= )\*(?= )", ["/"]), (r"(?<= )/(?= )", ["*"]),
    (r"&&", ["||"]), (r"\|\|", ["&&"]), (r"(?<= )&(?= )", ["|"]), (r"(?<= )\|(?= )", ["&"]),
    (r"\btrue\b", ["false"]), (r"\bfalse\b", ["true"]),
    (r"\bstd::min\b", ["std::max"]), (r"\bstd::max\b", ["std::min"]),
    (r"(?<=[ (])!(?=[a-z(])", [""]), (r"(?<=[ (,])-(?=[a-z0-9])", [""]),
]
NUMBER = re.compile(r"(?<![\w.\"])(0x[0-9A-Fa-f]+|\d+\.\d+(?:e[+-]?\d+)?|\d+)(?![\w.]*\")(U?)\b")


def code_part(line):
    """The line without its comment and with strings blanked, so that positions stay the same."""
    line = re.sub(r'"(?:\\.|[^"\\])*"', lambda m: '"' + "\0" * (len(m.group()) - 2) + '"', line)
    line = re.sub(r"/\*.*?\*/", lambda m: "\0" * len(m.group()), line)
    return line.split("//")[0]


def other_numbers(text):
    if text.startswith("0x"):
        value = int(text, 16)
        return [f"0x{value ^ 1:0{len(text) - 2}X}"]
    if "." in text:
        return [repr(float(text) * 2.0 if float(text) else 1.0)]
    return [str(int(text) + 1)]


def mutants_of(path):
    lines = (ROOT / path).read_text(encoding="utf-8").split("\n")
    for number, line in enumerate(lines):
        code = code_part(line)
        if re.match(r"\s*(#|static_assert|using |namespace|template)", code):
            continue
        if path == TABLE and "DataType::" not in code and "{{0x" not in code:
            continue
        places = []
        for pattern, replacements in RULES:
            for found in re.finditer(pattern, code):
                places += [(found.start(), found.end(), new) for new in replacements]
        for found in NUMBER.finditer(code):
            places += [(found.start(1), found.end(1), new) for new in other_numbers(found.group(1))]
        for start, end, new in places:
            yield {"file": path, "line": number, "text": line.strip(),
                   "old": line[start:end], "new": new,
                   "source": line[:start] + new + line[end:]}


def all_mutants():
    result = []
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).glob("*.cpp")):
            result += mutants_of(str(path.relative_to(ROOT)))
    return result + list(mutants_of(TABLE))


def run(command, **options):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False, **options)


def compile_file(source, target, extra=()):
    return run(["g++", *FLAGS, *extra, *INCLUDES, "-c", str(source), "-o", str(target)])


class Workshop:
    """Objects of the core and of its tests, built once and linked with each change."""

    def __init__(self, jobs):
        OUT.mkdir(parents=True, exist_ok=True)
        self.core = sorted(str(p.relative_to(ROOT)) for p in (ROOT / "core/src").rglob("*.cpp"))
        self.tests = sorted(str(p.relative_to(ROOT)) for p in (ROOT / "tests/core").glob("*.cpp"))
        self.support = sorted(
            str(p.relative_to(ROOT)) for p in (ROOT / "tests/core/support").glob("*.cpp"))
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            failures = list(pool.map(self.build, self.core + self.tests + self.support))
        for failure in filter(None, failures):
            sys.exit(failure)

    @staticmethod
    def object_of(path):
        return OUT / (path.replace("/", "_") + ".o")

    def build(self, path):
        done = compile_file(ROOT / path, self.object_of(path))
        return done.stdout if done.returncode else None

    def programs(self, changed):
        """Test sources; those named after the changed file come first."""
        stem = pathlib.Path(changed).stem
        return sorted(self.tests, key=lambda t: (stem not in t, t))

    def link(self, test, target, replaced, first=()):
        objects = [str(replaced.get(p, self.object_of(p)))
                   for p in [test, *self.core, *self.support]]
        return run(["g++", *map(str, first), *objects, "-lgmock", "-lgtest", "-lgtest_main",
                    "-lrapidcheck", "-lpthread", "-o", str(target)])


def check(workshop, mutant, folder):
    """@return None if a test detected the mutant, otherwise why it survived."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = (ROOT / mutant["file"]).read_text(encoding="utf-8").split("\n")
    lines[mutant["line"]] = mutant["source"]
    replaced = {}
    recompiled = []
    tests = workshop.programs(mutant["file"])
    if mutant["file"] == TABLE:
        # An inline table: the linker keeps the first copy.
        overlay = folder / "include" / "vdrive" / "dictionary" / "object_table.hpp"
        overlay.parent.mkdir(parents=True, exist_ok=True)
        overlay.write_text("\n".join(lines), encoding="utf-8")
        # The sweep over both tables first: it detects nearly all mutants.
        tests = sorted((t for t in tests if "dictionary" in t), key=lambda t: "effect" in t)
        recompiled = ["core/src/dictionary/dictionary.cpp", *tests]
    else:
        source = folder / pathlib.Path(mutant["file"]).name
        source.write_text("\n".join(lines), encoding="utf-8")
        target = folder / "mutant.o"
        if compile_file(source, target).returncode:
            return None  # a change that does not compile is detected
        replaced[mutant["file"]] = target
    for test in tests:
        for path in {p for p in recompiled if p == test or p not in tests} - replaced.keys():
            target = folder / workshop.object_of(path).name
            if compile_file(ROOT / path, target, [f"-I{folder}/include"]).returncode:
                return None
            replaced[path] = target
        program = folder / "test"
        linked = workshop.link(test, program, replaced)
        if linked.returncode:
            return None
        try:
            done = run([str(program), "--gtest_brief=1", "--gtest_break_on_failure"],
                       timeout=TIMEOUT_S, cwd=folder)
        except subprocess.TimeoutExpired:
            return None
        if done.returncode:
            return None
    return "survives"


def explained():
    path = ROOT / "tests/mutation/survivors.txt"
    if not path.exists():
        return set()
    rows = [line.split(" | ") for line in path.read_text(encoding="utf-8").splitlines()
            if line and not line.startswith("#")]
    return {(row[0], row[1], row[2]) for row in rows if len(row) == 4}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--most", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--only", default="")
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    mutants = [m for m in all_mutants() if options.only in f"{m['file']}:{m['line'] + 1}"]
    if options.most and options.most < len(mutants):
        mutants = random.Random(options.seed).sample(mutants, options.most)
    if options.list:
        for m in mutants:
            print(f"{m['file']}:{m['line'] + 1}: {m['old']} -> {m['new'] or '(nothing)'}")
        return 0
    workshop = Workshop(options.jobs)
    known = explained()
    lock = threading.Lock()
    counts = {"killed": 0, "explained": 0, "unexplained": 0}
    local = threading.local()
    workers = iter(range(options.jobs))

    def work(mutant):
        if not hasattr(local, "folder"):
            with lock:
                local.folder = OUT / f"worker{next(workers)}"
        outcome = check(workshop, mutant, local.folder)
        change = f"{mutant['old']} -> {mutant['new'] or '(nothing)'}"
        with lock:
            if sum(counts.values()) % 50 == 49:
                print(f"{sum(counts.values()) + 1} of {len(mutants)} checked", file=sys.stderr)
            if outcome is None:
                counts["killed"] += 1
            elif (mutant["file"], mutant["text"], change) in known:
                counts["explained"] += 1
            else:
                counts["unexplained"] += 1
                print(f"{mutant['file']}:{mutant['line'] + 1}: {change} {outcome}: "
                      f"{mutant['text']}", flush=True)

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(work, mutants))
    for k in range(options.jobs):
        shutil.rmtree(OUT / f"worker{k}", ignore_errors=True)
    print(f"{len(mutants)} mutants: {counts['killed']} killed, {counts['explained']} explained, "
          f"{counts['unexplained']} unexplained")
    return 1 if counts["unexplained"] else 0


if __name__ == "__main__":
    sys.exit(main())
