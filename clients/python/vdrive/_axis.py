# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="no-any-return"
"""One axis of a bench."""
from __future__ import annotations

from . import _vdrive
from ._arguments import (
    Handle,
    call_options,
    function,
    nanoseconds,
    object_number,
    optional,
    row,
    text,
    truth,
    value_of_object,
    whole,
)
from ._asynchronous import in_thread
from ._errors import Failed, Refused
from ._status import Status
from ._values import Unit, unit_of

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any, Callable, Generator, Iterable, Literal, Sequence

    from typing_extensions import TypeAlias

    from ._arguments import NumberSpec, ObjectSpec, UntilSpec
    from ._enums import DisturbanceSpec
    from ._errors import Error
    from ._session import Session

    AxesSpec: TypeAlias = "str | Axis | Sequence[str | Axis] | None"
    CommandSpec = Literal[
        "enable", "disable", "halt", "resume", "quick_stop", "reset_fault", "power_cycle"
    ]
    UnitSpec = tuple[str, float] | None  # the unit of the numbers in a call, and its size in UU

DISTURBANCES: tuple[str, ...] = tuple(_vdrive.DISTURBANCES)
"""The names of the disturbances that Axis.disturb() knows."""


def _int32(name: str, value: NumberSpec, unit: str, given: UnitSpec = None) -> int:
    return whole(name, value, -2**31, 2**31 - 1, unit, given)


def _per(given: UnitSpec, time: str) -> UnitSpec:
    return given and (given[0] + time, given[1])


def _velocity(value: NumberSpec, given: UnitSpec) -> int:
    return _int32("velocity", value, "UU/s", _per(given, " per s"))


def _speed(name: str, value: NumberSpec | None, given: UnitSpec) -> int | None:
    return optional(name, value, 0, 2**32 - 1, "UU/s", _per(given, " per s"))


def _ramp(name: str, value: NumberSpec | None, given: UnitSpec) -> int | None:
    return optional(name, value, 0, 2**32 - 1, "UU/s^2", _per(given, " per s^2"))


class Motion(Handle):
    """A move that was started."""

    __slots__ = ("_axis",)

    def __init__(self, axis: Axis, handle: Any) -> None:
        super().__init__(handle)
        self._axis = axis

    @property
    def axis(self) -> Axis:
        """The axis that moves."""
        return self._axis

    def wait(self, timeout: float = 60.0) -> None:
        """Wait until the axis is at its target, for at most `timeout` s of drive time."""
        self._handle.wait(nanoseconds("timeout", timeout))

    def has_ended(self) -> bool:
        """Whether the axis is at its target. Does not wait."""
        return self._handle.has_ended()

    async def wait_async(self, timeout: float = 60.0) -> None:
        """Wait as wait() does; `await motion` is the same. Cancelling the task halts the axis.

        It does not halt the axis if the motion has ended or was replaced by another one, or if another
        session has taken the axis. If halting fails, the task ends with that error.
        """
        def halt() -> None:
            try:
                if self.has_ended():
                    return
            except (Failed, Refused):
                return
            self.axis.halt(until="in_force")

        await in_thread(lambda: self.wait(timeout), halt)

    def __await__(self) -> Generator[Any, None, None]:
        """Wait as wait_async() does."""
        return self.wait_async().__await__()


