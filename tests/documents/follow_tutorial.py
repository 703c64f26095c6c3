#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Follows the README and then the tutorial, command by command, and compares the output.

  follow_tutorial.py TUTORIAL README PROGRAMS

PROGRAMS is the directory with vdrived and vdrive. A bash in an empty directory first runs the block
below "Twelve lines" of the README, then every block of the tutorial with the tag `sh`. In a block
with lines that begin with `$ `, these are commands, with their output below; in any other block
each line is a command, and a here-document belongs to its line. In an expected output `...` stands
for any text. A comment line before a block gives an option:

  <!-- numbers may differ -->   decimal numbers of the output are not compared

There are three differences from a reader's actions:
- Commands that begin with ./deploy/ are left out: they build the programs.
- The README is followed on a DDS domain of this test, and the number in the line
  `export VDRIVE_DOMAIN=...` of the tutorial is replaced, because tests run in parallel.
- The log of the README's service is written to a file.

Exit code 0: every output is as shown; every other command succeeds, except those in the README that
"end in fault"; the tutorial ends only jobs of its shell, by name; afterwards the service of the
README is running, and nothing else.
"""
import contextlib
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/support"))
from test_domain import claim_domain  # noqa: E402

BLOCK = re.compile(r"(?:^<!-- (?P<note>[^\n]*) -->\n)?^```(?P<tag>\w*)\n(?P<text>.*?)^```$",
                   re.DOTALL | re.MULTILINE)
README_SECTION = "## Twelve lines"
HERE_DOCUMENT = re.compile(r"<< ?'?(\w+)'?")
DOMAIN = re.compile(r"^(export VDRIVE_DOMAIN=)\d+", re.MULTILINE)
NUMBER = re.compile(r" *(?<![\w.])-?\d+(?:\.\d+)?(?![\w.])")
# A process number may have been reused by another process; the name of a job cannot.
ENDS_NO_JOB = re.compile(r"\b(?:pkill|killall)\b|\bkill\b(?! '%\w)")
END = "end-of-command"
PATIENCE_S = 170


def steps_of(text):
    """Returns commands with their expected output; None where none is shown."""
    shows_output = any(line.startswith("$ ") for line in text.splitlines())
    lines = iter(text.splitlines())
    steps = []
    for line in lines:
        if shows_output and not line.startswith("$ "):
            steps[-1][1].append(line)
            continue
        if not line.strip():
            continue
        command = line[2:] if shows_output else line
        document = HERE_DOCUMENT.search(command)
        while document and not command.endswith(f"\n{document[1]}"):
            rest = next(lines, None)
            if rest is None:
                raise SystemExit(f"a here-document has no end: {command}")
            command += f"\n{rest}"
        steps.append((command, [] if shows_output else None))
    return steps


def literal(text):
    return re.escape(text).replace(r"\.\.\.", ".*")


def pattern_of(line, numbers_differ):
    line = line.rstrip()
    if not numbers_differ:
        return re.compile(literal(line) + r"\s*")
    # The blanks before a number in a column vary with it; a hexadecimal number must be equal.
    texts = map(literal, NUMBER.split(line))
    return re.compile(r"\s*-?\d+(?:\.\d+)?".join(texts) + r"\s*")


def builds(command):
    return command.startswith("./deploy/")


def with_domain(tutorial, domain):
    moved, places = DOMAIN.subn(rf"\g<1>{domain}", tutorial)
    if places != 1:
        raise SystemExit(f"the tutorial sets VDRIVE_DOMAIN in {places} lines: must be one")
    return moved


class Shell:
    """One bash that executes all commands."""

    def __init__(self, directory, environment):
        self.bash = subprocess.Popen(
            ["bash", "--noprofile", "--norc"], cwd=directory, env=environment, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            start_new_session=True)

    def run(self, command):
        """Returns the lines of the output and the exit code."""
        self.bash.stdin.write(f"{command}\necho {END} $?\n")
        self.bash.stdin.flush()
        lines = []
        for line in self.bash.stdout:
            if line.startswith(END):
                return lines, int(line.split()[1])
            lines.append(line.rstrip("\n"))
        raise SystemExit(f"the shell ended in: {command}")

    def jobs(self):
        """Returns the numbers of the processes that run in the background."""
        return self.run("jobs -pr")[0]

    def close(self):
        os.killpg(self.bash.pid, signal.SIGKILL)
        self.bash.wait()
        self.bash.stdin.close()
        self.bash.stdout.close()


def follow_readme(shell, readme):
    """Returns what failed."""
    problems = []
    block = BLOCK.search(readme, readme.index(README_SECTION))
    for command, _ in steps_of(block["text"]):
        if builds(command):
            continue
        lines, code = shell.run(re.sub(r"^vdrived &", "vdrived > vdrived.log 2>&1 &", command))
        if (code != 0) != ("ends in fault" in command):
            problems.append(f"$ {command}\n  exit code {code}: " + "\n  ".join(lines))
    return problems


def follow_block(shell, note, text):
    """Returns the differences."""
    problems = []
    for command, expected in steps_of(text):
        if builds(command):
            continue
        if ENDS_NO_JOB.search(command):
            problems.append(f"$ {command}\n  ends what is no job of its shell: write kill '%NAME'")
            continue
        lines, code = shell.run(command)
        shown = expected or []
        is_failure = any(line.startswith("vdrive: ") for line in shown)
        if expected is not None:
            patterns = [pattern_of(line, note == "numbers may differ") for line in shown]
            is_same = len(lines) == len(patterns) and all(
                pattern.fullmatch(line) for pattern, line in zip(patterns, lines))
            if not is_same:
                problems.append(f"$ {command}\n  shown:  " + "\n          ".join(shown) +
                                "\n  actual: " + "\n          ".join(lines))
        if (code != 0) != is_failure:
            problems.append(f"$ {command}\n  exit code {code}: " + "\n  ".join(lines))
    return problems


def follow(shell, readme, tutorial):
    """Returns the mistakes in the two documents."""
    problems = follow_readme(shell, readme)
    service = shell.jobs()
    if len(service) != 1:
        problems.append(f"{len(service)} services run after the README: must be one")
    blocks = [block for block in BLOCK.finditer(tutorial) if block["tag"] == "sh"]
    if not blocks:
        problems.append("the tutorial has no command")
    for block in blocks:
        problems += follow_block(shell, block["note"], block["text"])
    left = shell.jobs()
    if left != service:
        problems.append(f"after the tutorial the processes {left} run: must be {service}, the "
                        "service of the README")
    shell.run("kill $(jobs -p); wait")
    return problems


@contextlib.contextmanager
def shell_in_tree(tree, programs, domain):
    """A bash in a directory that looks like a built `tree`, with the given programs."""
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        (directory / "build/release").mkdir(parents=True)
        (directory / "build/release/bin").symlink_to(pathlib.Path(programs).resolve())
        (directory / "clients").symlink_to(tree / "clients")
        shell = Shell(directory, {**os.environ, "HOME": name, "TMPDIR": name,
                                  "VDRIVE_DOMAIN": str(domain)})
        try:
            yield shell
        finally:
            shell.close()


def give_up(*_):
    raise SystemExit(f"README and tutorial take longer than {PATIENCE_S} s")


def main():
    tutorial, readme, programs = sys.argv[1:]
    signal.signal(signal.SIGALRM, give_up)
    signal.alarm(PATIENCE_S)
    domain_of_readme, claim = claim_domain()
    domain, second_claim = claim_domain()
    with claim, second_claim, shell_in_tree(ROOT, programs, domain_of_readme) as shell:
        problems = follow(shell, pathlib.Path(readme).read_text(encoding="utf-8"),
                          with_domain(pathlib.Path(tutorial).read_text(encoding="utf-8"), domain))
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
