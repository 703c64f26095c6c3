#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The cost of `vdrive record run.mcap` while every axis of a bench moves in real time.

  record.py [--axes 1024] [--seconds 20] [--domain 47] [--build build/release]

Prints one JSON line for each figure: processor time of the recorder in cores, samples that it lost of
a million, and growth of its file in megabytes per second. Needs the targets vdrived and vdrive.
"""
import argparse
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

from hops import Hops, free_port

ROOT = pathlib.Path(__file__).resolve().parents[2]


def processor_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--axes", type=int, default=1024)
    parser.add_argument("--seconds", type=int, default=20)
    parser.add_argument("--domain", default="47")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    options = parser.parse_args()
    tool = [options.build / "bin/vdrive", "--domain", options.domain]
    running, metrics = [], free_port()
    with tempfile.TemporaryDirectory() as work:
        try:
            running.append(subprocess.Popen(
                [options.build / "bin/vdrived", "--domain", options.domain, "--axes",
                 str(options.axes), "--log-level", "error", "--metrics", str(metrics)]))
            subprocess.run([*tool, "--timeout", "20", "list"], check=True, capture_output=True)
            subprocess.run([*tool, "enable", "--all"], check=True, capture_output=True)
            # Each axis has a different speed and moves for longer than the measurement.
            moves = "".join(f"move 1.{axis} {1_000_000_000} --velocity {1000 + axis} --no-wait\n"
                            for axis in range(1, options.axes + 1))
            subprocess.run([*tool, "run", "-"], check=True, capture_output=True, text=True,
                           input=moves)
            file = pathlib.Path(work) / "run.mcap"
            recorder = subprocess.Popen([*tool, "--json", "record", file], text=True,
                                        stdout=subprocess.PIPE)
            running.append(recorder)
            while not (file.exists() and file.stat().st_size):
                time.sleep(0.1)
            time.sleep(2)
            hops = Hops(metrics)
            begin, spent, size = time.monotonic(), processor_seconds(recorder.pid), file.stat().st_size
            time.sleep(options.seconds)
            spent = processor_seconds(recorder.pid) - spent
            size = file.stat().st_size - size
            duration = time.monotonic() - begin
            hops = hops.so_far()
            recorder.send_signal(signal.SIGINT)
            output, _ = recorder.communicate(timeout=60)
        finally:
            for process in reversed(running):
                if process.poll() is None:
                    process.terminate()
                    process.wait(timeout=10)
    summary = json.loads(output)
    all_samples = summary["samples"] + summary["lost"]
    for figure, value in (("record_cores", spent / duration),
                          ("record_lost_per_million", 1e6 * summary["lost"] / all_samples),
                          ("record_mb_per_second", size / duration / 1e6)):
        print(json.dumps({"figure": figure, "axes": options.axes, "value": round(value, 4)}))
    print(json.dumps({"hops": hops, "lost": summary["lost"], "samples": summary["samples"]}), file=sys.stderr)


if __name__ == "__main__":
    main()
