# SPDX-License-Identifier: Apache-2.0
"""Immutable values that a program reads from benches."""
from __future__ import annotations

from dataclasses import dataclass, field

from ._arguments import MOST, real, whole

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any, Literal, Mapping, NoReturn, Sequence, SupportsFloat


@dataclass(frozen=True, repr=False)
class Unit:
    """The physical unit of the user units (UU) of an axis."""

    kind: Literal["rotary", "linear"]
    """"rotary" or "linear"."""
    name: str
    """The unit in which positions are shown, such as "deg" or "mm"."""
    size: float
    """UU per revolution; for a linear axis, per `name`."""
    _sizes: Mapping[str, float] = field(compare=False)  # [UU] of the units that calls accept

    def to_user_units(self, value: SupportsFloat) -> int:
        """Convert a position in the unit `name` to UU, rounded to the nearest.

        Speeds and accelerations in `name` per s and s^2 are converted in the same way.
        """
        return whole("value", value, -2**63, MOST, "UU", (self.name, self._sizes[self.name]))

    def from_user_units(self, user_units: float) -> float:
        """Convert a position in UU, or a speed or acceleration in UU per s or s^2, to the unit `name`."""
        return real("user_units", user_units) / self._sizes[self.name]

    def __repr__(self) -> str:
        return f"<vdrive.Unit {self.name}>"


@dataclass(frozen=True, repr=False)
class AxisInfo:
    """The description of an axis that its bench publishes."""

    id: str
    """Address, such as "1.2"."""
    name: str
    """Its name."""
    supported_drive_modes: int
    """6502h."""
    user_position_lower_limit: int
    """607Dh:1 at power-up, in UU."""
    user_position_upper_limit: int
    """607Dh:2 at power-up, in UU."""
    app_speed_limit: int
    """607Fh at power-up, in UU/s."""
    unit: Unit
    """The physical unit of the user units of the axis."""

    def __repr__(self) -> str:
        return f"<vdrive.AxisInfo {self.id} {self.name}>"


@dataclass(frozen=True, repr=False, eq=False)
class BenchInfo:
    """The description that a bench publishes."""

    number: int
    """Its number on the domain."""
    incarnation: int
    """The run of the service; it changes with a restart."""
    name: str
    """Its name."""
    clock_mode: Literal["realtime", "lockstep", "freerun"]
    """"realtime", "lockstep" or "freerun"."""
    period: float
    """Drive time of a tick, in s."""
    status_every_ticks: int
    """Ticks from one sample of the status stream to the next."""
    tick: int
    """Newest tick received."""
    sample_age: float
    """Wall time since its newest sample, in s, at the time of the search."""
    rate: float
    """Drive time over wall time; 0 = paused."""
    figures: dict[str, int]
    """Its counters and measurements since the start, by their names in bench_state; 0 = not known yet."""
    wire_starts: int
    """Starts of its network process; 0 = not known yet."""
    longest_silence: float
    """Longest drive time so far without a message from an owner of axes, in s."""
    user_units_per_revolution: float
    """UU per revolution."""
    dictionary_version: str
    """Version of its object dictionary."""
    service_version: str
    """Version of vdrived."""
    host: str
    """Name of the machine or container of its service; empty: not known, or this process."""
    _handle: Any  # creates the descriptions of thousands of axes on demand

    @property
    def axes(self) -> list[AxisInfo]:
        """Its axes, by number."""
        return [AxisInfo(*[*axis[:-1], unit_of(axis[-1])]) for axis in self._handle.axes()]

    def __repr__(self) -> str:
        return f"<vdrive.BenchInfo {self.number}, {self._handle.size()} axes, {self.clock_mode}>"

    def __reduce__(self) -> NoReturn:
        raise TypeError(f"cannot pickle {self!r}")


@dataclass(frozen=True, repr=False)
class Event:
    """An event of a bench."""

    bench: int
    """Number of the bench."""
    incarnation: int
    """The run of the service; it changes with a restart."""
    axis: int
    """Number of the axis; 0 = the bench, or several axes."""
    kind: str
    """The kind of event, such as "fault"."""
    tick: int
    """The tick."""
    session: int
    """The session of the command, 0 = none."""
    code: int
    """For a fault, 603Fh; see docs/reference/wire.md."""
    error_register: int
    """For a fault, 1001h."""
    suppressed: int
    """Number of identical events suppressed before this one."""
    text: str
    """Text for people."""

    def __repr__(self) -> str:
        return f"<vdrive.Event {self.kind} tick {self.tick}: {self.text}>"


@dataclass(frozen=True, repr=False, eq=False)
class ServiceChange:
    """A change in the presence of a service."""

    bench: int
    """Number of its bench."""
    news: Literal["found", "fell_silent", "sends_again", "restarted", "went_offline"]
    """"found", "fell_silent", "sends_again", "restarted" or "went_offline"."""
    silence: float
    """Age of its newest sample, in s of wall time."""
    text: str
    """Text for people."""

    def __repr__(self) -> str:
        return f"<vdrive.ServiceChange {self.news}: {self.text}>"


@dataclass(frozen=True, repr=False, eq=False)
class Lateness:
    """How far the samples of a Follower lagged behind the time of their bench when the program got them.

    The time of the bench is the newest tick that the session has received from it. This reveals a
    program that takes samples more slowly than they arrive.
    """

    samples: int
    """Samples that the follower returned."""
    late: int
    """Of these, those returned when a later one was already due."""
    last: float
    """Lateness of the newest sample, in s of drive time."""
    longest: float
    """Longest lateness, in s of drive time."""

    def __repr__(self) -> str:
        return (f"<vdrive.Lateness: {self.late} of {self.samples} samples, at most "
                f"{self.longest:g} s>")


def unit_of(plain: Sequence[Any]) -> Unit:
    return Unit(*plain)


def bench_of(handle: Any) -> BenchInfo:
    return BenchInfo(*[*handle.plain(), handle])
