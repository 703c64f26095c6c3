# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="no-any-return"
"""Axes that move together."""
from __future__ import annotations

from . import _vdrive
from ._arguments import (
    Handle,
    function,
    instance,
    nanoseconds,
    observes,
    optional_nanoseconds,
    real,
    row,
    shown,
    truth,
    whole,
    word,
)
from ._asynchronous import in_thread
from ._session import Session
from ._status import Status

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any, Callable, Literal

    from numpy import float64
    from numpy.typing import ArrayLike, NDArray

    from ._arguments import PaceSpec, UntilSpec
    from ._axis import AxesSpec

    StreamedSpec = Literal["positions", "velocities", "torques"]
    Progress = Callable[[int, float], object] | None


def _options(timeout: float | None, until: UntilSpec, progress: Progress) -> tuple[Any, ...]:
    return (optional_nanoseconds("timeout", timeout),
            word("until", until, "done", "in_force") == "in_force",
            progress if progress is None else function("progress", progress))


def _factor(name: str, value: float) -> float:
    factor = real(name, value)
    if 0.0 < factor <= 1.0:
        return factor
    raise ValueError(f"{name} = {shown(value)}: must be above 0 and at most 1")


def _factors(velocity: float, acceleration: float, deceleration: float) -> list[float]:
    return [_factor("velocity_factor", velocity), _factor("acceleration_factor", acceleration),
            _factor("deceleration_factor", deceleration)]


def _positions(name: str, numbers: Any) -> list[int]:
    """Return the positions or distances of a line, whole numbers as for a single axis."""
    return row(name, numbers, lambda place, each: whole(place, each, -2**31, 2**31 - 1, "UU"))


class GroupStatus(Handle):
    """All axes of a group after one tick."""

    __slots__ = ()

    @property
    def tick(self) -> int:
        """The tick of the bench of the first axis."""
        return self._handle.tick

    @property
    def state(self) -> Literal["disabled", "standby", "moving", "stopping", "error_stop"]:
        """"disabled", "standby", "moving", "stopping" or "error_stop"."""
        return self._handle.state()

    @property
    def queued(self) -> int:
        """Moves that have not started yet."""
        return self._handle.queued

    @property
    def axes(self) -> list[Status]:
        """Status of each axis."""
        return [Status(axis) for axis in self._handle.axes()]

    @property
    def demand(self) -> NDArray[float64]:
        """6062h of each axis (UU), as a numpy array."""
        return self._handle.demand()

    @property
    def actual(self) -> NDArray[float64]:
        """6064h of each axis (UU), as a numpy array."""
        return self._handle.actual()

    @property
    def not_following(self) -> list[str]:
        """In cyclic streaming: the axes whose demand is not the streamed position."""
        return self._handle.not_following()

    def __repr__(self) -> str:
        return f"<vdrive.GroupStatus tick {self.tick}, {self.state}>"


