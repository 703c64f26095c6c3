#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How long the judge of masters takes: for a journal of 64 axes, and for a running bench.

  judge.py BUILD [MINUTES]

BUILD is a directory of a build with Python. A bench in this process, in lock-step, records MINUTES of drive time
(default 60) in which each of 64 axes gets a new set-point every two seconds; `vdrive judge` reads the journal. Then
the same masters command a service in real time for 20 s while `vdrive judge --live` watches: its share of a core is
its processor time over that time.
"""
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

AXES = 64
ROUND = 2000  # [ticks]
LIVE = 20  # [s]


def enable(axes, session):
    for axis in axes:
        axis.write(0x6060, 1)
        axis.enable()


def command(axes, step, number):
    for axis in axes:
        axis.write(0x607A, 20_000 if number % 2 else -20_000)
        axis.write(0x6040, 0x1F)
    step()
    for axis in axes:
        axis.write(0x6040, 0x0F)


def record(vdrive, journal, minutes):
    with vdrive.Bench(axes=AXES, journal=journal) as bench, bench.session() as session:
        axes = session.axes()
        enable(axes, session)
        for number in range(minutes * 60 * 1000 // ROUND):
            command(axes, lambda: session.step(2), number)
            session.step(ROUND - 2)
        for axis in axes:
            axis.disable()


def processor_time():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def judge(tool, *words):
    before, start = processor_time(), time.monotonic()
    done = subprocess.run([tool, "judge", *map(str, words), "--json"], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        sys.exit(f"judge.py: {done.stderr}")
    return time.monotonic() - start, processor_time() - before, done.stdout.splitlines()


def live(vdrive, tool, service):
    with vdrive.Bench(axes=AXES, clock="realtime", over="dds", service=service) as bench, bench.session() as session:
        axes = session.axes()
        enable(axes, session)
        environment = {**os.environ, "VDRIVE_DOMAIN": str(bench.domain)}
        with tempfile.TemporaryFile() as report:
            watcher = subprocess.Popen([tool, "judge", "1", "--live", "--for", f"{LIVE}s", "--json"], env=environment,
                                       stdout=report, stderr=subprocess.DEVNULL)
            end, number = time.monotonic() + LIVE, 0
            while time.monotonic() < end:
                command(axes, lambda: time.sleep(0.01), number)
                time.sleep(ROUND / 1000)
                number += 1
            _, status, used = os.wait4(watcher.pid, 0)
        if os.waitstatus_to_exitcode(status) not in (0, 1):
            sys.exit("judge.py: the judge of the running bench failed")
        for axis in axes:
            axis.disable()
    return used.ru_utime + used.ru_stime


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    minutes = int(sys.argv[2]) if len(sys.argv) > 2 else 60
    sys.path.insert(0, str(build / "python"))
    import vdrive

    tool = build / "bin/vdrive"
    with tempfile.TemporaryDirectory() as directory:
        journal = pathlib.Path(directory, "bench.journal")
        record(vdrive, journal, minutes)
        wall, used, lines = judge(tool, journal)
        print(f"{minutes} min of {AXES} axes, {journal.stat().st_size / 1e6:.0f} MB: judged in {wall:.1f} s "
              f"({used:.1f} s of processor), {len(lines) - 1} findings")
        replay = subprocess.run([build / "bin/vdrived", "--replay", journal], capture_output=True, text=True,
                                check=True)
        print(replay.stdout.strip())
    used = live(vdrive, tool, build / "bin/vdrived")
    print(f"beside a bench that runs: {100 * used / LIVE:.1f} % of a core")


if __name__ == "__main__":
    main()
