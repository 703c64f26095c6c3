# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="no-any-return"
"""A program's presence on a DDS domain, or on a bench in its process."""
from __future__ import annotations

import os
import sys

from . import _vdrive
from ._arguments import (
    MOST,
    Handle,
    bench_number,
    call_options,
    dictionary,
    instance,
    is_iterable,
    nanoseconds,
    object_number,
    observes,
    optional,
    real,
    row,
    shown,
    text,
    texts,
    truth,
    value_of_object,
    whole,
    word,
)
from ._asynchronous import in_thread
from ._axis import Axis
from ._errors import Error, NotFound
from ._faults import Fault, FaultWindow, Reported, Story, Write, fault_of
from ._observers import Observer, check_function
from ._recording import Recording
from ._streams import (
    AsyncStream,
    EventStream,
    Follower,
    Observation,
    ServiceStream,
    StatusReports,
    StatusStream,
)
from ._values import BenchInfo, Event, ServiceChange, bench_of

TYPE_CHECKING = False  # as typing.TYPE_CHECKING: reading that module takes time
if TYPE_CHECKING:
    from typing import Any, Callable, Mapping, NoReturn, Sequence

    from ._arguments import KeepAliveSpec, NumberSpec, ObjectSpec, PaceSpec, UntilSpec
    from ._axis import AxesSpec, CommandSpec

_MOST_AXES = 256  # most axes in one request
_SLICE = 100  # ticks after which a wait checks whether it was cancelled


def _script() -> bytes:
    """Return the name of the file that Python runs; empty where it runs none, such as `python -c`.

    Then the interpreter's own name says who it is.
    """
    # A program that embeds Python may have no arguments, and an argument may not be UTF-8.
    first = os.fsencode((getattr(sys, "argv", None) or [""])[0])
    return b"" if first.startswith(b"-") else os.path.basename(first)


