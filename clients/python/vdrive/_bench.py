# SPDX-License-Identifier: Apache-2.0
"""A private bench: a service on a DDS domain that no other program of this machine uses."""
import os
import weakref

from . import _vdrive
from ._errors import NotFound


def find_service():
    """Return the path of vdrived: VDRIVE_SERVICE, else beside the interpreter, else in PATH."""
    path = os.environ.get("VDRIVE_SERVICE") or _vdrive.find_service()
    if path is None:
        raise NotFound("vdrived is not in PATH: install it, or name it in VDRIVE_SERVICE")
    return path


class Bench:
    """A private bench with its own service and DDS domain. `with` ends it.

    The service ends with this object and with this process, however it ends. Several benches, also
    of several processes, do not meet.
    """

    def __init__(self, axes=None, *, config=None, clock="lockstep", arguments=(), service=None):
        """Start the service, and wait until it runs.

        axes: number of default axes; without it and without `config` the demo bench with two axes.
        config: a file in YAML. clock: "lockstep", "realtime" or "freerun". arguments: further ones
        of vdrived. service: path of vdrived, by default that of find_service().
        """
        options = ["--clock", clock]
        if config is not None:
            options += ["--config", os.fspath(config)]
        if axes is not None:
            options += ["--axes", str(axes)]
        options += [str(argument) for argument in arguments]
        self._sessions = weakref.WeakSet()
        self._bench = _vdrive.PrivateBench(os.fspath(service or find_service()), options)

    @property
    def domain(self):
        """The DDS domain of the bench."""
        return self._bench.domain

    def session(self, **options):
        """Return a new Session on the domain of the bench, which close() closes, too."""
        options.setdefault("find_timeout", 30.0)
        session = _vdrive.Session(domain=self.domain, **options)
        self._sessions.add(session)
        return session

    def close(self):
        """Close the sessions that session() gave, and end the service."""
        for session in list(self._sessions):
            session.close()
        self._bench.close()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()
