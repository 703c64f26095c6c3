# SPDX-License-Identifier: Apache-2.0
"""A wire process that hangs and is replaced, a program that is stopped, a service that ends."""
import contextlib
import os
import pathlib
import select
import signal
import subprocess
import sys
import textwrap
import threading
import time

import pytest
import vdrive

# Other programs use the bench of the test.
pytestmark = pytest.mark.vdrive(over="dds")

PATIENCE = 60


def processes():
    """The parent process and command line of each process."""
    found = {}
    for directory in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            stat = (directory / "stat").read_text().rpartition(")")[2].split()
            found[int(directory.name)] = (int(stat[1]), (directory / "cmdline").read_bytes())
        except OSError:
            continue  # it has ended
    return found


def await_that(condition, what):
    """Wait for a true result of the condition, and return it."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        if result := condition():
            return result
        threading.Event().wait(0.01)
    raise AssertionError(what)


def find_wire(domain):
    """The wire is the child of the spawner, which is the child of the service with this domain.
    Command lines of further ancestors may contain any numbers."""
    known = processes()
    for pid, (spawner, command) in known.items():
        if b"--wire-process" not in command.split(b"\0") or spawner not in known:
            continue
        service = known[spawner][0]
        if service in known and f"--domain\0{domain}\0".encode() in known[service][1]:
            return pid
    return None


def wire_of(domain):
    """The wire process of the service on this domain. A new one starts some 20 ms after the last
    one ended."""
    return await_that(lambda: find_wire(domain), "the service has no wire process")


def is_stopped(process):
    states = [task.read_text().rpartition(")")[2].split()[0]
              for task in pathlib.Path(f"/proc/{process}/task").glob("*/stat")]
    return all(state == "T" for state in states)


def stop(process):
    """Stop a process and wait: a thread on another processor stops some time after the signal."""
    os.kill(process, signal.SIGSTOP)
    await_that(lambda: is_stopped(process), "the process does not stop")


@contextlib.contextmanager
def hung_wire(bench):
    """Stop the wire; some 2 s later the service kills and replaces it."""
    wire = wire_of(bench.domain)
    handle = os.pidfd_open(wire)
    stop(wire)
    yield
    ended, _, _ = select.select([handle], [], [], PATIENCE)
    os.close(handle)
    assert ended, "the wire was not replaced"


class Received:
    """Records the calls of an observer."""

    def __init__(self):
        self.items = []
        self._changed = threading.Condition()

    def __call__(self, item):
        with self._changed:
            self.items.append(item)
            self._changed.notify_all()

    def wait(self, condition):
        with self._changed:
            return self._changed.wait_for(lambda: any(map(condition, self.items)), PATIENCE)


@pytest.mark.vdrive(axes=1, clock="realtime")
def test_what_follows_a_bench_goes_on_when_its_wire_is_replaced(vdrive_bench, vdrive_session):
    axis = vdrive_session.axis("1.1")
    stream, follower = vdrive_session.stream(), vdrive_session.follow(pace="observe")
    received, ends, waited = Received(), Received(), Received()
    observer = vdrive_session.on_status(received, "1.1", period=0.01, on_end=ends)
    begin = next(follower).tick
    waiting = threading.Thread(target=lambda: waited(vdrive_session.wait(6.0)))
    waiting.start()
    with hung_wire(vdrive_bench):
        with pytest.raises(vdrive.Lost, match="limit is 1500 ms"):
            await_that(lambda: axis.status() is None, "a silent bench is not reported")
    gaps = {"stream": 0, "take": 0, "follow": 0}
    for sample in stream:
        gaps["stream"] += sample.missed
        if sample.tick > begin + 4000:
            break
    gaps["take"] = int(stream.take()["missed"].sum())
    for sample in follower:
        gaps["follow"] += sample.missed
        if sample.tick > begin + 4000:
            break
    # The hang lasts 2 s. The rest is the discovery of the next wire: on a busy machine up to the 10
    # s that streams wait.
    assert 1500 < gaps["stream"] < 10_000 and 1500 < gaps["follow"] < 10_000, gaps
    waiting.join(PATIENCE)
    assert waited.items and waited.items[0] >= begin + 6000
    assert received.wait(lambda sample: sample.tick > begin + 4000)
    assert (ends.items, observer.error) == ([], None)
    assert axis.status().tick > begin + 6000


@pytest.mark.vdrive(axes=1, arguments=["--wire", "process"])
def test_steps_of_a_follower_and_a_wait_survive_a_replaced_wire_in_lockstep(vdrive_bench,
                                                                             vdrive_session):
    follower = vdrive_session.follow()
    begin = next(follower).tick
    with hung_wire(vdrive_bench):
        assert next(follower).tick == begin + 1
    with hung_wire(vdrive_bench):
        assert vdrive_session.wait(0.1) == begin + 101


@pytest.mark.vdrive(axes=1, clock="realtime")
def test_the_end_of_a_bench_for_longer_than_the_patience_ends_what_follows_it(vdrive_bench):
    with vdrive_bench.session(silence=0.5, patience=2.0) as session:
        stream = session.stream()
        received, ends = Received(), Received()
        observer = session.on_status(received, "1.1", period=0.01, on_end=ends)
        assert received.wait(lambda sample: sample.tick > 0)
        follower = session.follow(pace="observe", patience=PATIENCE)
        next(follower)
        wire = wire_of(vdrive_bench.domain)
        service = processes()[processes()[wire][0]][0]
        spawner = processes()[wire][0]
        assert min(service, spawner) > 1, "0 would be every process of the group of this run"
        for process in (service, spawner, wire):  # nothing is left to replace the wire
            os.kill(process, signal.SIGSTOP)
        try:
            reason = "bench 1 stopped sending or ended: .* the limit is 2000 ms"
            with pytest.raises(vdrive.Lost, match=reason):
                for _ in stream:
                    pass
            with pytest.raises(vdrive.Lost, match=reason):
                stream.take()
            with pytest.raises(vdrive.Lost, match=reason):
                for _ in follower:
                    pass
            assert ends.wait(lambda error: isinstance(error, vdrive.Lost))
            assert observer.error is ends.items[0] and "stopped sending" in str(observer.error)
        finally:
            for process in (service, *[pid for pid, (parent, _) in processes().items()
                                       if parent == service], wire):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(process, signal.SIGCONT)


@pytest.mark.vdrive(axes=1, clock="realtime")
def test_an_end_that_nobody_asks_for_is_reported(vdrive_bench, monkeypatch):
    reported = Received()
    monkeypatch.setattr("threading.excepthook", lambda item: reported(item.exc_value))
    with vdrive_bench.session(patience=1.5) as session:
        received = Received()
        observer = session.on_status(received, "1.1", period=0.01)
        assert received.wait(lambda sample: sample.tick > 0)
        (vdrive_bench._local or vdrive_bench._private).close()
        assert reported.wait(lambda error: isinstance(error, vdrive.Lost))
        assert "went offline: its service has ended" in str(observer.error)


# The thread that runs first after the pause is random, so there are four programs with several
# waiting threads each.
STOPPED = """
import threading, vdrive
session = vdrive.Session(domain={domain}, find_timeout=30)
axis = session.axis("1.1")
errors, streams = [], [session.stream() for _ in range(3)]
observer = session.on_status(lambda sample: None, "1.1", period=0.01, on_end=errors.append)
begin = axis.status().tick

