# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="no-any-return"
"""Virtual CiA 402 servo drives on DDS, from Python.

    import vdrive

    with vdrive.Session() as session:
        axis = session.axis("1.1")
        axis.enable()
        axis.move_to(10000, velocity=20000)
        print(axis.status().position)

Positions are in user units (UU) of the axis, times in seconds. Calls that wait release the
interpreter lock and end on Ctrl-C. A call that fails raises an Error, with a code and a text.
"""
from __future__ import annotations

from ._errors import (
    ConfigurationError,
    Error,
    Failed,
    Forked,
    Lost,
    NotFound,
    Owner,
    Refused,
    TimedOut,
)

try:
    from . import _vdrive
except ImportError:
    from . import _build

    _build.check()  # raises the more specific error: built for another Python
    raise
from ._axis import DISTURBANCES, Axis, Motion
from ._axis_bank import AxisBank
from ._bench import Bench, find_service
from ._faults import Cause, Fault, FaultWindow, Reported, Story, Write
from ._group import AxisGroup, GroupStatus
from ._judge import Finding, Verdict, judge
from ._observers import Observer
from ._recording import Recording, load
from ._session import Session, StepClock
from ._status import Status
from ._streams import (
    AsyncStream,
    EventStream,
    Follower,
    Observation,
    ServiceStream,
    StatusStream,
)
from ._values import AxisInfo, BenchInfo, Event, Lateness, ServiceChange, Unit

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any

    from numpy import dtype

    from . import canopen as canopen
    from ._enums import ErrorCode, OperatingMode, PowerState, Reason, Statusword
else:
    _ENUMS = ("ErrorCode", "OperatingMode", "PowerState", "Reason", "Statusword")

    def __getattr__(name):
        """Import enumerations and the CANopen module on first use: importing them takes time."""
        if name == "canopen":
            import importlib

            return importlib.import_module(f"{__name__}.canopen")
        if name not in _ENUMS:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from . import _enums

        return getattr(_enums, name)

    def __dir__():
        return sorted({*globals(), *_ENUMS, "canopen"})

PRESETS: tuple[str, ...] = _vdrive.PRESETS
__version__: str = _vdrive.__version__


def default_domain() -> int:
    """Return the DDS domain in VDRIVE_DOMAIN, 0 when it is not set."""
    return _vdrive.default_domain()


def record_type() -> dtype[Any]:
    """Return the numpy dtype of the records of recordings and observations."""
    return _vdrive.record_type()


# Tracebacks must show the names that programs use.
for _class in [value for value in globals().values() if isinstance(value, type)]:
    if _class.__module__.startswith("vdrive."):
        _class.__module__ = "vdrive"
del _class

__all__ = [
    "DISTURBANCES",
    "PRESETS",
    "AsyncStream",
    "Axis",
    "AxisBank",
    "AxisGroup",
    "AxisInfo",
    "Bench",
    "BenchInfo",
    "Cause",
    "ConfigurationError",
    "Error",
    "ErrorCode",
    "Event",
    "EventStream",
    "Failed",
    "Fault",
    "FaultWindow",
    "Finding",
    "Follower",
    "Forked",
    "GroupStatus",
    "Lateness",
    "Lost",
    "Motion",
    "NotFound",
    "Observation",
    "Observer",
    "OperatingMode",
    "Owner",
    "PowerState",
    "Reason",
    "Recording",
    "Refused",
    "Reported",
    "ServiceChange",
    "ServiceStream",
    "Session",
    "Status",
    "StatusStream",
    "Statusword",
    "StepClock",
    "Story",
    "TimedOut",
    "Unit",
    "Verdict",
    "Write",
    "__version__",
    "default_domain",
    "find_service",
    "load",
    "record_type",
]
