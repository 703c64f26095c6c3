#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The cost of the Python module against the C++ library, and in the process against DDS, in the same run.

  python_figures.py [--build build/release] [--rounds 9] [--steps 2000] [--axes 256] [--seconds 20] [--runs 1]
                    [--only bank|steps|bench|fixture|stream ...]

Bank: ticks of 4,096 moving axes of the drive alone, in C++ (axis_tick_ns of vdrive_core_benchmark) and from
Python in turn; in Python also with a read of every status, and a write to each axis.
Steps: rounds of one-tick steps of a private bench in lock-step, C++ and Python in turn; the medians of
the rounds and the median of the ratios of neighbours. Bench: 64 axes in motion, in the process and over
DDS in turn: a step, a step that shows all axes, and 10 s of drive time recorded; and a bench of two axes
that is made, read and ended. Fixture: what the fixture of pytest adds to a test, a bench of two axes and a
session on it, both forms in turn. Stream: every status of a bench in real time at 1 kHz, taken as numpy
arrays; samples that were lost on the way or dropped.

Prints one JSON line for each figure, as vdrive_local_benchmark does; other details go to standard error.
Needs the targets vdrived, vdrive_python, vdrive_core_benchmark and vdrive_step_benchmark.
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


def figure(name, axes, value, over=None, aim=None):
    line = {"figure": name, "over": over, "axes": axes, "value": round(value, 4), "aim": aim}
    print(json.dumps({key: value for key, value in line.items() if value is not None}), flush=True)


def figure_of_ratios(name, axes, ratios, aim, over=None):
    figure(name, axes, statistics.median(ratios), over, aim)
    print(name, [round(ratio, 2) for ratio in sorted(ratios)], file=sys.stderr)


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
        steps_in_python(session, options.steps)  # warm-up
        for _ in range(options.rounds):
            output = subprocess.run([program, str(bench.domain), str(options.steps)], check=True,
                                    capture_output=True, text=True).stdout
            in_cpp.append(float(output))
            in_python.append(steps_in_python(session, options.steps))
    ratios = [python / cpp for python, cpp in zip(in_python, in_cpp)]
    figure("cpp_step_us", 1, statistics.median(in_cpp), over="dds")
    figure("python_step_us", 1, statistics.median(in_python), over="dds")
    figure_of_ratios("python_step_ratio", 1, ratios, over="dds", aim=1.5)


BANK_AXES = 4096


def moving_bank(vdrive):
    """Return a bank with the moves of core_benchmark.cpp."""
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
    figure("cpp_bank_tick_us", BANK_AXES, in_cpp)
    figure("python_bank_tick_us", BANK_AXES, in_python)
    figure_of_ratios("python_bank_tick_ratio", BANK_AXES,
                     [python / cpp for cpp, python, _ in rounds], aim=1.2)
    figure("python_bank_tick_and_look_us", BANK_AXES, looking)
    figure("python_bank_write_us", BANK_AXES, median_us(write, 100))


BENCH_AXES = 64
RECORDED = 10_000  # ticks
FORMS = ("local", "dds")


def let_all_move(session):
    """Start the moves of local_benchmark.cpp."""
    for number, axis in enumerate(session.axes(), 1):
        axis.enable()
        speed, ramp = (20_000 + 100 * number, 409_600) if number % 2 == 0 else (100_000, 10 + number)
        axis.move_to(-2_000_000_000 if number % 3 == 0 else 2_000_000_000, velocity=speed,
                     acceleration=ramp, until="in_force")
    session.wait(1.0)  # until the speed of each is visible


def times_of(session, options):
    """Return the times of a step and of an observation in us, and of a recording in ms."""
    step_us = steps_in_python(session, options.steps)
    followed = session.follow()
    followed_us = median_us(followed.__next__, options.steps)
    followed.close()
    begin = time.perf_counter()
    recording = session.record(ticks=RECORDED)
    recorded_ms = 1000 * (time.perf_counter() - begin)
    if recording.frames.shape != (RECORDED, BENCH_AXES) or recording.missed:
        raise RuntimeError("a tick or an axis was not recorded")
    if not recording["velocity_demand_value"][-1].all():
        raise RuntimeError("an axis stopped moving")
    return step_us, followed_us, recorded_ms


