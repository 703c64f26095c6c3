#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Executes the tutorial, command by command, and compares the output.

  tutorial_test.py TUTORIAL PROGRAMS

PROGRAMS is the directory with vdrived and vdrive. Every block of the tutorial that is tagged `sh` is
carried out by one bash, in an empty directory and on a DDS domain of its own. A block with lines that
begin with `$ ` has commands there and their output below; in any other block each line is a command.
In an expected output `...` stands for any text. A comment line before a block gives options:

  <!-- numbers may differ -->   decimal numbers of the output are not compared
  <!-- file: NAME -->           the block is not executed: it is the content of this file
  <!-- until Ctrl-C -->         the command is interrupted after its first line
  <!-- not executed: WHY --> the block is left out

Exit code 0: every output is as shown, and every other command succeeds.
"""
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from test_domain import claim_domain  # noqa: E402

BLOCK = re.compile(r"(?:^<!-- (?P<note>[^\n]*) -->\n)?^```(?P<tag>\w*)\n(?P<text>.*?)^```$",
                   re.DOTALL | re.MULTILINE)
END = "end-of-command"
PATIENCE_S = 120


def steps_of(text):
    """Returns commands with the output that is expected of them, None where none is shown."""
    lines = text.splitlines()
    if not any(line.startswith("$ ") for line in lines):
        return [(line, None) for line in lines if line.strip()]
    steps = []
    for line in lines:
        if line.startswith("$ "):
            steps.append((line[2:], []))
        else:
            steps[-1][1].append(line)
    return steps


def pattern_of(line, numbers_differ):
    text = re.escape(line.rstrip()).replace(r"\.\.\.", ".*")
    if numbers_differ:
        # Of a column the blanks before a number differ with it; a hexadecimal number stays.
        text = re.sub(r"(?:\\ )*(?<![\w.])-?\d+(?![\w.])", r"\\s*-?\\d+", text.replace(r"\-", "-"))
    return re.compile(text + r"\s*")


class Shell:
    """One bash that executes all commands."""

    def __init__(self, directory, environment):
        self.directory = directory
        self.environment = environment
        self.bash = subprocess.Popen(
            ["bash", "--noprofile", "--norc"], cwd=directory, env=environment, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            start_new_session=True)

    def run(self, command):
        """Returns the lines of the output and the exit code."""
        # The log of the service belongs to another terminal.
        started = re.sub(r"&\s*(#.*)?$", ">> service.log 2>&1 &", command)
        self.bash.stdin.write(f"{started}\necho {END} $?\n")
        self.bash.stdin.flush()
        lines = []
        for line in self.bash.stdout:
            if line.startswith(END):
                return lines, int(line.split()[1])
            lines.append(line.rstrip("\n"))
        raise SystemExit(f"the shell ended in: {command}")

    def interrupt(self, command):
        """Runs a command until its first line, then sends Ctrl-C. Returns whether it wrote one."""
        with subprocess.Popen(command.split(), cwd=self.directory, env=self.environment, text=True,
                              stdout=subprocess.PIPE) as program:
            line = program.stdout.readline()
            program.send_signal(signal.SIGINT)
            program.communicate()
        return bool(line.strip())

    def close(self):
        os.killpg(self.bash.pid, signal.SIGKILL)
        self.bash.wait()


def check_block(shell, note, text):
    """Returns the differences."""
    problems = []
    for command, expected in steps_of(text):
        if note == "until Ctrl-C":
            if not shell.interrupt(command):
                problems.append(f"$ {command}\n  writes nothing")
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


def main():
    tutorial, programs = sys.argv[1:]
    domain, claim = claim_domain()
    signal.alarm(PATIENCE_S)
    source = pathlib.Path(tutorial).read_text(encoding="utf-8")
    problems = []
    carried_out = 0
    with tempfile.TemporaryDirectory() as directory:
        path = f"{pathlib.Path(programs).resolve()}:{os.environ['PATH']}"
        environment = {**os.environ, "PATH": path, "HOME": directory, "VDRIVE_DOMAIN": str(domain)}
        shell = Shell(directory, environment)
        try:
            for block in BLOCK.finditer(source):
                note = block["note"] or ""
                if note.startswith("file: "):
                    (pathlib.Path(directory) / note[6:]).write_text(block["text"], encoding="utf-8")
                elif block["tag"] == "sh" and not note.startswith("not executed: "):
                    problems += check_block(shell, note, block["text"])
                    carried_out += 1
        finally:
            shell.run("kill $(jobs -p) 2> /dev/null; wait")
            shell.close()
    claim.close()
    for problem in problems:
        print(problem)
    return 1 if problems or carried_out < 8 else 0


if __name__ == "__main__":
    sys.exit(main())
