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
from . import _asynchronous, _observers, _recording, _vdrive
from ._asynchronous import AsyncStream
from ._bench import Bench, find_service
from ._observers import Observer
from ._recording import Recording, load
from ._vdrive import (
    DISTURBANCES,
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

for _function in (_asynchronous.follow_async, _asynchronous.events_async, _observers.on_event,
                  _observers.on_status, _observers.watch_services, _recording.record):
    setattr(Session, _function.__name__, _function)
del _function

__all__ = [
    "DISTURBANCES",
    "AsyncStream",
    "Axis",
    "AxisBank",
    "AxisGroup",
    "AxisInfo",
    "Bench",
    "BenchInfo",
    "ConfigurationError",
    "Error",
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
    "Owner",
    "Recording",
    "Refused",
    "ServiceChange",
    "ServiceStream",
    "Session",
    "Status",
    "StatusStream",
    "StepClock",
    "TimedOut",
    "Unit",
    "__version__",
    "default_domain",
    "find_service",
    "load",
    "record_type",
]