def life_ms(vdrive, over):
    """Return how long it takes to make a bench of two axes, to read its first axis and to end it."""
    begin = time.perf_counter()
    with vdrive.Bench(2, over=over) as bench, bench.session() as session:
        session.axis("1.1").status()
    return 1000 * (time.perf_counter() - begin)


def measure_bench(vdrive, options):
    lives, rounds = {over: [] for over in FORMS}, {over: [] for over in FORMS}
    for _ in range(options.rounds):
        for over in FORMS:
            lives[over].append(life_ms(vdrive, over))
    with contextlib.ExitStack() as benches:
        sessions = {}
        for over in FORMS:
            bench = benches.enter_context(vdrive.Bench(BENCH_AXES, over=over))
            sessions[over] = benches.enter_context(bench.session())
            let_all_move(sessions[over])
        for _ in range(options.rounds):
            for over in FORMS:
                rounds[over].append(times_of(sessions[over], options))
    for over in FORMS:
        step, follow, record = (statistics.median(column) for column in zip(*rounds[over]))
        follow_aim, record_aim, life_aim = (12, 80, 3) if over == "local" else (None, None, None)
        figure("python_bench_step_us", BENCH_AXES, step, over)
        figure("python_bench_follow_us", BENCH_AXES, follow, over, follow_aim)
        figure("python_bench_record_10_s_ms", BENCH_AXES, record, over, record_aim)
        figure("python_bench_life_ms", 2, statistics.median(lives[over]), over, life_aim)


TESTS = """
import pytest

@pytest.mark.parametrize("number", range({count}))
def test_without(number):
    pass

@pytest.mark.parametrize("number", range({count}))
def test_with(vdrive_session, number):
    assert len(vdrive_session.axes()) == 2
"""
TESTS_OF = {"local": 200, "dds": 10}


def run_pytest(options, file, test, over):
    """Return how long the run takes in ms."""
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--vdrive-over",
                    over, f"{file}::{test}"], check=True, cwd=file.parent, stdout=subprocess.DEVNULL,
                   env={**os.environ, "PYTHONPATH": str(options.build / "python")})
    return 1000 * (time.perf_counter() - begin)


def measure_fixture(options):
    times = {over: [] for over in FORMS}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(options.rounds):
            for over in FORMS:
                file = pathlib.Path(folder) / f"test_{over}.py"
                file.write_text(TESTS.format(count=TESTS_OF[over]), encoding="utf-8")
                without, used = (run_pytest(options, file, test, over)
                                 for test in ("test_without", "test_with"))
                times[over].append((used - without) / TESTS_OF[over])
    for over in FORMS:
        figure("pytest_fixture_ms", 2, statistics.median(times[over]), over,
               aim=10 if over == "local" else None)


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
                time.sleep(0.01)  # a program with other work, which takes ten samples at a time
            took = time.monotonic() - begin
            figure("python_stream_samples", options.axes, samples)
            figure("python_stream_lost", options.axes, missed, aim=0)
            figure("python_stream_dropped", options.axes, stream.dropped)
            figure("python_stream_cores", options.axes, (time.process_time() - busy) / took)
            print("python_stream", hops.so_far(), file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--axes", type=int, default=256)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--runs", type=int, default=1, help="of the stream")
    parts = ("bank", "steps", "bench", "fixture", "stream")
    parser.add_argument("--only", choices=parts, nargs="+", default=parts)
    options = parser.parse_args()
    options.build = options.build.resolve()
    sys.path.insert(0, str(options.build / "python"))
    os.environ.setdefault("VDRIVE_SERVICE", str(options.build / "bin/vdrived"))
    import vdrive

    if "bank" in options.only:
        measure_bank(vdrive, options)
    if "steps" in options.only:
        measure_steps(vdrive, options)
    if "bench" in options.only:
        measure_bench(vdrive, options)
    if "fixture" in options.only:
        measure_fixture(options)
    for _ in range(options.runs if "stream" in options.only else 0):
        measure_stream(vdrive, options)


if __name__ == "__main__":
    main()
