# SPDX-License-Identifier: Apache-2.0
"""The exceptions of the library: why a call failed."""
from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Owner:
    """The session that holds an axis, and its program as stated by that program: nobody checks it.

    `axis` is an address such as "1.1", empty if the bench named none. `program` and `host` are empty
    and `process` is 0 if the program states nothing, as for a client of another vendor.
    """

    axis: str
    session: int
    program: str = ""
    process: int = 0
    host: str = ""


class Error(Exception):
    """Why a call failed.

    `code` is the code of a refusal: a CiA 301 abort code, or a reason of the wire contract (below
    0x05000000); 0 for every other error. `owner` is the other session if one is in the way, else None.
    The text is `str(error)`.
    """

    def __init__(self, message: str, code: int = 0, owner: Owner | None = None) -> None:
        super().__init__(message)
        self.code = code
        self.owner = owner

    def __reduce__(self) -> tuple[type[Error], tuple[str, int, Owner | None]]:
        return type(self), (str(self), self.code, self.owner)


class Refused(Error):
    """The service, the dictionary or the state of the drive does not allow it: see `code`."""


class TimedOut(Error, TimeoutError):
    """The deadline passed first."""


class NotFound(Error, LookupError):
    """No such bench, axis or name was found."""


class Lost(Error, ConnectionError):
    """The service stopped sending, ended or was restarted."""


class Failed(Error):
    """The command was accepted, but not completed.

    It was ended by a fault, a lost enable, a limit, a halt, another command or an interrupt, or its
    stream was closed.
    """


class Forked(Error, RuntimeError):
    """The object, or the DDS library, belongs to the process from which this one was forked."""


class ConfigurationError(Error, ValueError):
    """A session, a bench or a bus cannot be set up with these options."""