class Axis(Handle):
    """One axis of a bench.

    A handle, returned by Session.axis(); several handles may refer to the same axis. Commands take
    control of the axis. `timeout` is drive time in s. A call returns when the command is "done", or,
    with `until` "in_force", as soon as the drive has acted on it.
    """

    __slots__ = ("_session",)

    def __init__(self, session: Session, handle: Any) -> None:
        super().__init__(handle)
        self._session = session

    @property
    def _place(self) -> tuple[int, int]:
        return self._handle.place()

    @property
    def id(self) -> str:
        """Address, such as "1.2"."""
        return "{}.{}".format(*self._place)

    @property
    def bench(self) -> int:
        """Number of the bench of the axis."""
        return self._place[0]

    @property
    def name(self) -> str:
        """Name of the axis."""
        return self._handle.name()

    @property
    def unit(self) -> Unit:
        """The physical unit of the user units of the axis."""
        return unit_of(self._handle.unit())

    def __eq__(self, other: object) -> bool:
        """Whether both handles belong to one session and refer to the same axis."""
        return (isinstance(other, Axis) and self._session is other._session
                and self._place == other._place)

    def __hash__(self) -> int:
        return hash(self._place)

    def __repr__(self) -> str:
        return f"<vdrive.Axis {self.id} {self.name}>"

    def acquire(self) -> None:
        """Take control. Refused while another session holds the axis."""
        self._handle.acquire()

    def take_over(self) -> None:
        """Take control, if necessary from another session, which loses it."""
        self._handle.take_over()

    def store(self) -> None:
        """Store the parameters (1010h); return when they are stored durably."""
        self._handle.store()

    def restore_defaults(self) -> None:
        """Discard the stored parameters (1011h): the configured ones are in force from the next power cycle."""
        self._handle.restore_defaults()

    def end_disturbances(self) -> None:
        """End every disturbance of the axis."""
        self._handle.end_disturbances()

    def enable(self, *, timeout: float = 60.0, until: UntilSpec = "done",
               keep_target: bool = False) -> None:
        """Go to Operation enabled and keep the axis at rest.

        60FFh, 6042h and 6071h become 0 unless keep_target is true. Refused in a fault: reset it first.
        """
        self._command("enable", timeout, until, truth("keep_target", keep_target))

    def disable(self, *, timeout: float = 60.0, until: UntilSpec = "done") -> None:
        """Go to Ready to switch on."""
        self._command("disable", timeout, until)

    def halt(self, *, timeout: float = 60.0, until: UntilSpec = "done") -> None:
        """Brake to standstill; the set-point stays. Also works on an axis that another session holds."""
        self._command("halt", timeout, until)

    def resume(self, *, timeout: float = 60.0, until: UntilSpec = "done") -> None:
        """End a halt and continue the set-point."""
        self._command("resume", timeout, until)

    def quick_stop(self, *, timeout: float = 60.0, until: UntilSpec = "done") -> None:
        """Quick stop. Also works on an axis that another session holds."""
        self._command("quick_stop", timeout, until)

    def reset_fault(self, *, timeout: float = 60.0, until: UntilSpec = "done") -> None:
        """Reset a fault. Refused while its cause persists."""
        self._command("reset_fault", timeout, until)

    def power_cycle(self, *, timeout: float = 60.0, until: UntilSpec = "done") -> None:
        """Switch the axis off and on again."""
        self._command("power_cycle", timeout, until)

    def _command(self, name: CommandSpec, timeout: float, until: UntilSpec,
                 keep_target: bool = False) -> None:
        self._handle.command(name, *call_options(timeout, until), keep_target)

    def move_to(self, position: NumberSpec, *, velocity: NumberSpec | None = None,
                acceleration: NumberSpec | None = None, deceleration: NumberSpec | None = None,
                unit: str | None = None, queue: bool = False, timeout: float = 60.0,
                until: UntilSpec = "done") -> None:
        """Move to a position in UU. Speed (UU/s) and ramps (UU/s^2) are for this move.

        With `unit`, such as "deg", all of them are in that unit and are rounded to UU.
        """
        self._handle.move_to(
            *self._move("position", position, velocity, acceleration, deceleration, unit, queue),
            *call_options(timeout, until))

    def move_by(self, distance: NumberSpec, *, velocity: NumberSpec | None = None,
                acceleration: NumberSpec | None = None, deceleration: NumberSpec | None = None,
                unit: str | None = None, queue: bool = False, timeout: float = 60.0,
                until: UntilSpec = "done") -> None:
        """Move by a distance in UU, from the base that 60F2h selects. `unit` as in move_to()."""
        self._handle.move_by(
            *self._move("distance", distance, velocity, acceleration, deceleration, unit, queue),
            *call_options(timeout, until))

    def start_move(self, position: NumberSpec, *, velocity: NumberSpec | None = None,
                   acceleration: NumberSpec | None = None, deceleration: NumberSpec | None = None,
                   unit: str | None = None, queue: bool = False) -> Motion:
        """Start move_to() and return when the drive has acknowledged the set-point."""
        return Motion(self, self._handle.start_move(
            *self._move("position", position, velocity, acceleration, deceleration, unit, queue)))

    def _move(self, name: str, aim: NumberSpec, velocity: NumberSpec | None,
              acceleration: NumberSpec | None, deceleration: NumberSpec | None, unit: str | None,
              queue: bool) -> tuple[int, int | None, int | None, int | None, bool]:
        given = self._given(unit)
        return (_int32(name, aim, "UU", given), _speed("velocity", velocity, given),
                _ramp("acceleration", acceleration, given),
                _ramp("deceleration", deceleration, given), truth("queue", queue))

    def _given(self, unit: str | None) -> UnitSpec:
        if unit is None:
            return None
        sizes = self.unit._sizes
        unit = text("unit", unit)
        if unit not in sizes:
            raise ValueError(f"axis {self.id} has no unit {unit!r}; it has {', '.join(sizes)}")
        return unit, sizes[unit]

    def home(self, *, method: NumberSpec | None = None, offset: NumberSpec | None = None,
             search_speed: NumberSpec | None = None, creep_speed: NumberSpec | None = None,
             acceleration: NumberSpec | None = None, unit: str | None = None, timeout: float = 60.0,
             until: UntilSpec = "done") -> None:
        """Home the axis, and wait until it is homed. `unit` as in move_to()."""
        given = self._given(unit)
        self._handle.home(
            optional("method", method, -128, 127),
            optional("offset", offset, -2**31, 2**31 - 1, "UU", given),
            _speed("search_speed", search_speed, given), _speed("creep_speed", creep_speed, given),
            _ramp("acceleration", acceleration, given), *call_options(timeout, until))

    def run_at(self, velocity: NumberSpec, *, acceleration: NumberSpec | None = None,
               deceleration: NumberSpec | None = None, unit: str | None = None,
               timeout: float = 60.0, until: UntilSpec = "done") -> None:
        """Profile velocity mode: wait until `velocity` (UU/s) is reached. The axis continues to run.

        `unit` as in move_to().
        """
        given = self._given(unit)
        self._handle.run_at(
            _velocity(velocity, given), _ramp("acceleration", acceleration, given),
            _ramp("deceleration", deceleration, given), *call_options(timeout, until))

    def apply_torque(self, torque: NumberSpec, *, slope: NumberSpec | None = None,
                     timeout: float = 60.0, until: UntilSpec = "done") -> None:
        """Profile torque mode: wait until `torque` (per mille of the rated torque) is reached, and keep it."""
        self._handle.apply_torque(
            whole("torque", torque, -2**15, 2**15 - 1, "per mille"),
            optional("slope", slope, 0, 2**32 - 1, "per mille per s"),
            *call_options(timeout, until))

    def jog(self, velocity: NumberSpec, held: Callable[[Status], bool], *,
            acceleration: NumberSpec | None = None, deceleration: NumberSpec | None = None,
            unit: str | None = None, timeout: float = 60.0) -> None:
        """Run at `velocity` (UU/s) while `held(status)` is true, called every tick, then brake."""
        given = self._given(unit)
        function("held", held)
        self._handle.jog(
            _velocity(velocity, given), lambda state: held(Status(state)),
            _ramp("acceleration", acceleration, given), _ramp("deceleration", deceleration, given),
            nanoseconds("timeout", timeout))

    def read(self, object: ObjectSpec) -> int:
        """Read an object.

        It is given as an index, (index, subindex), or a text such as "profile_velocity" or "0x607D:1".
        """
        return self._handle.read(object_number(object))

    def read_many(self, objects: Iterable[ObjectSpec]) -> list[int | Error]:
        """Read up to 64 objects in one tick. For a refused object, the list has the exception."""
        return self._handle.read_many(row("objects", objects, lambda _, each: object_number(each)))

    def write(self, object: ObjectSpec, value: NumberSpec) -> int:
        """Write an object. Return the tick in which the value is in force."""
        return self._handle.write(object_number(object), value_of_object(value))

    def disturb(self, disturbance: DisturbanceSpec, value: NumberSpec = 1) -> int:
        """Set an input of the test bench: 1 = on, 0 = off; load_torque in mN.m.

        Return the tick in which it is in force.
        """
        # Most of the inputs take True or False.
        number = int(value) if isinstance(value, bool) else value_of_object(value)
        return self._handle.disturb(text("disturbance", disturbance), number)

    def status(self) -> Status:
        """Return the present state."""
        return Status(self._handle.status())

    def wait_until(self, condition: Callable[[Status], bool], timeout: float = 60.0) -> Status:
        """Check every tick until `condition(status)` is true; return that status.

        `timeout` in s of drive time.
        """
        function("condition", condition)
        return Status(self._handle.wait_until(lambda state: condition(Status(state)),
                                              nanoseconds("timeout", timeout)))

    async def wait_until_async(self, condition: Callable[[Status], bool],
                               timeout: float = 60.0) -> Status:
        """Wait as wait_until() does; the condition is called in another thread.

        Cancelling the task does not stop the axis.
        """
        is_cancelled: list[bool] = []
        return await in_thread(
            lambda: self.wait_until(lambda status: bool(is_cancelled) or condition(status), timeout),
            lambda: is_cancelled.append(True))


Axis.disturb.__doc__ = "\n".join([Axis.disturb.__doc__ or "", *(
    f"        {name}\n            {meaning}" for name, meaning in _vdrive.DISTURBANCES.items())])