class Session(Handle):
    """A program's presence on a DDS domain: finds benches, reads, writes, commands their axes.

    It keeps the axes that it commands, and releases them when it is closed. `with` closes it. Calls
    may come from several threads; those that step one bench from one at a time.
    """

    __slots__ = ()

    def __init__(self, *, domain: int | None = None, interfaces: Sequence[str] = (),
                 peers: Sequence[str] = (), discovery_servers: Sequence[str] = (),
                 security: str = "", bench: int | None = None,
                 keep_alive: KeepAliveSpec = "own_thread", find_timeout: float = 2.0,
                 silence: float = 1.5, patience: float = 10.0, local: Any = None,
                 service: Any = None, program: str = "") -> None:
        """Open the session.

        domain: 0 to 232, by default that of VDRIVE_DOMAIN, else 0. interfaces: own addresses
        or interfaces such as eth0, by default loopback only. peers: hosts, by address or name, searched
        in addition to multicast. discovery_servers: such as "10.0.0.9:11811", instead of both. security: directory of the closed mode's credentials. bench: find this
        one only. find_timeout, silence, patience: wall time in s. A call raises Lost when a service
        was silent for `silence`; what follows a bench (wait, follow, stream, on_status) when it was
        silent for `patience`. local: a bench of this process, of vdrive.Bench; then no option of the
        network counts. service: that of a vdrive.Bench over DDS. Both live at least until the session
        is closed. program: what others read of who controls an axis, by default the name of the file
        that Python runs.
        """
        super().__init__(_vdrive.Session(
            optional("domain", domain, 0, 2**32 - 1), texts("interfaces", interfaces),
            texts("peers", peers), texts("discovery_servers", discovery_servers),
            text("security", security), bench_number(bench),
            word("keep_alive", keep_alive, "own_thread", "user_frames") == "user_frames",
            nanoseconds("find_timeout", find_timeout), nanoseconds("silence", silence),
            nanoseconds("patience", patience), local and instance("local", local, _vdrive.LocalBench),
            service and instance("service", service, _vdrive.PrivateBench),
            text("program", program) or _script()))

    @property
    def id(self) -> int:
        """Number of the session: the owner that an axis shows while this session holds it."""
        return self._handle.id()

    @property
    def is_closed(self) -> bool:
        """Whether close() was called."""
        return self._handle.is_closed()

    def __repr__(self) -> str:
        return "<vdrive.Session, closed>" if self.is_closed else "<vdrive.Session>"

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def find_benches(self) -> list[BenchInfo]:
        """Wait until a bench is found; the benches by number, none after `find_timeout`."""
        return [bench_of(bench) for bench in self._handle.find_benches()]

    def present_benches(self) -> list[BenchInfo]:
        """Return the benches that are present now. Does not wait."""
        return [bench_of(bench) for bench in self._handle.present_benches()]

    def find_bench(self, number: int | None = None) -> BenchInfo:
        """Return the bench of that number; without a number the only present one."""
        return bench_of(self._handle.find_bench(bench_number(number, "number")))

    def axis(self, text: str) -> Axis:
        """Return the axis of an address such as "1.2" or "1.lift", or of a name."""
        return Axis(self, self._axis_named(text))

    def _axis_named(self, name: str) -> Any:
        return self._handle.axis(text("text", name))

    def axes(self, bench: int | None = None) -> list[Axis]:
        """Return every axis of a bench, by number."""
        return [Axis(self, axis) for axis in self._handle.axes(bench_number(bench))]

    def _given(self, axes: AxesSpec) -> list[Any] | None:
        """Return the C++ axes that an argument means; None: all of the only bench."""
        if axes is None:
            return None
        if isinstance(axes, (str, Axis)):
            return [self._given_one(axes)]
        if not is_iterable(axes):
            _refuse_axes(axes)
        return [self._given_one(axis) for axis in axes]

    def _given_one(self, axis: str | Axis) -> Any:
        if isinstance(axis, str):
            return self._axis_named(axis)
        if not isinstance(axis, Axis):
            _refuse_axes(axis)
        if axis._session is not self:
            raise ValueError(f"axis {axis.id} belongs to another session")
        return axis._handle

    def _axes_of(self, axes: AxesSpec) -> list[Axis]:
        """Return the axes that an argument means; None: all of the only bench."""
        given = self._given(axes)
        return self.axes() if given is None else [Axis(self, axis) for axis in given]

    def command_each(self, axes: AxesSpec, command: CommandSpec, *, timeout: float = 60.0,
                     until: UntilSpec = "done") -> list[Error | None]:
        """Send axes the same command.

        enable, disable, halt, resume, quick_stop, reset_fault or power_cycle. Returns for each axis
        None or the exception with the reason.
        """
        return self._handle.command_each(self._given(axes), text("command", command),
                                         *call_options(timeout, until))

    def quick_stop(self, bench: int | None = None, *, timeout: float = 60.0,
                   until: UntilSpec = "done") -> None:
        """Quick stop of every axis of a bench that has no fault, also of other sessions."""
        self._handle.quick_stop(bench_number(bench), *call_options(timeout, until))

    def release(self, bench: int | None = None) -> None:
        """Release all axes, or those of one bench. Their state does not change."""
        self._handle.release(bench_number(bench))

    def acquire(self, axes: AxesSpec = None) -> None:
        """Take control of axes of one bench: of all of them, or of none when one is refused."""
        self._handle.acquire(self._given(axes))

    def send_set_points(self, set_points: Mapping[int, Mapping[ObjectSpec, int]], *, tick: int = 0,
                        drops_waiting: bool = False, bench: int | None = None) -> None:
        """Send values of objects to axes that the session holds, by their numbers on the bench.

        It waits for no answer: the status and the events show what became of them. They are in force
        in `tick` (0 = the next), up to 10 s ahead; the controlword (6040h) acts last. Beside mode,
        target position and controlword an axis takes 8 objects. With `drops_waiting` the frames of the
        session that wait for their tick are dropped first.
        """
        points = []
        for axis, values in dictionary("set_points", set_points).items():
            number = whole("axis", axis, 0, 0xFFFF)
            objects = dictionary(f"set_points[{number}]", values, " of objects and their values")
            points.append((number, [(object_number(object), value_of_object(value))
                                    for object, value in objects.items()]))
        self._handle.send_set_points(points, whole("tick", tick),
                                     truth("drops_waiting", drops_waiting), bench_number(bench))

    def interrupt(self) -> None:
        """End all waiting calls, now and later, with Failed, until end_interrupt(). From any thread."""
        self._handle.interrupt()

    def end_interrupt(self) -> None:
        """Let calls from now on wait again."""
        self._handle.end_interrupt()

    def abandon(self) -> None:
        """End the session as a kill of its program would.

        It sends nothing any more and releases no axis, every call fails, and the axes on a bench in
        realtime react as 6007h says. From any thread; close() frees what is left.
        """
        self._handle.abandon()

    def close(self) -> None:
        """Release all axes and end the session."""
        self._handle.close()

    def step(self, ticks: NumberSpec = 1, *, bench: int | None = None) -> int:
        """Step a lock-step bench. Return the tick reached."""
        if type(ticks) is not int or not 0 <= ticks <= MOST:  # saves a call for an int
            ticks = whole("ticks", ticks)
        return self._handle.step(bench if bench is None else bench_number(bench), ticks)

    def wait(self, duration: float, *, bench: int | None = None) -> int:
        """Wait for drive time, in s; in lock-step by steps. Return the tick reached."""
        return self._handle.wait(bench_number(bench), nanoseconds("duration", duration))

    async def wait_async(self, duration: float, *, bench: int | None = None) -> int:
        """Wait for drive time, as wait() does. Cancelling the task stops no axis."""
        time = nanoseconds("duration", duration)
        is_cancelled: list[bool] = []

        def wait() -> int:
            there = self.find_bench(bench)
            now = self.wait(0.0, bench=there.number)
            end = now - -time // round(there.period * 1e9)
            while now < end and not is_cancelled:
                now = self.wait_for_tick(min(end, now + _SLICE), bench=there.number)
            return now

        return await in_thread(wait, lambda: is_cancelled.append(True))

    def wait_for_tick(self, tick: int, *, bench: int | None = None) -> int:
        """Wait until the bench has reached a tick; in lock-step step to it."""
        return self._handle.wait_for_tick(bench_number(bench), whole("tick", tick))

    def set_rate(self, rate: float, *, bench: int | None = None) -> int:
        """Drive time over wall time of a realtime bench, for all programs: 0 = pause, 0.1 to 100."""
        return self._handle.set_rate(bench_number(bench), real("rate", rate))

    def take_snapshot(self, *, bench: int | None = None) -> int:
        """Save the state of all axes of a bench whose time stands still. Return its number."""
        return self._handle.take_snapshot(bench_number(bench))

    def restore_snapshot(self, snapshot: int, *, bench: int | None = None) -> int:
        """Restore all axes to that state. Return the tick, which continues."""
        return self._handle.restore_snapshot(bench_number(bench), whole("snapshot", snapshot))

    def snapshots(self, *, bench: int | None = None) -> dict[int, int]:
        """Return the snapshots that a bench keeps: {number: tick}."""
        return self._handle.snapshots(bench_number(bench))

    def drop_snapshot(self, snapshot: int, *, bench: int | None = None) -> None:
        """Forget a snapshot."""
        self._handle.drop_snapshot(bench_number(bench), whole("snapshot", snapshot))

    def faults(self, *, bench: int | None = None) -> list[Fault]:
        """Return what the black box of a bench keeps: its last faults, whoever watched or nobody."""
        return [fault_of(each) for each in self._handle.windows(bench_number(bench))]

    def fault(self, number: int, axes: AxesSpec = None, *, bench: int | None = None) -> FaultWindow:
        """Return what axes did around a fault: each tick, every write, and what led to it.

        number: of faults() or freeze(). axes: of one bench; by default those that faulted, or else all,
        at most 256. It waits while the bench still records, and where time stands the record ends now. Raises
        NotFound when the bench does not keep it, Refused when it is gone in the meantime.
        """
        kept = next((each for each in self.faults(bench=bench) if each.number == number), None)
        if kept is None:
            raise NotFound(f"the bench keeps no fault {number}; faults() has those that it keeps")
        faulted = {cause.axis for cause in kept.causes} - {0}
        if axes is None:
            shown = [axis for axis in self.axes(kept.bench)
                     if not faulted or int(axis.id.partition(".")[2]) in faulted][:_MOST_AXES]
        else:
            shown = self._axes_of(axes)
            for axis in shown:
                if axis.id.partition(".")[0] != str(kept.bench):
                    raise ValueError(f"axis {axis.id} is not on bench {kept.bench}, whose fault is shown")
        record, frames, writes, events, stories = self._handle.window(
            whole("number", number, 1), [axis._handle for axis in shown])
        recording = Recording([axis.id for axis in shown], [axis.name for axis in shown], frames,
                              period=self.find_bench(kept.bench).period)
        return FaultWindow(fault_of(record), recording, [Write(*each) for each in writes],
                           [Reported(*each) for each in events], [Story(*each) for each in stories])

    def freeze(self, *, bench: int | None = None) -> int:
        """Keep what happens around now, as around a fault. Return its number, for fault()."""
        return self._handle.freeze_window(bench_number(bench))

    def observe(self, axes: AxesSpec = None) -> Observation:
        """Return the present state of some axes of one bench; without any, all of the only bench."""
        return Observation(self._handle.observe(self._given(axes)))

    def follow(self, axes: AxesSpec = None, *, pace: PaceSpec = "drive", patience: float = 10.0,
               count: int | None = None) -> Follower:
        """Iterate over the ticks of axes of one bench.

        With pace "drive" each sample of a lock-step bench is a step of one tick; "observe" takes what
        is published. It raises TimedOut when no sample comes for `patience` s of wall time.
        """
        options = observes(pace), nanoseconds("patience", patience), optional("count", count)
        return Follower(self._handle.follow(self._given(axes), *options))

    def follow_async(self, axes: AxesSpec = None, *,
                     capacity: int = 10000) -> AsyncStream[Observation]:
        """Follow the published status of axes of one bench with `async for`.

        Keeps the newest `capacity` samples. Never steps a lock-step bench.
        """
        return AsyncStream(self.stream(axes, capacity=capacity))

    def stream(self, axes: AxesSpec = None, *, capacity: int = 10000) -> StatusStream:
        """Receive every published sample of axes of one bench in a thread of its own.

        Keeps the newest `capacity`.
        """
        most = whole("capacity", capacity, 1)
        return StatusStream(self._handle.stream(self._given(axes), most), self)

    def events(self, *, history: bool = False, capacity: int = 10000) -> EventStream:
        """Return the events of the benches that this session finds.

        With `history` from the oldest on that each bench still has. A second stream takes the place of
        the first.
        """
        return EventStream(self._handle.events(truth("history", history),
                                               whole("capacity", capacity, 1)), self)

    def events_async(self, *, history: bool = False, capacity: int = 10000) -> AsyncStream[Event]:
        """Follow the events of benches with `async for`; see events()."""
        return AsyncStream(self.events(history=history, capacity=capacity))

    def service_changes(self, *, capacity: int = 10000) -> ServiceStream:
        """Return what happens to the services that this session sees.

        Found, silent, restarted, offline. First comes what is there. A second stream takes the place
        of the first.
        """
        return ServiceStream(self._handle.service_changes(whole("capacity", capacity, 1)), self)

    def on_event(self, observer: Callable[[Event], object], *, history: bool = False) -> Observer:
        """Call `observer(event)` for each event, from now on; return the Observer.

        With `history` from the oldest event on that each bench still has; without it, of benches that
        the session has found. It takes the place of events() and of the observer before: a session has
        one stream of events.
        """
        check_function(observer)  # before the present observer is replaced
        return Observer(observer, [self.events(history=history)])

    def watch_services(self, observer: Callable[[ServiceChange], object]) -> Observer:
        """Call `observer(change)` when a service is found, falls silent, restarts or goes offline.

        First for each service that is there. Returns the Observer. It takes the place of
        service_changes() and of the observer before.
        """
        check_function(observer)
        return Observer(observer, [self.service_changes()])

    def on_status(self, observer: Callable[[Observation], object], axes: AxesSpec = None, *,
                  period: float = 0.1,
                  on_end: Callable[[Exception], object] | None = None) -> Observer:
        """Call `observer(observation)` with the newest state of axes; return the Observer.

        For each bench at most once in `period` s of wall time, when a later tick has come. In lock-step
        the present state comes first; while drive time stands still nothing comes after it. A service
        that restarts is followed. The calls for a bench end when it has sent nothing for the `patience`
        of the session: then `on_end(error)` is called, with the Lost that says why.
        """
        check_function(observer)
        every = nanoseconds("period", period)
        if every == 0:
            raise ValueError("period = 0: must be above 0 seconds")
        benches: dict[int, list[Any]] = {}
        for axis in self._axes_of(axes):
            benches.setdefault(axis.bench, []).append(axis._handle)
        return Observer(observer, [
            StatusReports(self._handle.status_reports(each, every), self)
            for each in benches.values()], on_end)

    def record(self, axes: AxesSpec = None, *, ticks: NumberSpec,
               pace: PaceSpec = "drive") -> Recording:
        """Record that many samples of axes of one bench; return a Recording.

        With pace "drive" each sample of a lock-step bench is a step of one tick.
        """
        count = whole("ticks", ticks)
        handles = self._axes_of(axes)
        frames = self.follow(handles, pace=pace).take(count)
        period = self.find_bench(handles[0].bench).period
        return Recording([axis.id for axis in handles], [axis.name for axis in handles], frames,
                         period=period)


