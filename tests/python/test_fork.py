# SPDX-License-Identifier: Apache-2.0
"""Forked processes whose parent has sessions, and the start methods of multiprocessing."""
import gc
import multiprocessing
import os
import select
import signal
import subprocess
import sys
import textwrap

import pytest
import vdrive

# Other programs use the bench of the test.
pytestmark = pytest.mark.vdrive(over="dds")

PATIENCE = 60


def status_of(child):
    """Wait for a child; return its exit code in subprocess's convention."""
    handle = os.pidfd_open(child)
    ended, _, _ = select.select([handle], [], [], PATIENCE)
    os.close(handle)
    if not ended:
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    assert ended, "the child did not end"
    return os.waitstatus_to_exitcode(status)


def run(program, **environment):
    """Run a Python program that has a bench and a session; return its output."""
    finished = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], timeout=2 * PATIENCE,
                              capture_output=True, text=True, env={**os.environ, **environment})
    assert finished.returncode == 0, finished.stderr
    return finished


# A busy machine may keep a master from sending for half a second, sometimes for two, and the master
# would lose its axes. A watchdog time of five seconds still shows whether it sends.
BENCH = "watchdog: {timeout_ms: 5000}\naxes: [{number: 1}]\n"


@pytest.fixture
def config(tmp_path):
    """The configuration file of a bench with a long watchdog time; the program defines its axes."""
    file = tmp_path / "bench.yaml"
    file.write_text(BENCH)
    return file


# The ways in which a program forks, with everything that a session offers, with and without
# threads.
PARENT = """
import os, sys, threading
import vdrive

with vdrive.Bench(2, over="{over}", clock="{clock}", config="{config}") as bench, bench.session() as session:
    axis = session.axis("1.1")
    axis.enable()
    stream, events = session.stream(), session.events()
    follower = session.follow(pace="observe")
    observer = session.on_status(lambda sample: None, period=0.001)
    group = vdrive.AxisGroup(session, ["1.1", "1.2"])
    motion = axis.start_move(1000)
    closed = bench.session()
    of_closed = closed.axis("1.2")
    closed.close()
    for round in range(3):
        child = os.fork()
        if child == 0:
            {child}
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)
    motion.wait()
    axis.move_to(2000)
    session.wait(5.5)  # longer than the watchdog waits for its master
    if axis.status().owner != session.id:
        sys.exit("\\n".join(f"{{event.tick}} {{event.text}}" for event in iter(lambda: events.next(0.1), None)))
    assert stream.next(60) is not None
    print("goes on", flush=True)
"""

ENDS = {
    "sys.exit": ("sys.exit(7)", 7),
    "os._exit": ("os._exit(7)", 7),
    "an exception": ("raise ValueError('of the child')", 1),
    "the end of the program": ("break", 0),
    "the collector": ("del axis, group, motion, stream, events, follower, observer, of_closed, closed;"
                      " import gc; gc.collect(); sys.exit(7)", 7),
    "closing": ("[each.close() for each in (stream, events, follower, observer, session, bench)];"
                " sys.exit(7)", 7),
}


# In real time, threads run at the fork: those of the parent's bench, or those of the DDS library.
# Over DDS, lock-step only adds one more way for the parent to wait, which one of ENDS covers.
# tests/run.sh --full runs all combinations.
FORMS = (("local", "lockstep"), ("local", "realtime"), ("dds", "realtime"))
FORKS = [(end, over, clock) for end in ENDS for over, clock in FORMS
         if clock == "lockstep" or end in ("sys.exit", "closing") or os.environ.get("VDRIVE_FULL") == "1"]
FORKS.append(("sys.exit", "dds", "lockstep"))


@pytest.mark.parametrize("name, over, clock", FORKS)
def test_a_forked_child_ends_as_it_wants_and_its_parent_goes_on(name, over, clock, config):
    end, code = ENDS[name]
    program = PARENT.format(child=end, over=over, clock=clock, config=config)
    if end == "break":  # the child leaves the loop, and with it the blocks of `with`
        program = program.replace("    motion.wait()", "    if child == 0: sys.exit(0)\n    motion.wait()")
    finished = run(program)
    assert finished.stdout == f"{code}\n" * 3 + "goes on\n", finished.stderr
    if end.startswith("raise"):
        assert finished.stderr.count("ValueError: of the child") == 3, finished.stderr
    else:
        assert finished.stderr == ""


def test_what_a_child_prints_before_its_end_arrives(config):
    finished = run(PARENT.format(child="print('of the child'); sys.exit(0)", over="local",
                                 clock="lockstep", config=config))
    assert finished.stdout.count("of the child\n") == 3


