# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="no-any-return"
"""A private bench: in this process, or a service over DDS, by default on an unused domain."""
from __future__ import annotations

import os
import weakref

from . import _vdrive
from ._arguments import instance, is_utf8, optional, texts
from ._errors import ConfigurationError, NotFound
from ._session import Session

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any, Iterable, Literal, NoReturn, Sequence

    from ._arguments import KeepAliveSpec, NumberSpec
    from ._faults import Fault

    Path = str | bytes | os.PathLike[str] | os.PathLike[bytes]


def find_service() -> str:
    """Return the path of vdrived: VDRIVE_SERVICE, else next to the interpreter, else in PATH."""
    path = os.environ.get("VDRIVE_SERVICE") or _vdrive.find_service()
    if path is None:
        raise NotFound("vdrived is not in PATH: install it, or name it in VDRIVE_SERVICE")
    return path


def _only_over_dds(what: str) -> ConfigurationError:
    return ConfigurationError(f'{what} needs a bench over DDS: vdrive.Bench(..., over="dds")')


def _whole(name: str, value: NumberSpec | None, lowest: int, highest: int) -> int | None:
    """Return the value as an int in this range, or None for None."""
    try:
        return optional(name, value, lowest, highest)
    except ValueError as error:
        raise ConfigurationError(str(error)) from None


def _one_of(name: str, value: Any, words: tuple[str, ...]) -> Any:
    if value not in words:
        raise ConfigurationError(f"{name} = {value!r}: must be one of {', '.join(words)}")
    return value


def _preset(value: str | None) -> str:
    """Return the name of an existing preset, or an empty text for None."""
    if value is None:
        return ""
    if not isinstance(value, str):
        raise TypeError(f"preset = {value!r}: must be the name of a machine")
    name: str = _one_of("preset", value, _vdrive.PRESETS)
    return name


def _path(name: str, value: Path | None) -> str:
    """Return the path as a text, empty for None."""
    if value is None:
        return ""
    try:
        path = os.fsdecode(value)
    except TypeError:
        raise TypeError(f"{name} = {value!r}: must be a path") from None
    if not path:
        raise ConfigurationError(f"{name} = '': must be a path")
    if "\0" in path or not is_utf8(path):
        raise ConfigurationError(f"{name} = {path!r}: must be a path in UTF-8, without NUL")
    return path


def _configuration(value: Path | None) -> str:
    """Return the path of a configuration file that can be opened, or an empty text for None."""
    path = _path("config", value)
    if path:
        try:
            with open(path, "rb"):
                pass
        except OSError as error:
            raise ConfigurationError(f"config = {path!r}: {error.strerror}") from None
    return path


def _words(arguments: Iterable[object]) -> list[str]:
    """Return the arguments of vdrived as texts. Refuses a single text, whose letters would become arguments."""
    if isinstance(arguments, (str, bytes)) or not hasattr(arguments, "__iter__"):
        raise TypeError(f'arguments = {arguments!r}: must be a list of words, such as '
                        '["--period", "500"]')
    return texts("arguments", [str(argument) for argument in arguments])


