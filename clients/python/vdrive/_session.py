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

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any, Callable, Mapping, NoReturn, Sequence

    from ._arguments import KeepAliveSpec, NumberSpec, ObjectSpec, PaceSpec, UntilSpec
    from ._axis import AxesSpec, CommandSpec

_MOST_AXES = 256  # in one request
_SLICE = 100  # ticks after which a wait checks whether it was cancelled


def _script() -> bytes:
    """Return the name of the file that Python runs; empty if there is none, as with `python -c`.

    The session then uses the name of the interpreter.
    """
    # A program that embeds Python may have no arguments, and an argument may not be UTF-8.
    first = os.fsencode((getattr(sys, "argv", None) or [""])[0])
    return b"" if first.startswith(b"-") else os.path.basename(first)


class Session(Handle):
    """A program's presence on a DDS domain: finds benches, and reads, writes and commands their axes.

    It keeps the axes that it commands, and releases them when it is closed. `with` closes it. Several
    threads may call it; if several step the same bench, the steps run one after the other.
    """

    __slots__ = ()

    def __init__(self, *, domain: int | None = None, interfaces: Sequence[str] = (),
                 peers: Sequence[str] = (), discovery_servers: Sequence[str] = (),
                 security: str = "", bench: int | None = None,
                 keep_alive: KeepAliveSpec = "own_thread", find_timeout: float = 2.0,
                 silence: float = 1.5, patience: float = 10.0, local: Any = None,
                 service: Any = None, program: str = "") -> None:
        """Open the session.

        domain: 0 to 232, by default VDRIVE_DOMAIN, else 0. interfaces: own addresses or interfaces such as
        eth0, by default loopback only. peers: hosts, by address or name, searched in addition to
        multicast. discovery_servers: such as "10.0.0.9:11811", instead of both. security: directory with
        the material of the closed mode. bench: find only this one. keep_alive: "own_thread", or
        "user_frames": the session sends only what the program sends, so a program that hangs loses its
        axes. find_timeout, silence, patience: wall time in s. A call raises Lost when a service has been
        silent for `silence`; calls that follow a bench (wait, follow, stream, on_status) when it has been
        silent for `patience`. local, service: set by vdrive.Bench, for a bench in this process or over
        DDS, which lives at least until the session is closed; with `local`, the network options have no
        effect. program: the name that others see when the session owns an axis, by default that of the
        file that Python runs.
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
        """Wait until a bench is found. Return the benches by number; none after `find_timeout`."""
        return [bench_of(bench) for bench in self._handle.find_benches()]

    def present_benches(self) -> list[BenchInfo]:
        """Return the benches that are present now. Does not wait."""
        return [bench_of(bench) for bench in self._handle.present_benches()]

    def find_bench(self, number: int | None = None) -> BenchInfo:
        """Return the bench with this number; without a number, the only one that is present."""
        return bench_of(self._handle.find_bench(bench_number(number, "number")))

    def axis(self, text: str) -> Axis:
        """Return the axis with an address such as "1.2" or "1.lift", or with a name."""
        return Axis(self, self._axis_named(text))

    def _axis_named(self, name: str) -> Any:
        return self._handle.axis(text("text", name))

    def axes(self, bench: int | None = None) -> list[Axis]:
        """Return every axis of a bench, by number."""
        return [Axis(self, axis) for axis in self._handle.axes(bench_number(bench))]

    def _given(self, axes: AxesSpec) -> list[Any] | None:
        """Return the C++ axes that an argument names; None for all axes of the only bench."""
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
        """Return the axes that an argument names; None names all axes of the only bench."""
        given = self._given(axes)
        return self.axes() if given is None else [Axis(self, axis) for axis in given]

    def command_each(self, axes: AxesSpec, command: CommandSpec, *, timeout: float = 60.0,
                     until: UntilSpec = "done") -> list[Error | None]:
        """Send the same command to several axes.

        command: enable, disable, halt, resume, quick_stop, reset_fault or power_cycle. Returns, for
        each axis, None or the exception with the reason.
        """
        return self._handle.command_each(self._given(axes), text("command", command),
                                         *call_options(timeout, until))

    def quick_stop(self, bench: int | None = None, *, timeout: float = 60.0,
                   until: UntilSpec = "done") -> None:
        """Quick-stop every axis of a bench, whoever owns it, except those with a fault."""
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

        Does not wait for an answer: the status shows their effect, and events report refusals. They take
        effect in `tick` (0 = the next), up to 10 s ahead, the controlword (6040h) last. In addition to
        mode, target position and controlword, up to 8 objects per axis are possible. With
        `drops_waiting`, frames of the session that still wait for their tick are dropped first.
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
        """End the session as if its program had been killed.

        It sends nothing more and releases no axis, every call fails, and on a realtime bench the axes
        react as 6007h says. From any thread; close() frees what is left.
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
        """Wait for drive time, in s; in lock-step, step. Return the tick reached."""
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
        """Set drive time over wall time of a realtime bench, for all programs: 0 = pause, 0.1 to 100."""
        return self._handle.set_rate(bench_number(bench), real("rate", rate))

    def take_snapshot(self, *, bench: int | None = None) -> int:
        """Save the state of all axes of a bench whose time stands still. Return the number of the snapshot."""
        return self._handle.take_snapshot(bench_number(bench))

    def restore_snapshot(self, snapshot: int, *, bench: int | None = None) -> int:
        """Restore all axes to the state of a snapshot. Return the tick, whose number continues."""
        return self._handle.restore_snapshot(bench_number(bench), whole("snapshot", snapshot))

    def snapshots(self, *, bench: int | None = None) -> dict[int, int]:
        """Return the snapshots that a bench keeps: {number: tick}."""
        return self._handle.snapshots(bench_number(bench))

    def drop_snapshot(self, snapshot: int, *, bench: int | None = None) -> None:
        """Forget a snapshot."""
        self._handle.drop_snapshot(bench_number(bench), whole("snapshot", snapshot))

    def faults(self, *, bench: int | None = None) -> list[Fault]:
        """Return the last faults in the black box of a bench, which records even if nobody watches."""
        return [fault_of(each) for each in self._handle.windows(bench_number(bench))]

    def fault(self, number: int, axes: AxesSpec = None, *, bench: int | None = None) -> FaultWindow:
        """Return what axes did around a fault: each tick, every write, and what led to it.

        number: from faults() or freeze(). axes: of one bench; by default those that faulted, or else all,
        at most 256. Waits while the bench is still recording; if time stands still, the record ends now.
        Raises NotFound if the bench does not keep it, Refused if it has been dropped in the meantime.
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
        """Keep a window around now, as around a fault. Return its number, for fault()."""
        return self._handle.freeze_window(bench_number(bench))

    def observe(self, axes: AxesSpec = None) -> Observation:
        """Return the present state of axes of one bench; by default of all axes of the only bench."""
        return Observation(self._handle.observe(self._given(axes)))

    def follow(self, axes: AxesSpec = None, *, pace: PaceSpec = "drive", patience: float = 10.0,
               count: int | None = None) -> Follower:
        """Iterate over the ticks of axes of one bench.

        With pace "drive", each sample of a lock-step bench is a step of one tick; "observe" takes what is
        published. Raises TimedOut when no sample arrives for `patience` s of wall time.
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
        """Receive every published sample of axes of one bench in a separate thread.

        Keeps the newest `capacity`.
        """
        most = whole("capacity", capacity, 1)
        return StatusStream(self._handle.stream(self._given(axes), most), self)

    def events(self, *, history: bool = False, capacity: int = 10000) -> EventStream:
        """Return the events of the benches that this session finds.

        With `history`, starts with the oldest event that each bench still keeps. A second stream replaces
        the first.
        """
        return EventStream(self._handle.events(truth("history", history),
                                               whole("capacity", capacity, 1)), self)

    def events_async(self, *, history: bool = False, capacity: int = 10000) -> AsyncStream[Event]:
        """Follow the events of benches with `async for`; see events()."""
        return AsyncStream(self.events(history=history, capacity=capacity))

    def service_changes(self, *, capacity: int = 10000) -> ServiceStream:
        """Return a stream of the changes of the services that this session sees.

        A service is found, falls silent, sends again, restarts or goes offline. The services that are
        already there come first. A second stream replaces the first.
        """
        return ServiceStream(self._handle.service_changes(whole("capacity", capacity, 1)), self)

    def on_event(self, observer: Callable[[Event], object], *, history: bool = False) -> Observer:
        """Call `observer(event)` for each event, from now on; return the Observer.

        With `history`, starts with the oldest event that each bench still keeps; without it, reports only
        benches that the session has found. Replaces events() and the previous observer: a session has
        only one stream of events.
        """
        check_function(observer)  # before this replaces the present observer
        return Observer(observer, [self.events(history=history)])

    def watch_services(self, observer: Callable[[ServiceChange], object]) -> Observer:
        """Call `observer(change)` when a service is found, falls silent, restarts or goes offline.

        The services that are already there come first. Returns the Observer. Replaces service_changes()
        and the previous observer.
        """
        check_function(observer)
        return Observer(observer, [self.service_changes()])

    def on_status(self, observer: Callable[[Observation], object], axes: AxesSpec = None, *,
                  period: float = 0.1,
                  on_end: Callable[[Exception], object] | None = None) -> Observer:
        """Call `observer(observation)` with the newest state of axes; return the Observer.

        For each bench, the calls come at most once per `period` s of wall time, when a later tick has
        arrived. In lock-step the present state comes first, and nothing more while drive time stands
        still. The calls continue after a restart of the service. They end for a bench that has sent
        nothing for `patience` of the session: then `on_end(error)` is called, with Lost and the reason.
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
        """Record `ticks` samples of axes of one bench; return a Recording.

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

        Time stands still until `steppers` programs, including this one, have joined; 0 = as the bench is
        configured.
        """
        awaited = whole("steppers", steppers, 0, 2**32 - 1)
        numbers = row("benches", benches, lambda name, each: whole(name, each, 0, 2**32 - 1))
        super().__init__(_vdrive.StepClock(instance("session", session, Session)._handle, numbers,
                                           awaited))

    def step(self, ticks: int = 1, *, patience: float = 10.0) -> list[int]:
        """Step all benches and wait for them, at most for `patience` s of wall time. Return the tick of each."""
        return self._handle.step(whole("ticks", ticks), nanoseconds("patience", patience))

    def step_for(self, duration: float, *, patience: float = 10.0) -> list[int]:
        """Step by drive time in s, a multiple of the period of every bench."""
        return self._handle.step_for(nanoseconds("duration", duration),
                                     nanoseconds("patience", patience))

    @property
    def now(self) -> float:
        """Drive time that has passed on all benches under this clock, in s."""
        return self._handle.now()

    def close(self) -> None:
        """Leave the clock of each bench."""
        self._handle.close()

    def __enter__(self) -> StepClock:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
