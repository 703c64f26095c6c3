# SPDX-License-Identifier: Apache-2.0
"""Virtual CiA 402 servo drives on DDS, from Python.

    import vdrive

    with vdrive.Session() as session:
        axis = session.axis("1.1")
        axis.enable()
        axis.move_to(10000, velocity=20000)
        print(axis.status().position)

Positions are user units (UU) of the axis, times are seconds. Calls that wait release the
interpreter lock and end on Ctrl-C. What fails raises an Error, with `code` and text.
"""
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

    _build.check()  # raises what tells more: built for another Python
    raise
from . import _asynchronous, _observers, _recording
from ._asynchronous import AsyncStream
from ._bench import Bench, find_service
from ._observers import Observer
from ._recording import Recording, load
from ._vdrive import (
    DISTURBANCES,
    PRESETS,
    Axis,
    AxisBank,
    AxisGroup,
    AxisInfo,
    BenchInfo,
    Event,
    EventStream,
    Follower,
    GroupStatus,
    Lateness,
    Motion,
    Observation,
    ServiceChange,
    ServiceStream,
    Session,
    Status,
    StatusStream,
    StepClock,
    Unit,
    __version__,
    default_domain,
    record_type,
)

TYPE_CHECKING = False  # as typing.TYPE_CHECKING: reading that module takes time
if TYPE_CHECKING:
    from . import canopen as canopen
    from ._enums import ErrorCode, OperatingMode, PowerState, Reason, Statusword
else:
    _ENUMS = ("ErrorCode", "OperatingMode", "PowerState", "Reason", "Statusword")

    def __getattr__(name):
        """Make what is asked for: reading enum, and the buses of CANopen, takes time."""
        if name == "canopen":
            import importlib

            return importlib.import_module(f"{__name__}.canopen")
        if name not in _ENUMS:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from . import _enums

        return getattr(_enums, name)

    def __dir__():
        return sorted({*globals(), *_ENUMS, "canopen"})

for _function in (_asynchronous.follow_async, _asynchronous.events_async, _observers.on_event,
                  _observers.on_status, _observers.watch_services, _recording.record):
    setattr(Session, _function.__name__, _function)
del _function
for _waiting, _name, _wait in ((Motion, "wait_async", _asynchronous.wait_motion_async),
                               (Motion, "__await__", _asynchronous.await_motion),
                               (AxisGroup, "wait_all_async", _asynchronous.wait_all_async),
                               (Axis, "wait_until_async", _asynchronous.wait_until_async),
                               (Session, "wait_async", _asynchronous.wait_async)):
    setattr(_waiting, _name, _wait)
del _waiting, _name, _wait

# What a traceback names is what a program writes.
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
    "ConfigurationError",
    "Error",
    "ErrorCode",
    "Event",
    "EventStream",
    "Failed",
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
    "ServiceChange",
    "ServiceStream",
    "Session",
    "Status",
    "StatusStream",
    "Statusword",
    "StepClock",
    "TimedOut",
    "Unit",
    "__version__",
    "default_domain",
    "find_service",
    "load",
    "record_type",
]
