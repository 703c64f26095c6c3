# SPDX-License-Identifier: Apache-2.0
"""The judge: what a master did wrong, at which tick, by which rule."""
from __future__ import annotations

import os
from typing import NamedTuple

from . import _vdrive

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Mapping

    Path = str | os.PathLike[str]

SEVERITIES = ("error", "warning", "advice")


class Finding(NamedTuple):
    """A rule that a master broke on an axis, reported once however often it was broken."""

    rule: str
    severity: str
    axis: str
    times: int
    tick: int
    title: str
    happened: str
    expected: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.severity} {self.rule} on {self.axis} at tick {self.tick}: {self.happened}"


class Verdict(NamedTuple):
    """The verdict of the judge on a journal."""

    findings: list[Finding]
    unused: list[str]
    report: str


def judge(journal: Path, *, off: Mapping[str, str] | None = None) -> Verdict:
    """Judge the masters of a bench by its journal, as `vdrive judge` does.

    journal: the file of Bench(journal=...), after close(). off: rules that the master breaks on
    purpose, each with its reason. `findings` are worst first, `unused` are the rules of `off` that were
    not broken, `report` is a readable text, with the table around each finding. Raises
    FileNotFoundError, or another OSError, when the file cannot be opened; ValueError when it cannot be
    judged, and for an unknown rule or one without a reason.
    """
    reasons = dict(off or {})
    for rule, reason in reasons.items():
        if not isinstance(reason, str) or not reason.strip():
            raise ValueError(f"off: {rule} has no reason: say why the master does this on purpose")
    os.close(os.open(journal, os.O_RDONLY | os.O_NONBLOCK))  # raises OSError if it cannot be opened
    findings, unused, report = _vdrive.judge_journal(os.fspath(journal), list(reasons.items()))
    return Verdict([Finding(*each) for each in findings], unused, report)
