# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="no-any-return"
"""A CAN bus whose nodes are the axes of a private bench, for testing a CANopen master.

    import vdrive.canopen

    with vdrive.canopen.Bus(axes=3) as bus:      # nodes 1 to 3
        master = bus.can()                       # a bus of python-can
        ...

The bus is the program vdrive-canopen with a private bench (`--private`): it needs no CAN interface and
no DDS. Any number of masters of any kind can join it through its socketcand server at `host` and `port`,
and scripts through its ASCII gateway (CiA 309-3) at `gateway`.
"""
from __future__ import annotations

import contextlib
import importlib
import os
import re
import threading
import time
import weakref

from . import _vdrive
from ._arguments import real
from ._bench import _configuration, _one_of, _path, _preset, _whole, _words
from ._errors import ConfigurationError, Failed, Forked, NotFound

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any, Iterable, Literal

    from ._arguments import NumberSpec
    from ._bench import Path

_PROGRAM = "vdrive-canopen"
_CLOCKS = ("realtime", "lockstep")
_HIGHEST_NODE = 127
_USUAL_AXES = 3
_LONGEST_PERIOD = 10.0  # [s]
_START = 60.0  # [s] Long, because a busy machine may start many of them at the same time.
_END = 5_000_000_000  # [ns]
_POLL = 2_000_000  # [ns]
_USAGE = 2  # exit code of a program that cannot use its arguments
_OF_A_NETWORK = ("VDRIVE_DOMAIN", "VDRIVE_SECURITY")  # variables that a private bench does not use


def find_program() -> str:
    """Return the path of vdrive-canopen: VDRIVE_CANOPEN, else next to the interpreter, else in PATH."""
    path = os.environ.get("VDRIVE_CANOPEN") or _vdrive.find_program(_PROGRAM)
    if path is None:
        raise NotFound(f"{_PROGRAM} is not in PATH: install the package {_PROGRAM}, or name the "
                       "program in VDRIVE_CANOPEN")
    return path


class _Places:
    """The first line of the program's output: the nodes of its bus, and the addresses for masters."""

    def __init__(self, line: str) -> None:
        """Read the line; raise ValueError, with what is missing, for another line."""
        nodes = re.search(r"\b\d+ nodes? \(([^)]*)\)", line)
        if nodes is None:
            raise ValueError("no nodes")
        self.nodes = tuple(node for part in nodes[1].split(",") for node in _range_of(part))
        self.socketcand = _place_of("socketcand", line)
        self.gateway = _place_of("gateway", line)


def _range_of(text: str) -> range:
    """Return the numbers of "3" or "1 to 3"."""
    found = re.fullmatch(r"\s*(\d+)(?: to (\d+))?\s*", text)
    if found is None:
        raise ValueError(f"no nodes in {text!r}")
    return range(int(found[1]), int(found[2] or found[1]) + 1)


def _place_of(name: str, line: str) -> tuple[str, int]:
    found = re.search(rf"\b{name} \[?([^\s,\]]+)\]?:(\d+)\b", line)
    if found is None:
        raise ValueError(f"no {name}")
    return found[1], int(found[2])


def _counters_of(output: str) -> dict[str, int]:
    """Return the counters after the first line: {"frames": 12} for "vdrive-canopen: bus 1: 12 frames"."""
    _, _, last = output.partition("\n")
    counted = re.findall(r"[,;:] (\d+) ([^\d,;:\n]+)", last)
    return {name.strip(): int(count) for count, name in counted}


def _duration(seconds: float | None) -> str | None:
    """Return the drive time of a SYNC in the form that the program accepts."""
    if seconds is None:
        return None
    period = real("sync_steps", seconds)
    if not 0.0 < period <= _LONGEST_PERIOD or abs(round(period * 1e6) - period * 1e6) > 1e-3:
        raise ConfigurationError(f"sync_steps = {period:g}: must be a whole number of microseconds, "
                                 f"in s, from 0.000125 to {_LONGEST_PERIOD:g}")
    return f"{round(period * 1e6)}us"