class AxisGroup(Handle):
    """Axes that move together, on one bench or on several that share a clock.

    If one fails, the others are stopped. Positions are numpy arrays in UU, in the order of the group.
    `timeout` is drive time in s: by default 60, for a move its duration plus 5.
    """

    __slots__ = ()

    def __init__(self, session: Session, axes: AxesSpec) -> None:
        """axes: addresses, names or axes, each once."""
        given = instance("session", session, Session)._given(axes)
        if given == []:
            raise ValueError(f"axes = {shown(axes)}: needs at least one axis")
        super().__init__(_vdrive.AxisGroup(session._handle, given))

    @property
    def axes(self) -> list[str]:
        """Addresses of the axes, in the order of the group."""
        return self._handle.axes()

    def __repr__(self) -> str:
        return f"<vdrive.AxisGroup of {len(self.axes)} axes>"

    def take_over(self) -> None:
        """Take control of every axis, if necessary from other sessions."""
        self._handle.take_over()

    def enable_all(self, *, timeout: float | None = None, until: UntilSpec = "done",
                   progress: Progress = None, keep_target: bool = False) -> None:
        """Bring every axis to Operation enabled, at rest, as Axis.enable() does."""
        self._handle.enable_all(*_options(timeout, until, progress),
                                truth("keep_target", keep_target))

    def disable_all(self, *, timeout: float | None = None, until: UntilSpec = "done",
                    progress: Progress = None) -> None:
        """Shut down every axis that has no fault. Drops the queue."""
        self._handle.disable_all(*_options(timeout, until, progress))

    def wait_all(self, *, timeout: float | None = None, until: UntilSpec = "done",
                 progress: Progress = None) -> None:
        """Wait until the present move and the queue have ended."""
        self._handle.wait_all(*_options(timeout, until, progress))

    async def wait_all_async(self, *, timeout: float | None = None) -> None:
        """Wait as wait_all() does. Cancelling the task halts the group, as halt_all() does."""
        await in_thread(lambda: self.wait_all(timeout=timeout),
                        lambda: self.halt_all(until="in_force"))

    def halt_all(self, *, timeout: float | None = None, until: UntilSpec = "done",
                 progress: Progress = None) -> None:
        """Brake to standstill; the move and the queue stay."""
        self._handle.halt_all(*_options(timeout, until, progress))

    def resume_all(self, *, timeout: float | None = None, until: UntilSpec = "done",
                   progress: Progress = None) -> None:
        """Continue a halted move."""
        self._handle.resume_all(*_options(timeout, until, progress))

    def quick_stop_all(self, *, timeout: float | None = None, until: UntilSpec = "done",
                       progress: Progress = None) -> None:
        """Quick-stop every axis that has no fault. Drops the queue."""
        self._handle.quick_stop_all(*_options(timeout, until, progress))

    def reset_all(self, *, timeout: float | None = None, until: UntilSpec = "done",
                  progress: Progress = None) -> None:
        """Reset the fault of every axis that has one."""
        self._handle.reset_all(*_options(timeout, until, progress))

    def move_together(self, targets: ArrayLike, *, velocity_factor: float = 1.0,
                      acceleration_factor: float = 1.0, deceleration_factor: float = 1.0,
                      timeout: float | None = None, until: UntilSpec = "done",
                      progress: Progress = None) -> None:
        """Move on a straight line to absolute positions (whole UU).

        All axes start on one tick and arrive on one tick. progress(tick, fraction) is called at every
        tick that the call observes.
        """
        self._handle.move_together(
            _positions("targets", targets),
            _factors(velocity_factor, acceleration_factor, deceleration_factor),
            *_options(timeout, until, progress))

    def move_by(self, displacements: ArrayLike, *, velocity_factor: float = 1.0,
                acceleration_factor: float = 1.0, deceleration_factor: float = 1.0,
                timeout: float | None = None, until: UntilSpec = "done",
                progress: Progress = None) -> None:
        """Move as move_together() does, but by displacements (whole UU) from the demand positions."""
        self._handle.move_by(
            _positions("displacements", displacements),
            _factors(velocity_factor, acceleration_factor, deceleration_factor),
            *_options(timeout, until, progress))

    def queue_move(self, targets: ArrayLike, *, velocity_factor: float = 1.0,
                   acceleration_factor: float = 1.0, deceleration_factor: float = 1.0) -> None:
        """Append a move_together() to the queue. wait_all() or poll() starts it."""
        self._handle.queue_move(
            _positions("targets", targets),
            _factors(velocity_factor, acceleration_factor, deceleration_factor))

    def status(self) -> GroupStatus:
        """Return the present state of all axes."""
        return GroupStatus(self._handle.status())

    def poll(self) -> GroupStatus:
        """Check the group once: stop the other axes if one has failed, start the next move."""
        return GroupStatus(self._handle.poll())

    def monitor(self, on: bool) -> None:
        """In real time, check for faults in a separate thread while no call waits."""
        self._handle.monitor(truth("on", on))

    def start_streaming(self, *, lead: float = 0.01, pace: PaceSpec = "drive",
                        what: StreamedSpec = "positions") -> None:
        """Start the cyclic synchronous mode of `what` on every axis, from rest.

        "positions" (UU), "velocities" (UU/s) or "torques" (per mille of rated). `lead`: in real time, how
        long before its tick each set-point is sent, in s.
        """
        self._handle.start_streaming(nanoseconds("lead", lead), observes(pace),
                                     word("what", what, "positions", "velocities", "torques"))

    def stream(self, set_points: ArrayLike) -> GroupStatus:
        """Send the set-points of the next tick, rounded to whole numbers. In lock-step, also step one tick."""
        return GroupStatus(self._handle.stream(row("set_points", set_points, real)))

    def stop_streaming(self, *, timeout: float | None = None, until: UntilSpec = "done",
                       progress: Progress = None) -> None:
        """Go back to profile position mode; the axes brake to rest."""
        self._handle.stop_streaming(*_options(timeout, until, progress))
