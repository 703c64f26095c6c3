#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Independent judges of MCAP recordings.

  recording.py VDRIVED VDRIVE WORK [SEED]

A lock-step run is recorded as CSV and as MCAP. The reader of MCAP's authors and the decoder of
Foxglove (npm, versions fixed by the lock file) read every record, checksum and count; the values
must equal those of the CSV. They also read the file truncated at 200 places determined by SEED,
which is printed. This is done for a bench with one topic per axis, and for one with a topic for all
axes. WORK is a directory for the npm packages. Exit code 0: all agree; 77: a judge is missing (no
node, no registry).
"""
import csv
import json
import pathlib
import random
import signal
import subprocess
import sys

from gateway import Programs, fail, install

CUTS = 200
TICKS = 1500
TICKS_AT_ONCE = 20  # the status is best effort: a burst of hundreds loses samples


class Bench:
    """A bench in lock-step, and the tool."""

    def __init__(self, vdrived, vdrive, domain, axes, programs):
        # A busy machine may stop a process for seconds.
        self.command = [vdrive, "--domain", domain, "--timeout", "20"]
        self.programs = programs
        self.service = programs.start(vdrived, "--domain", domain, "--clock", "lockstep", "--axes",
                                      str(axes), "--log-level", "error")
        self.run("list")

    def run(self, *words):
        done = subprocess.run([*self.command, *words], capture_output=True, text=True, timeout=120)
        if done.returncode != 0:
            ended = self.service.poll()
            fail(f"{' '.join(words)}: {done.stderr.strip()}; the service "
                 f"{'is there' if ended is None else f'ended with {ended}'}")
        return done.stdout

    def record(self, file):
        file.unlink(missing_ok=True)
        return self.programs.start(*self.command, "--json", "record", file,
                                   stdout=subprocess.PIPE)


def record_run(bench, files):
    """Returns the summary of each recorder."""
    recorders = [bench.record(file) for file in files]
    # A recorder has written the beginning of its file once it receives the stream.
    while not all(file.exists() and file.stat().st_size for file in files):
        bench.run("step", "1")
    bench.run("enable", "1.1")
    bench.run("move", "1.1", "200", "--no-wait")
    for _ in range(TICKS // TICKS_AT_ONCE):
        bench.run("step", str(TICKS_AT_ONCE))
    summaries = []
    for recorder in recorders:
        recorder.send_signal(signal.SIGINT)
        output, _ = recorder.communicate(timeout=60)
        if recorder.returncode != 130:
            fail(f"a recorder ended with {recorder.returncode}")
        summaries.append(json.loads(output))
    return summaries


def rows_of(judged):
    """The decoded status by axis and tick, from messages of single axes or of all axes."""
    rows = {}
    for message in judged["rows"]:
        axes = message["axis"]
        if not isinstance(axes, list):
            rows[(axes, message["tick"])] = message
            continue
        for place, axis in enumerate(axes):
            rows[(axis, message["tick"])] = {
                name: value[place] if isinstance(value, list) else value
                for name, value in message.items()}
    return rows


def compare(recording, judged):
    """Compares every row of the CSV and every member that both have."""
    rows, common = rows_of(judged), 0
    for row in csv.DictReader(recording.open()):
        other = rows.get((int(row["axis"].split(".")[1]), row["tick"]))
        if other is None:
            continue  # lost by one of the two recorders, both of which count losses
        members = (set(row) & set(other)) - {"tick", "axis"}
        if len(members) < 20:
            fail(f"only {len(members)} members have common names")
        for member in members:
            if int(row[member]) != int(other[member]):
                fail(f"axis {row['axis']}, tick {row['tick']}, {member}: {row[member]} in the CSV, "
                     f"{other[member]} in the MCAP")
        if int(row["owner"] or "0", 16) != int(other["owner_session"]):
            fail(f"axis {row['axis']}, tick {row['tick']}: another owner")
        common += 1
    return common


def judge(vdrived, vdrive, domain, axes, work, seed):
    programs = Programs()
    try:
        bench = Bench(vdrived, vdrive, domain, axes, programs)
        recording, mcap = work / "run.csv", work / "run.mcap"
        _, summary = record_run(bench, [recording, mcap])
        read = subprocess.run(["node", work / "judge.mjs", mcap, str(CUTS), str(seed)],
                              capture_output=True, text=True, timeout=300)
        if read.returncode != 0:
            fail(read.stderr.strip())
        judged = json.loads(read.stdout)
        samples = len({(row["tick"]) for row in judged["rows"]})
        if samples != summary["samples"]:
            fail(f"{samples} samples were read, the recorder reports {summary['samples']}")
        if len(judged["events"]) != summary["events"]:
            fail(f"{len(judged['events'])} events were read, the recorder reports {summary['events']}")
        if len(judged["parameters"]) != axes:
            fail(f"{len(judged['parameters'])} sets of parameters were read, of {axes} axes")
        value = json.loads(bench.run("--json", "read", "1.1", "0x6502"))["value"]
        if judged["parameters"][0]["supported_drive_modes"] != value:
            fail("the parameters and `vdrive read` differ in 6502h")
        common = compare(recording, judged)
        if common < axes * TICKS * 9 // 10:
            fail(f"only {common} of {axes * TICKS} rows came both ways")
        print(f"{axes} axes: {judged['messages']} messages, {common} rows agree; of {CUTS} cuts the "
              f"longest has {judged['most']} messages")
    finally:
        programs.end()


def main():
    vdrived, vdrive, work = sys.argv[1:4]
    work = pathlib.Path(work)
    seed = int(sys.argv[4]) if len(sys.argv) > 4 else random.SystemRandom().randrange(1 << 31)
    install(work, "mcap")
    print(f"seed {seed}")
    judge(vdrived, vdrive, "45", 2, work, seed)
    judge(vdrived, vdrive, "46", 20, work, seed)


if __name__ == "__main__":
    main()
