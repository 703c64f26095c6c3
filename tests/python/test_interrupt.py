# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C, other signals, and processes that are killed."""
import asyncio
import collections
import contextlib
import os
import pathlib
import select
import signal
import subprocess
import sys
import textwrap
import threading

import pytest
import vdrive

PATIENCE = 60


def begin(program):
    """Start a Python program; return it once it waits."""
    process = subprocess.Popen([sys.executable, "-c", textwrap.dedent(program)],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    return process


def line_of(process, word):
    ready, _, _ = select.select([process.stdout], [], [], PATIENCE)
    assert ready, "it printed nothing"
    line = process.stdout.readline()
    assert line.startswith(word), line + process.stderr.read()
    return line.split()[1:]


def interrupt_until_it_ends(process):
    """Send Ctrl-C, repeatedly in case it arrives before the wait; return the output."""
    try:
        process.send_signal(signal.SIGINT)
        return process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        pytest.fail("it did not end: " + process.communicate()[1])


WAITS = {
    "a move": "axis.enable(); axis.move_to(10**9, timeout=1e6)",
    "a condition": "axis.wait_until(lambda status: False, timeout=1e6)",
    "drive time": "session.wait(1e6)",
    "a stream": "stream = session.stream(); [None for _ in stream]",
    "a queue": "session.events().next()",
    "a follower": "[None for _ in session.follow(pace='observe', patience=1e6)]",
    "a group": "group = vdrive.AxisGroup(session, ['1.1', '1.2']); group.enable_all();"
               " group.move_together([10**8, 10**8], timeout=1e6)",
    "a clock": "vdrive.StepClock(session, [1]).step(10**12, patience=1e6)",
    "finding": "vdrive.Session(domain=bench.domain, find_timeout=1e6, bench=9).find_bench()",
}


# Over DDS, the waits for a reply and for an announcement; with tests/run.sh --full also those for
# samples and for events.
INTERRUPTED = [(wait, "dds") for wait in ("a move", "finding")]
if os.environ.get("VDRIVE_FULL") == "1":
    INTERRUPTED += [("a stream", "dds"), ("a queue", "dds")]
INTERRUPTED += [(wait, "local") for wait in WAITS if wait != "finding"]


@pytest.mark.parametrize("name, over", INTERRUPTED)
def test_ctrl_c_ends_a_wait_and_the_session_continues(name, over):
    wait = WAITS[name]
    # numpy is imported first: a follower would import it when it starts, and an interrupt would then
    # become an ImportError.
    process = begin(f"""
        import numpy, threading, vdrive
        with vdrive.Bench(2, over="{over}") as bench, bench.session() as session:
            axis = session.axis("1.1")
            session.step()
            # From another thread: the wait below has begun by then, or begins with the signal.
            threading.Timer(0.3, lambda: print("waits", flush=True)).start()
            try:
                {wait}
            except KeyboardInterrupt:
                print("interrupted", session.observe().tick > 0, session.is_closed, flush=True)
        """)
    line_of(process, "waits")
    output, errors = interrupt_until_it_ends(process)
    assert output == "interrupted True False\n", errors
    assert process.returncode == 0


@pytest.mark.dds
def test_ctrl_c_ends_the_wait_for_another_stepper():
    process = begin("""
        import threading, vdrive
        with vdrive.Bench(1, over="dds") as bench:
            other, session = bench.session(), bench.session()
            slow, clock = vdrive.StepClock(other, [1]), vdrive.StepClock(session, [1])
            threading.Timer(0.3, lambda: print("waits", flush=True)).start()
            try:
                clock.step(5, patience=1e6)
            except KeyboardInterrupt:
                print("interrupted", flush=True)
        """)
    line_of(process, "waits")
    output, errors = interrupt_until_it_ends(process)
    assert output == "interrupted\n", errors


@pytest.mark.not_watched("no thread starts in a child that a process with threads has forked")
def test_ctrl_c_ends_a_wait_of_a_child_that_another_thread_forked():
    """The thread that forks becomes the main thread of the child, although it was not the
    parent's."""
    process = begin("""
        import os, signal, sys, threading, vdrive

        def child():
            # From another thread: the wait below has begun by then, or begins with the signal.
            threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
            with vdrive.Bench(1) as bench, bench.session() as session:
                try:
                    session.events().next()
                except KeyboardInterrupt:
                    print("interrupted", flush=True)

        def fork():
            session.step()  # a call of this thread, which is not the main thread yet
            number = os.fork()
            if number == 0:
                child()
                os._exit(0)
            os.waitpid(number, 0)

        with vdrive.Bench(1) as bench, bench.session() as session:
            session.step()
            thread = threading.Thread(target=fork)
            thread.start()
            thread.join()
        """)
    try:
        output, errors = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        for child in pathlib.Path(f"/proc/{process.pid}/task").glob("*/children"):
            for number in child.read_text().split():
                os.kill(int(number), signal.SIGKILL)
        process.kill()
        pytest.fail("it did not end: " + process.communicate()[1])
    assert output == "interrupted\n", errors


@pytest.mark.dds
def test_ctrl_c_ends_the_start_of_a_private_bench(tmp_path):
    # A service that starts but never becomes ready.
    service = tmp_path / "vdrived"
    service.write_text("#!/bin/sh\nexec sleep 1000\n")
    service.chmod(0o755)
    process = begin(f"""
        import threading, vdrive
        threading.Timer(0.3, lambda: print("waits", flush=True)).start()
        try:
            vdrive.Bench(over="dds", service={str(service)!r})
        except KeyboardInterrupt:
            print("interrupted", flush=True)
        """)
    line_of(process, "waits")
    output, errors = interrupt_until_it_ends(process)
    assert output == "interrupted\n", errors


@pytest.mark.dds
def test_a_service_that_does_not_start_reports_its_reason():
    with pytest.raises(vdrive.Failed, match="did not start.*--period: '0' must.*125 to 10000"):
        vdrive.Bench(over="dds", arguments=["--period", "0"])
    for service, reason in (("/nowhere/vdrived", "no such file"),
                            ("/etc/passwd", "not a program that can be executed"),
                            ("/bin/false", "ended with exit code 1 and wrote nothing")):
        with pytest.raises(vdrive.Error, match=f"did not start: {service}:? {reason}"):
            vdrive.Bench(over="dds", service=service)


class Alarm(Exception):
    pass


@contextlib.contextmanager
def handler_of_alarm(handler):
    before = signal.signal(signal.SIGALRM, handler)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@contextlib.contextmanager
def alarm_in(seconds):
    """A timer whose signal raises Alarm in the main thread; 0 only installs the handler."""
    def ring(number, frame):
        raise Alarm

    with handler_of_alarm(ring):
        signal.setitimer(signal.ITIMER_REAL, seconds)
        yield


def test_a_handler_that_raises_ends_a_wait_with_its_exception(vdrive_session):
    with alarm_in(0.2), pytest.raises(Alarm):
        vdrive_session.events().next()
    assert vdrive_session.step() > 0


def test_a_handler_that_returns_ends_the_wait_for_an_item_of_a_stream(vdrive_session):
    stream = vdrive_session.events()
    for wait in (lambda: stream.next(PATIENCE), lambda: next(stream)):
        with handler_of_alarm(lambda number, frame: None), pytest.raises(vdrive.Failed, match="interrupted"):
            signal.setitimer(signal.ITIMER_REAL, 0.1, 0.1)  # repeats, for a late wait
            wait()
    assert stream.next(0) is None


def test_signals_at_any_moment_leave_the_session_as_it_was(vdrive_session):
    """Signals may also arrive while a call begins or ends."""
    axis = vdrive_session.axis("1.1")
    stream = vdrive_session.events()
    delays = [20e-6 + 1e-6 * step for step in range(150)]
    with alarm_in(0.0):
        for call in (vdrive_session.step, axis.status, lambda: stream.next(0)):
            for delay in 4 * delays:
                with pytest.raises(Alarm):
                    signal.setitimer(signal.ITIMER_REAL, delay)
                    while True:
                        call()
                assert vdrive_session.step() > 0


def test_a_signal_in_a_callback_ends_the_wait_of_its_session_alone(vdrive_benches):
    first, second = vdrive_benches(2, axes=1)
    with first.session(bench=1) as outer, second.session(bench=2) as inner:
        def condition(status):
            signal.raise_signal(signal.SIGALRM)
            assert inner.step() > 0  # begins with the outer wait's signal pending
            return False

        with handler_of_alarm(lambda number, frame: None), pytest.raises(vdrive.Failed, match="interrupted"):
            outer.axis("1.1").wait_until(condition)
        assert outer.step() > 0 and inner.step() > 0


def test_the_loop_of_asyncio_has_the_signals_of_a_call_in_a_callback(vdrive_session):
    axis = vdrive_session.axis("1.1")

    async def run():
        rung = asyncio.Event()
        asyncio.get_running_loop().add_signal_handler(signal.SIGUSR1, rung.set)
        with contextlib.suppress(vdrive.Failed):
            axis.wait_until(lambda status: axis.wait_until(
                lambda again: signal.raise_signal(signal.SIGUSR1) or True).tick > 0)
        await asyncio.wait_for(rung.wait(), PATIENCE)

    asyncio.run(run())
    assert vdrive_session.step() > 0


def test_a_signal_of_a_forked_process_is_not_of_its_parent(vdrive_session):
    children = []

    def condition(status):
        if not children:
            children.append(os.fork())
            if children[0] == 0:
                signal.raise_signal(signal.SIGALRM)
                os._exit(0)
            os.waitpid(children[0], 0)
        return status.tick > 20

    with handler_of_alarm(lambda number, frame: None):
        assert vdrive_session.axis("1.1").wait_until(condition).tick > 20


@pytest.mark.vdrive(clock="realtime")
def test_a_signal_ends_the_wait_for_a_condition_that_is_slower_than_the_ticks(vdrive_bench, vdrive_session):
    other = vdrive_bench.session()
    calls = []

    def condition(status):
        other.wait(0.005)  # five ticks: from the second call on, a sample is always waiting
        calls.append(status.tick)
        if len(calls) == 3:
            signal.raise_signal(signal.SIGALRM)

    with handler_of_alarm(lambda number, frame: None), pytest.raises(vdrive.Failed, match="interrupted"):
        vdrive_session.axis("1.1").wait_until(condition, timeout=30.0)  # longer than three calls take


def test_an_interrupted_take_loses_no_sample_and_counts_each_once(vdrive_session):
    begin = vdrive_session.step()
    count = 300_000  # ticks of some microseconds each
    follower = vdrive_session.follow("1.1", count=count)
    with alarm_in(0.2), pytest.raises(Alarm):
        follower.take(2**60)
    ticks = follower.take(2)["tick"][:, 0].tolist()
    assert ticks == [begin + 1, begin + 2]
    ticks += follower.take(count)["tick"][:, 0].tolist()  # what else it had received
    assert len(ticks) < count
    while (more := follower.take(count)).size:
        ticks += more["tick"][:, 0].tolist()
    assert ticks == list(range(begin + 1, begin + count + 1))
    with pytest.raises(StopIteration):
        next(follower)


def test_what_an_interrupted_take_had_received_comes_first(vdrive_session):
    begin = vdrive_session.step()
    count = 300_000
    follower = vdrive_session.follow(["1.2", "1.1"], count=count)
    with alarm_in(0.2), pytest.raises(Alarm):
        follower.take(count)
    first = next(follower)
    assert first.tick == begin + 1 and [axis.id for axis in first.axes] == ["1.2", "1.1"]
    ticks = [observation.tick for observation in follower]
    assert ticks == list(range(begin + 2, begin + count + 1))


def test_a_signal_ends_a_loop_over_a_follower_that_runs_no_python(vdrive_session):
    with alarm_in(0.1), pytest.raises(Alarm):
        collections.deque(vdrive_session.follow("1.1"), maxlen=0)


@pytest.mark.not_watched("no signal reaches a thread that waits for a mutex")
def test_a_signal_ends_the_wait_for_a_follower_that_another_thread_uses(vdrive_session):
    follower = vdrive_session.follow("1.1", pace="observe", patience=PATIENCE)
    failures = []

    def wait():
        try:
            next(follower)
        except vdrive.Failed as error:
            failures.append(str(error))

    thread = threading.Thread(target=wait)
    thread.start()
    with alarm_in(0.2), pytest.raises(Alarm):
        next(follower)
    vdrive_session.interrupt()  # the signal may have arrived before the wait
    thread.join(PATIENCE)
    assert ["interrupted" in failure for failure in failures] == [True]


def test_a_take_that_fails_at_once_needs_no_memory_for_its_count(vdrive_session):
    follower = vdrive_session.follow("1.1")
    vdrive_session.interrupt()
    with pytest.raises(vdrive.Failed):
        follower.take(2**60)
    vdrive_session.end_interrupt()
    assert follower.take(1).shape == (1, 1)


def test_the_wakeup_file_of_a_loop_is_restored(vdrive_session):
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    before = signal.signal(signal.SIGUSR1, lambda number, frame: None)
    try:
        signal.set_wakeup_fd(writer)
        axis = vdrive_session.axis("1.1")
        axis.wait_until(lambda status: signal.raise_signal(signal.SIGUSR1) or True)
        assert signal.set_wakeup_fd(-1) == writer
        assert os.read(reader, 10) == bytes([signal.SIGUSR1])
    finally:
        signal.signal(signal.SIGUSR1, before)
        os.close(reader)
        os.close(writer)


def test_interrupt_ends_a_wait_of_another_thread(vdrive_session):
    errors = []
    vdrive_session.find_bench()

    def wait():
        try:
            vdrive_session.wait(1e6, bench=1)
        except vdrive.Error as error:
            errors.append(error)

    thread = threading.Thread(target=wait)
    thread.start()
    vdrive_session.interrupt()
    thread.join(PATIENCE)
    vdrive_session.end_interrupt()
    assert not thread.is_alive() and isinstance(errors[0], vdrive.Failed)
    assert vdrive_session.step(bench=1) > 0


def services_on(domain):
    """The running services with this domain in their command line."""
    found = []
    for command in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        try:
            line = command.read_bytes()
        except OSError:
            continue  # it has ended
        program = line.partition(b"\0")[0]
        if program.endswith(b"vdrived") and f"\0--domain\0{domain}\0".encode() in line:
            found.append(int(command.parent.name))
    return found


@pytest.mark.dds
def test_a_killed_program_leaves_no_service_behind():
    process = begin("""
        import threading, vdrive
        benches = []
        # A thread that starts a bench and ends is not its end.
        starter = threading.Thread(target=lambda: benches.append(vdrive.Bench(1, over="dds")))
        starter.start(); starter.join()
        with benches[0].session() as session:
            session.step()
            print("runs", benches[0].domain, flush=True)
            threading.Event().wait()
        """)
    domain = int(line_of(process, "runs")[0])
    services = services_on(domain)
    assert len(services) == 1
    handle = os.pidfd_open(services[0])
    process.kill()
    process.communicate()
    ended, _, _ = select.select([handle], [], [], PATIENCE)
    os.close(handle)
    assert ended, "the service still runs"


@pytest.mark.vdrive(over="dds")  # which the program can find
def test_a_program_that_ends_without_closing_releases_its_axes(vdrive_bench, vdrive_session):
    program = f"""
        import vdrive
        session = vdrive.Session(domain={vdrive_bench.domain}, find_timeout=30)
        axis = session.axis("1.1")
        axis.enable()
        stream, events, follower = session.stream(), session.events(), session.follow()
        """
    process = begin(program)
    _, errors = process.communicate(timeout=PATIENCE)
    assert (process.returncode, errors) == (0, "")
    status = vdrive_session.axis("1.1").status()
    assert status.is_enabled and status.owner == 0
