# SPDX-License-Identifier: Apache-2.0
"""A private bench: in this process, or a service on a DDS domain that no other program uses."""
import os
import weakref

from . import _vdrive
from ._errors import ConfigurationError, NotFound


def find_service():
    """Return the path of vdrived: VDRIVE_SERVICE, else beside the interpreter, else in PATH."""
    path = os.environ.get("VDRIVE_SERVICE") or _vdrive.find_service()
    if path is None:
        raise NotFound("vdrived is not in PATH: install it, or name it in VDRIVE_SERVICE")
    return path


def _only_over_dds(what):
    return ConfigurationError(f'{what} is of a bench over DDS: vdrive.Bench(..., over="dds")')


class Bench:
    """A private bench, by default in this process, without a network. `with` ends it.

    The bench ends with this object and with this process, however it ends. Several benches do not
    meet, but for those on one bus: see `beside`. A program of its own, a child process too, meets
    only a bench over DDS.
    """

    def __init__(self, axes=None, *, config=None, clock="lockstep", over="local", number=None,
                 state=None, journal=None, beside=None, arguments=(), service=None):
        """Make the bench.

        axes: number of default axes; without it and without `config` the demo bench with two axes.
        config: a file in YAML. clock: "lockstep", "realtime" or "freerun". over: "local", or "dds"
        for a service of its own on a DDS domain. number: of the bench, 1 by default. state: directory
        where parameters can be stored. journal: file that `vdrived --replay` reads. beside: another
        bench, which the sessions of this one meet too. Only over DDS: arguments, further ones of
        vdrived; service, path of vdrived, by default that of find_service().
        """
        if over not in ("local", "dds"):
            raise ValueError(f'over is "local" or "dds", not "{over}"')
        self._sessions = weakref.WeakSet()
        self._is_local = over == "local"
        if self._is_local:
            self._bench = self._local(axes, config, clock, number, state, journal, beside,
                                      arguments, service)
        else:
            if beside is not None:
                raise ConfigurationError("beside= is of benches in this process")
            options = ["--clock", clock]
            for name, value in (("--axes", axes), ("--bench", number)):
                options += [] if value is None else [name, str(value)]
            for name, path in (("--config", config), ("--state", state), ("--journal", journal)):
                options += [] if path is None else [name, os.fspath(path)]
            options += [str(argument) for argument in arguments]
            self._bench = _vdrive.PrivateBench(os.fspath(service or find_service()), options)

    @staticmethod
    def _local(axes, config, clock, number, state, journal, beside, arguments, service):
        if arguments:
            raise _only_over_dds("arguments=")
        if service is not None:
            raise _only_over_dds("service=")
        if beside is not None and not getattr(beside, "_is_local", False):
            raise ConfigurationError("beside= is a vdrive.Bench in this process")
        return _vdrive.LocalBench(
            axes=axes, config=_path(config), clock=clock, number=number, state=_path(state),
            journal=_path(journal), beside=None if beside is None else beside._bench)

    @property
    def domain(self):
        """The DDS domain of a bench over DDS."""
        if self._is_local:
            raise _only_over_dds("domain")
        return self._bench.domain

    def session(self, **options):
        """Return a new Session with the bench, which close() closes, too."""
        if self._is_local:
            session = _vdrive.Session(local=self._bench, **options)
        else:
            options.setdefault("find_timeout", 30.0)
            session = _vdrive.Session(domain=self.domain, **options)
        self._sessions.add(session)
        return session

    def close(self):
        """Close the sessions that session() gave, and end the bench."""
        for session in list(self._sessions):
            session.close()
        self._bench.close()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()


def _path(name):
    return "" if name is None else os.fspath(name)