class Bus:
    """A CAN bus with the axes of a private bench as its nodes. `with` closes it.

    It ends with this object, and with this process, however the process ends. Each bus is separate from
    all others. Heartbeats and timers of the nodes count drive time: in lock-step each run of a test has
    the same frames.
    """

    channel: str = "can0"
    """The name of the bus for a client of socketcand."""

    def __init__(self, axes: NumberSpec | None = None, *, preset: str | None = None,
                 clock: Literal["realtime", "lockstep"] | None = None,
                 sync_steps: float | None = None, config: Path | None = None,
                 node_offset: NumberSpec = 0, program: Path | None = None,
                 arguments: Iterable[object] = ()) -> None:
        """Start the program, and wait until its nodes have booted.

        axes: number of default axes, 1 to 127; by default 3, or as in `config`. preset: type of machine for
        the axes, one of vdrive.PRESETS. config: a YAML file that describes the bench. clock: "lockstep",
        in which only SYNC lets time pass, or "realtime"; by default "lockstep" if `sync_steps` is given,
        otherwise "realtime"; "lockstep" requires `sync_steps`. sync_steps: drive time that each SYNC lets
        pass, in s, 0.000125 to 10. node_offset: added to the number of an axis to give its node-ID, 0 to
        126. program: path of vdrive-canopen, by default find_program(). arguments: additional ones for
        the program.

        Raises ConfigurationError for a value that is out of range, unknown or contradicts another one,
        and TypeError for one of a wrong type; both name the argument. Raises ConfigurationError if the
        program refuses its arguments, and Failed if it ends for another reason; both contain what the
        program wrote to standard error.
        """
        self._lock = threading.Lock()
        self._maker = os.getpid()
        self._masters: weakref.WeakSet[Any] = weakref.WeakSet()
        self._counters: dict[str, int] = {}
        self._is_closed = False
        offset = _whole("node_offset", node_offset, 0, _HIGHEST_NODE - 1) or 0
        axes = _whole("axes", axes, 1, _HIGHEST_NODE)
        preset = _preset(preset)
        config = _configuration(config)
        for name, given in (("axes", axes is not None), ("preset", bool(preset))):
            if given and config:
                raise ConfigurationError(f"{name}= and config= both define the axes: use only one")
        if axes is None and not config:
            axes = _USUAL_AXES
        if axes is not None and axes + offset > _HIGHEST_NODE:
            raise ConfigurationError(f"axes = {axes}: with node_offset = {offset} must be at most "
                                     f"{_HIGHEST_NODE - offset}: a bus has {_HIGHEST_NODE} nodes")
        if clock is not None:
            _one_of("clock", clock, _CLOCKS)
        period = _duration(sync_steps)
        if period is not None and clock == "realtime":
            raise ConfigurationError('sync_steps= is of a bus in lock-step: clock="lockstep"')
        options: list[str] = []
        for name, value in (("axes", axes), ("preset", preset), ("bench-config", config),
                            ("clock", clock), ("sync-steps", period), ("node-offset", offset or None)):
            options += [] if value in (None, "") else [f"--{name}", str(value)]
        self._path = _path("program", program) or find_program()
        self._program = _vdrive.PrivateProgram(
            [self._path, "--private", "--socketcand", "127.0.0.1:0", "--gateway", "127.0.0.1:0",
             *options, *_words(arguments)], _OF_A_NETWORK)
        try:
            places = self._wait_for_places()
        except BaseException:
            self._program.stop(_END)
            raise
        self._places = places

    def _wait_for_places(self) -> _Places:
        """Wait for the first line of the program."""
        deadline = time.monotonic() + _START
        while True:
            code = self._program.wait(_POLL)
            line, end, _ = self._program.output().decode(errors="replace").partition("\n")
            if end:
                try:
                    return _Places(line)
                except ValueError as error:
                    raise Failed(f"{self._path} is not {_PROGRAM}: its first line has {error}: "
                                 f"{line!r}") from None
            if code is not None:
                kind = ConfigurationError if code == _USAGE else Failed
                raise kind(f"{_PROGRAM} did not start: {self._reason(code)}")
            if time.monotonic() > deadline:
                raise Failed(f"{_PROGRAM} did not start within {_START:g} s: "
                             f"{self._errors() or 'it wrote nothing'}")

    def _errors(self) -> str:
        return self._program.errors().decode(errors="replace").rstrip("\n")

    def _reason(self, code: int) -> str:
        """Return which signal ended the program, otherwise what it wrote before it ended."""
        errors = self._errors()
        if code < 0:
            wrote = f"; it wrote: {errors}" if errors else " and wrote nothing"
            return f"{self._path} was ended by signal {-code}{wrote}"
        if errors:
            return errors
        if not os.path.exists(self._path):
            return f"{self._path}: no such file"
        if os.path.isdir(self._path) or not os.access(self._path, os.X_OK):
            return f"{self._path}: not a program that can be executed"
        return f"{self._path} ended with exit code {code} and wrote nothing"

    @property
    def host(self) -> str:
        """The address of the socketcand server, where masters join the bus."""
        return self._places.socketcand[0]

    @property
    def port(self) -> int:
        """The TCP port of the socketcand server."""
        return self._places.socketcand[1]

    @property
    def gateway(self) -> tuple[str, int]:
        """Address and TCP port of the ASCII gateway (CiA 309-3)."""
        return self._places.gateway

    @property
    def nodes(self) -> tuple[int, ...]:
        """The node-IDs on the bus."""
        return self._places.nodes

    @property
    def exit_code(self) -> int | None:
        """The exit code of the program, or -signal; None while it runs."""
        self._require_own()
        with self._lock:
            return self._program.wait(0)

    @property
    def errors(self) -> str:
        """The output of the program on standard error so far."""
        self._require_own()
        return self._errors()

    @property
    def counters(self) -> dict[str, int]:
        """The counters of the program, such as {"frames": 1234}; empty before close()."""
        return dict(self._counters)

    def can(self, **options: Any) -> Any:
        """Return a new python-can bus that is connected to this one; close() also closes it.

        It is `can.Bus(interface="socketcand", host=bus.host, port=bus.port, channel=bus.channel)`;
        `options` are additional ones for can.Bus.
        """
        if self._is_closed:
            raise Failed("the bus has ended")
        try:
            can = importlib.import_module("can")
        except ModuleNotFoundError as error:
            if error.name != "can":
                raise
            raise NotFound("python-can is not installed: apt-get install python3-can, or pip "
                           "install python-can") from None
        place = {"interface": "socketcand", "host": self.host, "port": self.port,
                 "channel": self.channel}
        master = can.Bus(**{**place, **options})
        self._masters.add(master)
        return master

    def _require_own(self) -> None:
        if os.getpid() != self._maker:
            raise Forked("the bus belongs to the process from which this one was forked")

    def close(self) -> None:
        """Close the buses from can(), and end the program. Can be called repeatedly.

        Raises Failed if the program had already ended by itself, or did not end as it should. Does
        nothing in a forked process: the bus belongs to the parent.
        """
        if os.getpid() != self._maker:
            return
        with self._lock:
            if self._is_closed:
                return
            self._is_closed = True
            before = self._program.wait(0)
            try:
                with contextlib.ExitStack() as ending:  # close all of them, even if one raises
                    for master in list(self._masters):
                        ending.callback(master.shutdown)
            finally:
                self._program.stop(_END)
                code = self._program.wait(0)
                self._counters = _counters_of(self._program.output().decode(errors="replace"))
        if before is not None:
            raise Failed(f"{_PROGRAM} has ended by itself: {self._reason(before)}")
        if code:
            raise Failed(f"{_PROGRAM} did not end as it should: {self._reason(code)}")

    def __enter__(self) -> Bus:
        return self

    def __exit__(self, kind: object, *exception: object) -> None:
        try:
            self.close()
        except Failed:
            if kind is None:  # otherwise it would hide the earlier exception
                raise

    def __repr__(self) -> str:
        where = "closed" if self._is_closed else f"{self.host}:{self.port}"
        return f"<vdrive.canopen.Bus {where}, {len(self.nodes)} nodes>"


__all__ = ["Bus", "find_program"]
