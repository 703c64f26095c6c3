# SPDX-License-Identifier: Apache-2.0
"""Threads that share a session, observers that end each other, and the end of the interpreter."""
import itertools
import subprocess
import sys
import textwrap
import threading

import pytest
import vdrive

PATIENCE = 60


def run(program):
    """Run a Python program; return its exit code and output."""
    process = subprocess.Popen([sys.executable, "-X", "faulthandler", "-c", textwrap.dedent(program)],
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        output, _ = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        pytest.fail("it did not end: " + process.communicate()[0])
    return process.returncode, output


@pytest.mark.parametrize("call", ["session.step()", "clock.now"])
def test_threads_that_use_a_closed_session_are_refused_each(call):
    assert run(f"""
        import sys, threading, vdrive
        sys.setswitchinterval(1e-6)
        with vdrive.Bench(1) as bench:
            session = bench.session()
            clock = vdrive.StepClock(session, [1])
            session.close()
            refused = []

            def use():
                for _ in range(20_000):
                    try:
                        {call}
                    except vdrive.Failed:
                        refused.append(1)

            threads = [threading.Thread(target=use) for _ in range(2)]
            for thread in threads: thread.start()
            for thread in threads: thread.join()
            print(len(refused))
        """) == (0, "40000\n")


# Calls that never end on their own; `tell` is called once they have begun.
CALLS = {
    "a condition": lambda session, axis, tell: axis.wait_until(lambda status: tell(), timeout=1e6),
    "a move": lambda session, axis, tell: (axis.enable(), tell(), axis.move_to(10**9, velocity=10, timeout=1e6)),
    "drive time": lambda session, axis, tell: (tell(), session.wait(1e6)),
    "a follower": lambda session, axis, tell: [tell() for _ in session.follow("1.1")],
    # The call outlasts other events, such as the acquisition in this tick or a late tick in real time.
    "an event": lambda session, axis, tell: (tell(), [session.events().next() for _ in itertools.count()]),
}


@pytest.mark.parametrize("clock", ["lockstep", "realtime"])
@pytest.mark.parametrize("name", CALLS)
def test_close_ends_the_calls_of_other_threads_and_gives_the_axes_back(name, clock):
    with vdrive.Bench(1, clock=clock) as bench, bench.session() as other:
        session = bench.session()
        axis = session.axis("1.1")
        axis.acquire()
        has_begun = threading.Event()
        errors = []

        def call():
            try:
                CALLS[name](session, axis, has_begun.set)
            except (vdrive.Failed, StopIteration) as error:
                errors.append(error)

        thread = threading.Thread(target=call)
        thread.start()
        assert has_begun.wait(PATIENCE)
        session.close()
        thread.join(PATIENCE)
        assert not thread.is_alive()
        assert errors or name == "a follower"
        # In real time, a status from before the end may still be in transit.
        other.axis("1.1").wait_until(lambda status: status.owner == 0, timeout=PATIENCE)


def test_close_in_a_condition_ends_the_wait_and_the_session(vdrive_bench):
    session = vdrive_bench.session()
    axis = session.axis("1.1")
    axis.enable()
    with pytest.raises(vdrive.Failed, match="interrupted"):
        axis.wait_until(lambda status: session.close())
    with vdrive_bench.session() as other:
        assert other.axis("1.1").status().owner == 0


def test_two_threads_count_the_samples_of_one_follower_together(vdrive_session):
    follower = vdrive_session.follow("1.1", count=2000)
    ticks = []
    threads = [threading.Thread(target=lambda: ticks.extend(sample.tick for sample in follower))
               for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
        assert not thread.is_alive()
    assert len(ticks) == len(set(ticks)) == 2000


def test_a_condition_may_return_whatever_is_true_or_not(vdrive_session):
    answers = iter(["", 0, [], "yes"])
    begin = vdrive_session.axis("1.1").status().tick
    assert vdrive_session.axis("1.1").wait_until(lambda status: next(answers)).tick == begin + 3


def test_an_observer_of_two_benches_may_close_itself_in_both_threads(vdrive_benches):
    first, _ = vdrive_benches(2, axes=1, clock="realtime")
    with first.session() as session:
        both = threading.Barrier(2)
        ended = threading.Semaphore(0)

        is_made = threading.Event()

        def close(observation):
            is_made.wait(PATIENCE)
            both.wait(PATIENCE)
            observer.close()
            ended.release()

        observer = session.on_status(close, ["1.1", "2.1"], period=0.01)
        is_made.set()
        for _ in range(2):
            assert ended.acquire(timeout=PATIENCE)


def test_observers_may_close_each_other(vdrive_benches):
    (bench,) = vdrive_benches(1, axes=1, clock="realtime")
    with bench.session() as session:
        both = threading.Barrier(2)
        observers = []
        ended = threading.Semaphore(0)

        def close(other):
            both.wait(PATIENCE)
            observers[other].close()
            ended.release()

        has_both = threading.Event()
        for other in (1, 0):
            observers.append(session.on_status(
                lambda observation, other=other: has_both.wait(PATIENCE) and close(other), "1.1", period=0.01))
        has_both.set()
        for _ in observers:
            assert ended.acquire(timeout=PATIENCE)


def test_a_function_that_is_none_leaves_the_observer_before_alone(vdrive_session):
    texts = []
    seen = threading.Event()
    with vdrive_session.on_event(lambda event: (texts.append(event.text), seen.set())):
        for watch in (vdrive_session.on_event, vdrive_session.watch_services, vdrive_session.on_status):
            with pytest.raises(TypeError, match="function = 5: must be callable"):
                watch(5)
        vdrive_session.axis("1.1").enable()
        assert seen.wait(PATIENCE)
    assert texts


def test_an_exception_of_any_kind_does_not_end_an_observer(vdrive_session, monkeypatch):
    monkeypatch.setattr(threading, "excepthook", lambda arguments: None)
    seen = threading.Semaphore(0)

    def leave(event):
        seen.release()
        raise SystemExit

    axis = vdrive_session.axis("1.1")
    with vdrive_session.on_event(leave):
        for change in (axis.enable, axis.disable):
            change()
            assert seen.acquire(timeout=PATIENCE)


# Calls of daemon threads at the end of the interpreter.
ENDS = {
    "a move": "axis.move_to(10**9, velocity=10, timeout=1e6)",
    "a condition": "axis.wait_until(lambda status: False, timeout=1e6)",
    "a condition with a call": "axis.wait_until(lambda status: bool(other.wait(0.001)) and False, timeout=1e6)",
    "an observer with a call": "session.on_event(lambda event: session.wait(1e6)); axis.disable(); session.wait(1e6)",
    "steps": "[session.step() for _ in iter(int, 1)]",
    "a follower": "[None for _ in session.follow('1.1')]",
    "a stream": "[None for _ in session.stream('1.1')]",
    "status": "[axis.status() for _ in iter(int, 1)]",
    "sessions": "[bench.session().close() for _ in iter(int, 1)]",
    "benches": "[vdrive.Bench(1).close() for _ in iter(int, 1)]",
    "observers": "[session.on_status(id, period=0.01).close() for _ in iter(int, 1)]",
    "a bank": "bank.step(2**60)",
    "banks": "[vdrive.AxisBank(10).step(5) for _ in iter(int, 1)]",
}


@pytest.mark.parametrize("clock", ["lockstep", "realtime"])
@pytest.mark.parametrize("name", ENDS)
def test_a_daemon_thread_in_a_call_does_not_disturb_the_end_of_the_interpreter(name, clock):
    if (name, clock) == ("steps", "realtime"):
        pytest.skip("there are no steps")
    assert run(f"""
        import atexit, threading, time
        begin = [0.0]
        # Registered first, it runs last. A callback that does not return takes 6 s.
        atexit.register(lambda: print("late") if time.monotonic() > begin[0] + 5 else None)
        import vdrive
        bench = vdrive.Bench(1, clock="{clock}")
        session, other = bench.session(), bench.session()
        axis = session.axis("1.1")
        axis.enable()
        bank = vdrive.AxisBank(64)
        has_begun = threading.Barrier(3)

        def call():
            has_begun.wait()
            try:
                {ENDS[name]}
            except (vdrive.Error, RuntimeError):
                pass  # two threads step one bench, or one bank

        for _ in range(2): threading.Thread(target=call, daemon=True).start()
        has_begun.wait()
        other.axis("1.1").status()
        begin[0] = time.monotonic()
        """) == (0, "")