def in_a_child(work):
    """Fork, call `work` in the child, and return its result, a text."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.write(writer, str(work()).encode())
        finally:
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as file:
        text = file.read()
    assert status_of(child) == 0
    return text


@pytest.fixture
def inherited(vdrive_bench, vdrive_session):
    axis = vdrive_session.axis("1.1")
    clock = vdrive.StepClock(vdrive_session, [1])
    clock.step()
    axis.enable()
    group = vdrive.AxisGroup(vdrive_session, ["1.1", "1.2"])
    stream, events = vdrive_session.stream(), vdrive_session.events()
    return {
        "session": vdrive_session.find_benches,
        "search": lambda: vdrive_session.axis("1.1"),
        "axis": axis.status,
        "axis write": lambda: axis.write("profile_velocity", 1000),
        "move": lambda: axis.move_to(100),
        "motion": axis.start_move(10).wait,
        "group": group.status,
        "stream": lambda: next(stream),
        "arrays": stream.take,
        "file": stream.fileno,
        "events": lambda: next(events),
        "follower": lambda follower=vdrive_session.follow(): next(follower),
        "clock": clock.step,
        "time": lambda: clock.now,
        "bench": vdrive_bench.session,
        "a new session": lambda: vdrive.Session(domain=0),
    }


def test_a_child_gets_a_clear_error_from_all_that_it_inherited(inherited):
    def kinds():
        texts = []
        for name, call in inherited.items():
            try:
                call()
                texts.append(f"{name}: nothing")
            except vdrive.Forked as error:
                if "forked" not in str(error) or "spawn" not in str(error):
                    texts.append(f"{name}: {error}")
        return texts

    assert in_a_child(kinds) == "[]"
    inherited["axis"]()  # the parent's own call still works


@pytest.mark.vdrive(over="local")
def test_a_child_uses_up_no_request_number_of_its_parent(vdrive_session):
    axis = vdrive_session.axis("1.1")

    def close_all():
        vdrive_session.close()
        return vdrive_session.is_closed

    for count in range(5):
        assert in_a_child(close_all) == "True"
        axis.write("profile_velocity", 1000 + count)
        assert axis.read("profile_velocity") == 1000 + count


@pytest.mark.dds
def test_a_child_that_was_forked_before_the_first_session_has_its_own():
    finished = run("""
        import os, sys, vdrive
        bench = vdrive.Bench(2, over="dds")
        domain, children = bench.domain, []
        for axis in ("1.1", "1.2"):
            child = os.fork()
            if child == 0:
                with vdrive.Session(domain=domain, find_timeout=30) as session:
                    session.axis(axis).acquire()
                    os.write(1, b"True\\n" if session.axis(axis).status().owner == session.id else b"no\\n")
                sys.exit(3)
            children.append(child)
        for child in children:
            print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
        with bench.session() as session:
            assert session.step() > 0
        bench.close()
        """)
    assert sorted(finished.stdout.split()) == ["3", "3", "True", "True"] and finished.stderr == ""


def own_session(domain, answers):
    """Run in a process of multiprocessing."""
    with vdrive.Session(domain=domain, find_timeout=30) as session:
        answers.put(session.axis("1.1").status().id)


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_a_process_of_multiprocessing_has_its_own_session(method, vdrive_bench, vdrive_session):
    context = multiprocessing.get_context(method)
    answers = context.SimpleQueue()
    process = context.Process(target=own_session, args=(vdrive_bench.domain, answers))
    process.start()
    process.join(PATIENCE)
    assert process.exitcode == 0
    assert answers.get() == "1.1"
    assert vdrive_session.step() > 0


def use_inherited(session, answers):
    """Run in a forked process of multiprocessing."""
    for call in (session.step, lambda: vdrive.Session(domain=0)):
        try:
            call()
        except vdrive.Forked as error:
            answers.put(str(error))
    gc.collect()


def test_a_forked_process_of_multiprocessing_is_told_what_to_do(vdrive_session):
    context = multiprocessing.get_context("fork")
    answers = context.SimpleQueue()
    process = context.Process(target=use_inherited, args=(vdrive_session, answers))
    process.start()
    process.join(PATIENCE)
    assert process.exitcode == 0
    assert all("spawn" in answers.get() for _ in range(2))
    assert vdrive_session.step() > 0


def test_a_pool_of_forked_processes_computes_next_to_a_session(vdrive_session):
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map(abs, range(-4, 0)) == [4, 3, 2, 1]
    assert vdrive_session.step() > 0
