# SPDX-License-Identifier: Apache-2.0
"""The black box of a bench: what happened around its last faults, tick by tick."""
from __future__ import annotations

from typing import NamedTuple

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from ._recording import Recording


class Cause(NamedTuple):
    """Why a bench has kept a window."""

    kind: str
    """"fault", "master lost", "stopped by another session" or "asked for"."""
    axis: int
    """Number of the axis, 0 = none."""
    code: int
    """For a fault, 603Fh."""
    session: int
    """The session that was lost, stopped the axis or asked for the window; 0 = none."""
    tick: int
    """The last completed tick."""


class Fault(NamedTuple):
    """A window that a bench keeps, from 2 s before its first cause to 0.5 s after the last."""

    bench: int
    number: int
    first_tick: int
    last_tick: int
    is_open: bool
    """Still being recorded: last_tick is where it will end."""
    causes: list[Cause]
    more_causes: int


class Write(NamedTuple):
    """A write to an object of an axis."""

    tick: int
    """The last tick completed before the write."""
    axis: int
    object: tuple[int, int]
    """Index and sub-index."""
    value: int
    session: int
    """The session that wrote it, 0 = none."""
    reason: int
    """Why it was refused, 0 = accepted."""


class Reported(NamedTuple):
    """An event in the window of a fault."""

    tick: int
    kind: str
    axis: int
    session: int
    code: int


class Story(NamedTuple):
    """The explanation of a cause, in sentences."""

    title: str
    lines: list[str]
    remedy: str

    def __str__(self) -> str:
        lines = [f"  {line}" for line in self.lines]
        return "\n".join([self.title, *lines, *([f"  -> {self.remedy}"] if self.remedy else [])])


class FaultWindow(NamedTuple):
    """The motion, writes and events of some axes around a fault."""

    fault: Fault
    recording: Recording
    """Each tick, bit for bit as it was; see Recording."""
    writes: list[Write]
    events: list[Reported]
    stories: list[Story]
    """One for each of fault.causes."""


def fault_of(record: tuple) -> Fault:  # type: ignore[type-arg]
    """Return the Fault for a record of the C++ module."""
    bench, number, first, last, is_open, causes, more = record
    return Fault(bench, number, first, last, is_open, [Cause(*each) for each in causes], more)