def guarded(work):
    def run():
        try:
            work()
        except Exception as error:
            errors.append(error)
    return threading.Thread(target=run)

def consume(stream):
    for sample in stream:
        if sample.tick > begin + 7000:
            return

def follow():
    for sample in session.follow(pace="observe"):
        if sample.tick > begin + 7000:
            return

threads = [guarded(lambda: session.wait(7.0)), guarded(follow)]
threads += [guarded(lambda stream=stream: consume(stream)) for stream in streams]
for thread in threads:
    thread.start()
print("runs", flush=True)
for thread in threads:
    thread.join()
print(errors, axis.status().tick > begin + 7000, flush=True)
"""


@pytest.mark.vdrive(axes=1, clock="realtime")
def test_a_program_that_was_stopped_for_4_seconds_goes_on(vdrive_bench):
    program = textwrap.dedent(STOPPED).format(domain=vdrive_bench.domain)
    clients = [subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
               for _ in range(4)]
    try:
        for client in clients:
            assert client.stdout.readline() == "runs\n"
        for client in clients:
            client.send_signal(signal.SIGSTOP)
        with vdrive_bench.session() as session:
            session.wait(4.0)
        for client in clients:
            client.send_signal(signal.SIGCONT)
        for client in clients:
            assert client.communicate(timeout=PATIENCE)[0] == "[] True\n"
    finally:
        for client in clients:
            client.kill()


# The first status received after the pause was sent during it, when the axis was already disabled.
# Receiving the status of a thousand axes takes a while, so at least one of several programs makes
# its call before it has that status.
HALTING = """
import sys, vdrive
session = vdrive.Session(domain={domain}, find_timeout=30)
axis = session.axis("1.1")
assert axis.status().state == "Switch on disabled"
print("runs", flush=True)
sys.stdin.readline()
try:
    axis.halt(until="in_force")
    print("halted", flush=True)
except vdrive.Error as error:
    print(error, flush=True)
"""


@pytest.mark.vdrive(axes=1000, clock="realtime")
def test_a_halt_is_not_refused_for_a_state_before_the_call(vdrive_bench, vdrive_session):
    axis = vdrive_session.axis("1.1")
    program = textwrap.dedent(HALTING).format(domain=vdrive_bench.domain)
    clients = [subprocess.Popen([sys.executable, "-c", program], stdin=subprocess.PIPE,
                                stdout=subprocess.PIPE, text=True) for _ in range(4)]
    try:
        for client in clients:
            assert client.stdout.readline() == "runs\n"
        for client in clients:
            stop(client.pid)
        vdrive_session.wait(0.4)
        axis.enable()
        for client in clients:
            client.stdin.write("halt\n")
            client.stdin.flush()
            client.send_signal(signal.SIGCONT)
        for client in clients:
            assert client.communicate(timeout=PATIENCE)[0] == "halted\n"
    finally:
        for client in clients:
            client.kill()
