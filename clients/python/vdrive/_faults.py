# SPDX-License-Identifier: Apache-2.0
"""What the black box of a bench keeps: its last minutes around a fault, tick by tick."""
from __future__ import annotations

from typing import NamedTuple

TYPE_CHECKING = False  # as typing.TYPE_CHECKING: reading that module takes time
if TYPE_CHECKING:
    from ._recording import Recording


class Cause(NamedTuple):
    """Why a bench has kept what happened."""

    kind: str
    """"fault", "master lost", "stopped by another session" or "asked for"."""
    axis: int
    """Number of the axis, 0 = none."""
    code: int
    """Of a fault 603Fh."""
    session: int
    """Who was lost, has stopped the axis, or has asked; 0 = none."""
    tick: int
    """The tick."""


class Fault(NamedTuple):
    """A stretch of time that a bench keeps, from 2 s before its first cause to 0.5 s after the last."""

    bench: int
    number: int
    first_tick: int
    last_tick: int
    is_open: bool
    """It is still recorded: last_tick will be its last one."""
    causes: list[Cause]
    more_causes: int


class Write(NamedTuple):
    """What somebody wrote to an object of an axis."""

    tick: int
    """The last completed one before."""
    axis: int
    object: tuple[int, int]
    """Index and sub-index."""
    value: int
    session: int
    """Who wrote it, 0 = none."""
    reason: int
    """Why it was refused, 0 = accepted."""


class Reported(NamedTuple):
    """An event in the time of a fault."""

    tick: int
    kind: str
    axis: int
    session: int
    code: int


class Story(NamedTuple):
    """What led to a cause, in sentences."""

    title: str
    lines: list[str]
    remedy: str

    def __str__(self) -> str:
        lines = [f"  {line}" for line in self.lines]
        return "\n".join([self.title, *lines, *([f"  -> {self.remedy}"] if self.remedy else [])])


class FaultWindow(NamedTuple):
    """What some axes did around a fault."""

    fault: Fault
    recording: Recording
    """Each tick, bit for bit as it was; see Recording."""
    writes: list[Write]
    events: list[Reported]
    stories: list[Story]
    """One for each of fault.causes."""


def fault_of(record: tuple) -> Fault:  # type: ignore[type-arg]
    """Return the Fault of a record of the module."""
    bench, number, first, last, is_open, causes, more = record
    return Fault(bench, number, first, last, is_open, [Cause(*each) for each in causes], more)