class Bench:
    """A private bench, by default in this process and without a network. `with` closes it.

    It ends with close(), and with this process, however the process ends. Without close() it ends when
    neither this object nor an open session from session() is left. Its sessions find no other benches
    than those created with `beside` or on the same `domain`. Other programs, including child
    processes, reach only a bench over DDS.
    """

    def __init__(self, axes: NumberSpec | None = None, *, preset: str | None = None,
                 config: Path | None = None,
                 clock: Literal["lockstep", "realtime", "freerun"] = "lockstep",
                 over: Literal["local", "dds"] = "local", number: NumberSpec | None = None,
                 state: Path | None = None, journal: Path | None = None,
                 beside: Bench | None = None, arguments: Iterable[object] = (),
                 service: Path | None = None, domain: NumberSpec | None = None) -> None:
        """Create the bench.

        axes: number of default axes, 1 to 16384; without `axes` and `config`, the demo bench with two
        axes. preset: type of machine for the axes, one of vdrive.PRESETS; without `axes` there is one
        axis. config: a YAML file; `axes` and `preset` replace its axes, and `clock` its clock mode.
        clock: "lockstep", "realtime" or "freerun". over: "local", or "dds" for a separate service on a
        DDS domain. number: of the bench, 1 to 65535, by default as configured, otherwise 1.
        state: directory where parameters can be stored. journal: file for judge() and
        `vdrived --replay`. beside: another bench with the same `over`; sessions of either bench find
        both. Only over DDS: `arguments` (additional ones for vdrived), `service` (path of vdrived, by
        default find_service()) and `domain` (0 to 232, to find other benches there, instead of `beside`).

        Raises ConfigurationError for a value that is out of range, unknown or contradicts another one,
        and TypeError for one of a wrong type; both name the argument.
        """
        self._sessions: weakref.WeakSet[Session] = weakref.WeakSet()
        self._beside: weakref.WeakSet[Bench] = weakref.WeakSet()  # benches created with this one as `beside`
        self._local: Any = None
        self._private: Any = None
        self._is_local = _one_of("over", over, ("local", "dds")) == "local"
        axes = _whole("axes", axes, 1, _vdrive.MOST_AXES)
        number = _whole("number", number, 1, _vdrive.HIGHEST_BENCH)
        domain = _whole("domain", domain, 0, _vdrive.HIGHEST_DOMAIN)
        self._check_beside(beside)
        of_both: dict[str, Any] = {"preset": _preset(preset),
                   "clock": _one_of("clock", clock, _vdrive.CLOCK_MODES),
                   "config": _configuration(config),
                   "state": _path("state", state), "journal": _path("journal", journal)}
        if self._is_local:
            for name, given in (("arguments=", bool(arguments)), ("service=", service is not None),
                                ("domain=", domain is not None)):
                if given:
                    raise _only_over_dds(name)
            self._local = _vdrive.LocalBench(
                axes, of_both["preset"], of_both["config"], of_both["clock"], number,
                of_both["state"], of_both["journal"], None if beside is None else beside._local)
        else:
            self._private = self._service(axes, number, of_both, beside, arguments, service, domain)
        if beside is not None:
            beside._beside.add(self)

    def _check_beside(self, beside: Bench | None) -> None:
        if beside is None:
            return
        if instance("beside", beside, Bench)._is_local != self._is_local:
            raise ConfigurationError(f"beside= names a bench {beside._place()}, but this one is "
                                     f"{self._place()}: they cannot communicate")

    def _place(self) -> str:
        return "in this process" if self._is_local else "over DDS"

    def __repr__(self) -> str:
        return f"<vdrive.Bench {self._place()}>"

    def __reduce__(self) -> NoReturn:
        raise TypeError(f"cannot pickle {self!r}")

    @staticmethod
    def _service(axes: int | None, number: int | None, of_both: dict[str, Any],
                 beside: Bench | None, arguments: Iterable[object], service: Path | None,
                 domain: int | None) -> Any:
        if beside is not None and domain is not None:
            raise ConfigurationError("beside= and domain= both select a domain: use only one")
        options: list[str] = []
        for name, value in (("axes", axes), ("bench", number), *of_both.items()):
            options += [] if value in (None, "") else [f"--{name}", str(value)]
        return _vdrive.PrivateBench(_path("service", service) or find_service(),
                                    options + _words(arguments),
                                    beside.domain if beside is not None else domain)

    @property
    def domain(self) -> int:
        """The DDS domain of a bench over DDS."""
        if self._private is None:
            raise _only_over_dds("domain")
        return self._private.domain()

    def session(self, *, interfaces: Sequence[str] = (), peers: Sequence[str] = (),
                discovery_servers: Sequence[str] = (), security: str = "",
                bench: int | None = None,
                keep_alive: KeepAliveSpec = "own_thread",
                find_timeout: float = 2.0, silence: float = 1.5, patience: float = 10.0,
                program: str = "") -> Session:
        """Return a new Session on the bench, which close() also closes.

        The parameters and defaults are those of Session. A bench in this process ignores the network
        parameters.
        """
        session = Session(
            local=self._local, service=self._private, domain=None if self._local is not None else self.domain,
            interfaces=interfaces, peers=peers, discovery_servers=discovery_servers,
            security=security, bench=bench, keep_alive=keep_alive, find_timeout=find_timeout,
            silence=silence, patience=patience, program=program)
        self._sessions.add(session)
        return session

    def faults(self) -> list[Fault]:
        """Return the faults in the black box of this bench; Session.fault() has the details of one."""
        with self.session() as session:
            return session.faults()

    def _close_sessions(self, but: Session | None = None) -> None:
        for session in list(self._sessions):
            if session is not but:
                session.close()

    def _close_others(self) -> None:
        """End the benches that were created with this one as `beside`."""
        for bench in list(self._beside):
            bench._close_others()
            bench.close()

    def close(self) -> None:
        """Close the sessions from session(), and end the bench."""
        self._close_sessions()
        for bench in (self._local, self._private):
            if bench is not None:
                bench.close()

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
