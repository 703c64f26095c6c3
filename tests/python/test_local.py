# SPDX-License-Identifier: Apache-2.0
"""Benches in the process of their user."""
import gc
import os
import threading
import weakref

import pytest
import vdrive


def entries(directory):
    return len(os.listdir(directory))


def test_a_bench_in_lock_step_has_no_thread_and_no_file():
    with vdrive.Bench(axes=1) as bench, bench.session() as session:
        session.axis("1.1").enable()  # now Python has all that it needs for a wait
        threads, files = entries("/proc/self/task"), entries("/proc/self/fd")
        with vdrive.Bench(axes=1) as second, second.session() as other:
            axis = other.axis("1.1")
            axis.enable()
            axis.move_to(10000, velocity=20000)
            assert axis.status().position == 10000
            assert (entries("/proc/self/task"), entries("/proc/self/fd")) == (threads, files)


@pytest.mark.parametrize("clock", ["lockstep", "realtime", "freerun"])
def test_each_clock_mode_moves_an_axis(clock):
    with vdrive.Bench(axes=1, clock=clock) as bench, bench.session() as session:
        assert session.find_bench().clock_mode == clock
        axis = session.axis("1.1")
        # Time-outs count drive time; freerun runs a minute of it while a busy host runs other
        # programs.
        axis.enable(timeout=1e6)
        axis.move_to(1000, velocity=100000, timeout=1e6)
        assert axis.status().position == 1000


def test_what_belongs_to_dds_says_how_to_get_it():
    for options in ({"arguments": ["--period", "500"]}, {"service": "/usr/sbin/vdrived"},
                    {"domain": 20}):
        with pytest.raises(vdrive.ConfigurationError, match=r'over="dds"'):
            vdrive.Bench(**options)
    with vdrive.Bench() as bench, pytest.raises(vdrive.ConfigurationError, match=r'over="dds"'):
        print(bench.domain)


def test_a_bad_configuration_names_file_and_line(tmp_path):
    file = tmp_path / "bench.yaml"
    file.write_text("clock: {period_us: 1}\n")
    with pytest.raises(vdrive.ConfigurationError, match="bench.yaml:1.*period_us"):
        vdrive.Bench(config=file)
    file.write_text("metrics: {port: 9100}\n")
    with pytest.raises(vdrive.ConfigurationError, match="metrics.port"):
        vdrive.Bench(config=file)
    with pytest.raises(vdrive.ConfigurationError, match="16384"):
        vdrive.Bench(axes=20000)


def test_several_benches_are_found_by_one_session_and_step_together():
    with vdrive.Bench(axes=1) as first, vdrive.Bench(axes=1, number=2, beside=first) as second:
        with first.session() as session:
            assert [bench.number for bench in session.find_benches()] == [1, 2]
            clock = vdrive.StepClock(session, [1, 2])
            assert list(clock.step(10)) == [10, 10]
        with pytest.raises(vdrive.ConfigurationError, match="number = 2: bench 2 is already on this bus"):
            vdrive.Bench(number=2, beside=second)


def test_a_session_that_outlives_its_bench_is_lost():
    bench = vdrive.Bench(axes=1)
    with vdrive.Session(local=bench._local) as session:
        axis = session.axis("1.1")
        bench.close()
        for call in (axis.enable, axis.status, lambda: session.step(1, bench=1)):
            with pytest.raises(vdrive.Lost, match="went offline"):
                call()
    with pytest.raises(vdrive.Failed, match="ended"):
        bench.session()


def test_stored_parameters_and_a_journal_are_files(tmp_path):
    options = {"axes": 1, "state": tmp_path / "state", "journal": tmp_path / "run.journal"}
    with vdrive.Bench(**options) as bench, bench.session() as session:
        axis = session.axis("1.1")
        axis.write("profile_velocity", 12345)
        axis.store()
    assert (tmp_path / "run.journal").stat().st_size > 0
    with vdrive.Bench(axes=1, state=tmp_path / "state") as bench, bench.session() as session:
        assert session.axis("1.1").read("profile_velocity") == 12345


def test_threads_command_their_axes_side_by_side():
    with vdrive.Bench(axes=4) as bench, bench.session() as session:
        positions = {}

        def move(number):
            axis = session.axis(f"1.{number}")
            axis.enable()
            axis.move_to(1000 * number)
            positions[number] = axis.status().position

        threads = [threading.Thread(target=move, args=(number,)) for number in range(1, 5)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
        assert positions == {number: 1000 * number for number in range(1, 5)}


def test_a_journal_that_cannot_be_written_is_named(tmp_path):
    there = tmp_path / "there.journal"
    there.write_text("x")
    for file, reason in ((there, "is not empty"), (tmp_path / "no" / "run.journal", "cannot be written: No such file")):
        with pytest.raises(vdrive.ConfigurationError, match=f"^journal .*{file.name}: {reason}"):
            vdrive.Bench(over="local", journal=file)


# How to make each handle from a session, and to use it when nothing else references the session.
HANDLES = {
    "session": (lambda session: session, lambda session: session.step()),
    "axis": (lambda session: session.axis("1.1"), lambda axis: axis.status()),
    "follower": (lambda session: session.follow("1.1"), next),
    "clock": (lambda session: vdrive.StepClock(session, [1]), lambda clock: clock.step()),
    "group": (lambda session: vdrive.AxisGroup(session, ["1.1"]), lambda group: group.status()),
}


@pytest.mark.parametrize("name, over", [*((name, "local") for name in HANDLES), ("axis", "dds")])
def test_what_uses_a_session_keeps_its_bench(name, over):
    make, use = HANDLES[name]
    handle = make(vdrive.Bench(axes=1, over=over).session())
    gc.collect()
    assert use(handle) is not None


def test_a_stream_of_events_keeps_the_bench_of_its_session():
    session = vdrive.Bench(axes=1).session()
    axis, stream = session.axis("1.1"), session.events(history=False)
    del session
    gc.collect()
    axis.enable()
    assert stream.next(60.0).kind == "control_changed"


def test_a_bench_that_nobody_has_any_more_ends(tmp_path):
    """Deleting a bench frees its state directory, even if it holds its own session."""
    class Rig(vdrive.Bench):
        def __init__(self):
            super().__init__(axes=1, state=tmp_path)
            self.plant = self.session()

    for _ in range(3):
        rig = Rig()
        end = weakref.ref(rig)
        assert rig.plant.step() == 1
        del rig
        gc.collect()
        assert end() is None


def test_a_closed_session_keeps_no_bench(tmp_path):
    with vdrive.Bench(axes=1, state=tmp_path).session() as session:
        session.step()
    with vdrive.Bench(axes=1, state=tmp_path).session() as other:
        assert other.step() == 1
    assert session.is_closed


def test_a_bench_in_the_process_needs_no_domain(monkeypatch):
    for domain in ("abc", "", "999"):
        monkeypatch.setenv("VDRIVE_DOMAIN", domain)
        with vdrive.Bench(axes=1) as bench, bench.session() as session:
            assert session.step() == 1
    with pytest.raises((vdrive.Error, RuntimeError), match="VDRIVE_DOMAIN"):
        vdrive.Session()
