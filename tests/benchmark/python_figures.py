#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The cost of the Python module beside the C++ library, in the same run.

  python_figures.py [--build build/release] [--rounds 9] [--steps 2000] [--axes 256] [--seconds 20] [--runs 1]
                    [--only bank|steps|bench|stream]

Bank: ticks of 4,096 moving axes of the drive alone, in C++ (axis_tick_ns of vdrive_core_benchmark) and from
Python in turn; in Python also with a look at every status, and a write to each axis.
Steps: rounds of one-tick steps of a private bench in lock-step, C++ and Python in turn; the medians of
the rounds and the median of the ratios of neighbours. Bench: 64 axes in motion, in the process and over
DDS in turn: a step, a step that shows all axes, and 10 s of drive time recorded. Stream: every status of a bench in real time
at 1 kHz, taken as numpy arrays; samples that were lost on the way or dropped. One JSON line a
figure. Needs the targets vdrived, vdrive_python, vdrive_core_benchmark and vdrive_step_benchmark, and Debian's python3.
"""
import argparse
import contextlib
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

from hops import Hops, free_port

ROOT = pathlib.Path(__file__).resolve().parents[2]


def figure(name, **values):
    print(json.dumps({"figure": name, **values}), flush=True)


def steps_in_python(session, count):
    clock, step = time.perf_counter_ns, session.step
    times = []
    for _ in range(count):
        begin = clock()
        step(1, bench=1)
        times.append((clock() - begin) / 1000)
    return statistics.median(times)


def measure_steps(vdrive, options):
    program = options.build / "tests/benchmark/vdrive_step_benchmark"
    in_cpp, in_python = [], []
    with vdrive.Bench(1, over="dds") as bench, bench.session() as session:
        steps_in_python(session, options.steps)  # warm
        for _ in range(options.rounds):
            output = subprocess.run([program, str(bench.domain), str(options.steps)], check=True,
                                    capture_output=True, text=True).stdout
            in_cpp.append(float(output.split()[0]))
            in_python.append(steps_in_python(session, options.steps))
    ratios = [python / cpp for python, cpp in zip(in_python, in_cpp)]
    figure("python_step_us", cpp=round(statistics.median(in_cpp), 1),
           python=round(statistics.median(in_python), 1), ratio=round(statistics.median(ratios), 3),
           ratios=[round(ratio, 2) for ratio in sorted(ratios)])


BANK_AXES = 4096


def moving_bank(vdrive):
    """Return a bank on the moves of core_benchmark.cpp."""
    import numpy

    bank, axis = vdrive.AxisBank(BANK_AXES), numpy.arange(BANK_AXES)
    spread, cruises = axis % 97, axis % 2 == 0
    bank.write(None, 0x6060, 1)
    bank.write(None, 0x607A, numpy.where(axis % 3 == 0, -2_000_000_000, 2_000_000_000))
    bank.write(None, 0x6081, numpy.where(cruises, 20_000 + 100 * spread, 100_000))
    bank.write(None, 0x6083, numpy.where(cruises, 409_600, 40 + spread))
    bank.write(None, 0x6040, 0x0F)
    bank.write(None, 0x6040, 0x3F)
    bank.step(300)
    return bank


def tick_in_cpp(options):
    """Return the time of a tick in us."""
    program = options.build / "tests/benchmark/vdrive_core_benchmark"
    output = subprocess.run([program, f"--benchmark_filter=^axis_tick_ns/{BANK_AXES}/",
                             "--benchmark_min_time=0.02"], check=True, capture_output=True,
                            text=True).stdout
    return json.loads(output)["value"] * BANK_AXES / 1000


def median_us(call, count):
    clock, times = time.perf_counter_ns, []
    for _ in range(count):
        begin = clock()
        call()
        times.append((clock() - begin) / 1000)
    return statistics.median(times)


def measure_bank(vdrive, options):
    bank = moving_bank(vdrive)
    error, speed = bank.status["load_position_error_value"], bank.status["velocity_demand_value"]

    def step_and_look():
        bank.step()
        return abs(error).max()

    def write():
        bank.write(None, 0x6081, 100_000)

    rounds = [(tick_in_cpp(options), median_us(bank.step, 1000), median_us(step_and_look, 1000))
              for _ in range(options.rounds)]
    if not speed.all():
        raise RuntimeError("an axis stopped moving")
    in_cpp, in_python, looking = (statistics.median(column) for column in zip(*rounds))
    ratios = sorted(python / cpp for cpp, python, _ in rounds)
    figure("python_bank_tick_us", axes=BANK_AXES, cpp=round(in_cpp, 1), python=round(in_python, 1),
           ratio=round(statistics.median(ratios), 3), ratios=[round(ratio, 2) for ratio in ratios],
           looking=round(looking, 1), write=round(median_us(write, 100), 1))


BENCH_AXES = 64
RECORDED = 10_000  # ticks


def times_of(session, options):
    """Return the times of a step and of an observation in us, and of a recording in ms."""
    followed = session.follow()
    followed_us = median_us(followed.__next__, options.steps)
    followed.close()
    begin = time.perf_counter()
    recording = session.record(ticks=RECORDED)
    recorded_ms = 1000 * (time.perf_counter() - begin)
    if not recording["velocity"][-1].all():
        raise RuntimeError("an axis stopped moving")
    return steps_in_python(session, options.steps), followed_us, recorded_ms


def measure_bench(vdrive, options):
    program = options.build / "tests/benchmark/vdrive_step_benchmark"
    rounds = {"local": [], "dds": []}
    in_cpp = []
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as benches:
        # Without the watchdog the axes go on while a session that does not own them steps.
        config = pathlib.Path(folder) / "bench.yaml"
        config.write_text("watchdog: {timeout_ms: off}\n", encoding="utf-8")
        local, remote = (benches.enter_context(vdrive.Bench(BENCH_AXES, config=config, over=over))
                         for over in rounds)
        near, far = (benches.enter_context(bench.session()) for bench in (local, remote))
        for session in (near, far):
            for number, axis in enumerate(session.axes()):
                axis.enable()
                axis.move_to(1_000_000_000 + 1000 * number, velocity=40_000, until="in_force")
        for _ in range(options.rounds):
            for over, session in (("local", near), ("dds", far)):
                rounds[over].append(times_of(session, options))
            output = subprocess.run([program, str(remote.domain), str(options.steps)], check=True,
                                    capture_output=True, text=True).stdout
            in_cpp.append([float(line.split()[0]) for line in output.splitlines()])
    for over, times in rounds.items():
        step, follow, record = (statistics.median(column) for column in zip(*times))
        figure("python_bench", over=over, axes=BENCH_AXES, step_us=round(step, 2), follow_us=round(follow, 2),
               record_10s_ms=round(record, 1))
    bare, shown = (statistics.median(column) for column in zip(*in_cpp))
    figure("cpp_step_over_dds_us", axes=BENCH_AXES, bare=round(bare, 1), shown=round(shown, 1),
           difference=round(statistics.median(both[1] - both[0] for both in in_cpp), 1))


def measure_stream(vdrive, options):
    metrics = free_port()
    with vdrive.Bench(options.axes, clock="realtime", over="dds",
                      arguments=("--metrics", metrics)) as bench, \
            bench.session() as session:
        session.find_bench(1)
        with session.stream() as stream:
            stream.take(timeout=10)
            hops = Hops(metrics)
            busy, begin = time.process_time(), time.monotonic()
            samples = missed = highest = 0
            while time.monotonic() - begin < options.seconds:
                frames = stream.take(timeout=1)
                samples += len(frames)
                missed += int(frames["missed"][:, 0].sum())
                highest = max(highest, int(frames["load_position_actual_value"].max(initial=0)))
                time.sleep(0.01)  # a program that has other work: it takes ten samples at once
            took = time.monotonic() - begin
            figure("python_stream", axes=options.axes, seconds=round(took, 1), samples=samples,
                   lost=missed, dropped=stream.dropped, hops=hops.so_far(),
                   core_percent=round(100 * (time.process_time() - busy) / took, 1))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--axes", type=int, default=256)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--runs", type=int, default=1, help="of the stream")
    parser.add_argument("--only", choices=("bank", "steps", "bench", "stream"))
    options = parser.parse_args()
    sys.path.insert(0, str(options.build / "python"))
    os.environ.setdefault("VDRIVE_SERVICE", str(options.build / "bin/vdrived"))
    import vdrive

    if options.rounds and options.only in (None, "bank"):
        measure_bank(vdrive, options)
    if options.rounds and options.only in (None, "steps"):
        measure_steps(vdrive, options)
    if options.rounds and options.only in (None, "bench"):
        measure_bench(vdrive, options)
    for _ in range(options.runs if options.only in (None, "stream") else 0):
        measure_stream(vdrive, options)


if __name__ == "__main__":
    main()