def _refuse_axes(axes: object) -> NoReturn:
    raise TypeError(f"axes = {shown(axes)}: must be an address, a name, an Axis, or a list of these")


class StepClock(Handle):
    """One clock for several lock-step benches, shared with other programs that step them.

    `with` leaves it.
    """

    __slots__ = ()

    def __init__(self, session: Session, benches: Sequence[int], *,
                 steppers: NumberSpec = 0) -> None:
        """Join the clock of each bench, by its number.

        Time stands until `steppers` programs, with this one, have joined it; 0 = as the bench is
        configured.
        """
        awaited = whole("steppers", steppers, 0, 2**32 - 1)
        numbers = row("benches", benches, lambda name, each: whole(name, each, 0, 2**32 - 1))
        super().__init__(_vdrive.StepClock(instance("session", session, Session)._handle, numbers,
                                           awaited))

    def step(self, ticks: int = 1, *, patience: float = 10.0) -> list[int]:
        """Step all benches and wait for them, `patience` s of wall time. Return the tick of each."""
        return self._handle.step(whole("ticks", ticks), nanoseconds("patience", patience))

    def step_for(self, duration: float, *, patience: float = 10.0) -> list[int]:
        """Step by drive time in s, a multiple of the period of every bench."""
        return self._handle.step_for(nanoseconds("duration", duration),
                                     nanoseconds("patience", patience))

    @property
    def now(self) -> float:
        """Drive time that this clock has advanced on all benches, in s."""
        return self._handle.now()

    def close(self) -> None:
        """Leave the clock of each bench."""
        self._handle.close()

    def __enter__(self) -> StepClock:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
