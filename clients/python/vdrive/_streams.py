# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="no-any-return"
"""Streams of status, events and changes of services."""
from __future__ import annotations

from ._arguments import MOST, Handle, optional_nanoseconds, whole
from ._errors import Error
from ._status import Status
from ._values import Event, Lateness, ServiceChange

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    import asyncio
    from typing import Any, Generic, Iterator, TypeVar

    from numpy.typing import NDArray
    from typing_extensions import Self

    from ._arguments import NumberSpec

    Item = TypeVar("Item")
else:
    class Generic:
        """Replace typing.Generic, which only type checkers need."""

        __slots__ = ()

        def __class_getitem__(cls, item):
            return cls

    Item = None


class Observation(Handle):
    """All watched axes after the same tick."""

    __slots__ = ()

    @property
    def tick(self) -> int:
        """The tick."""
        return self._handle.tick

    @property
    def missed(self) -> int:
        """Samples of the stream lost since the previous one."""
        return self._handle.missed

    @property
    def skipped(self) -> int:
        """Ticks since the previous sample that the tick number jumped over: they were not run, and none is lost."""
        return self._handle.skipped

    @property
    def axes(self) -> list[Status]:
        """Status of each axis, in the order of the request."""
        return [Status(axis) for axis in self._handle.axes()]

    @property
    def owners(self) -> list[int]:
        """Session that holds each axis, 0 = none."""
        return self._handle.owners()

    def array(self) -> NDArray[Any]:
        """The axes as a numpy array of records, a field for each member of the status."""
        return self._handle.array()

    def __len__(self) -> int:
        return self._handle.size()

    def __getitem__(self, place: int) -> Status:
        return Status(self._handle.axis(whole("place", place, -2**63)))

    def __eq__(self, other: object) -> bool:
        """Whether both show the same axes with the same values in the same tick."""
        return isinstance(other, Observation) and self._content() == other._content()

    def __hash__(self) -> int:
        return hash((self.tick, len(self)))

    def _content(self) -> tuple[Any, ...]:
        return self.tick, self.missed, self.skipped, self._handle.axes()

    def __repr__(self) -> str:
        return f"<vdrive.Observation tick {self.tick}, {len(self)} axes>"


class Follower(Handle):
    """Axes tick by tick: an iterator of observations, see Session.follow()."""

    __slots__ = ()

    @property
    def lateness(self) -> Lateness:
        """How late the samples of this follower were."""
        return Lateness(*self._handle.lateness())

    def take(self, count: NumberSpec) -> NDArray[Any]:
        """Wait for `count` observations, or for as many as remain of the `count` of follow().

        Returns a numpy array of records, with a row per sample and a column per axis. After an exception,
        the next call immediately returns the samples that had already arrived.
        """
        return self._handle.take(whole("count", count))

    def close(self) -> None:
        """End the stream."""
        self._handle.close()

    def __iter__(self) -> Iterator[Observation]:
        return self

    def __next__(self) -> Observation:
        return Observation(self._handle.__next__())


class _Stream(Handle, Generic[Item]):
    """An iterator of values from a C++ thread. When the queue is full, the oldest are dropped."""

    __slots__ = ("_session",)

    def __init__(self, handle: Any, session: object) -> None:
        super().__init__(handle)
        self._session = session  # keeps the session alive

    def _item(self, plain: Any) -> Item:
        raise NotImplementedError

    @property
    def dropped(self) -> int:
        """How many values were dropped, the oldest first, because the program did not take them in time."""
        return self._handle.dropped()

    @property
    def is_closed(self) -> bool:
        """Whether it was closed and everything that had arrived has been taken."""
        return self._handle.is_closed()

    def next(self, timeout: float | None = None) -> Item | None:
        """Wait for the next value, at most for `timeout` s; return None if none has arrived.

        Raises Failed after close().
        """
        plain = self._handle.next(optional_nanoseconds("timeout", timeout))
        return None if plain is None else self._item(plain)

    def fileno(self) -> int:
        """Return a file descriptor that is readable while a value waits, for select, asyncio and similar."""
        return self._handle.fileno()

    def close(self) -> None:
        """End the stream."""
        self._handle.close()

    def __iter__(self) -> Iterator[Item]:
        return self

    def __next__(self) -> Item:
        return self._item(self._handle.__next__())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


class StatusStream(_Stream[Observation]):
    """Status of axes as it arrives, received in a separate thread: an iterator of observations."""

    __slots__ = ()

    def _item(self, plain: Any) -> Observation:
        return Observation(plain)

    @property
    def axes(self) -> list[str]:
        """Addresses of the axes, in the order of the columns."""
        return self._handle.axes()

    def take(self, timeout: float | None = None, most: int = MOST) -> NDArray[Any]:
        """Wait for samples, at most for `timeout` s, and take up to `most` of those that have arrived.

        Returns a numpy array of records, with a row per sample and a column per axis.
        """
        return self._handle.take(optional_nanoseconds("timeout", timeout), whole("most", most))


class StatusReports(_Stream[Observation]):
    """The newest state of axes, at a fixed rate; use it through on_status()."""

    __slots__ = ()

    def _item(self, plain: Any) -> Observation:
        return Observation(plain)


class EventStream(_Stream[Event]):
    """Events of benches as they arrive: an iterator of events."""

    __slots__ = ()

    def _item(self, plain: Any) -> Event:
        return Event(*plain)


class ServiceStream(_Stream[ServiceChange]):
    """Changes of services as they happen: an iterator of changes."""

    __slots__ = ()

    def _item(self, plain: Any) -> ServiceChange:
        return ServiceChange(*plain)


class AsyncStream(Generic[Item]):
    """A stream for `async for`. The event loop waits for its file descriptor, without another thread.

    Only one task at a time may wait for an item; another one gets a RuntimeError.
    """

    def __init__(self, stream: _Stream[Item]) -> None:
        self._stream = stream
        self._has_reader = False

    @property
    def dropped(self) -> int:
        """How many values were dropped because the program did not take them in time."""
        return self._stream.dropped

    def close(self) -> None:
        """End the stream."""
        self._stream.close()

    def __aiter__(self) -> AsyncStream[Item]:
        return self

    async def __anext__(self) -> Item:
        while True:
            try:
                item = self._stream.next(timeout=0)
            except Error:
                if self._stream.is_closed:
                    raise StopAsyncIteration from None
                raise
            if item is not None:
                return item
            await self._readable()

    async def _readable(self) -> None:
        import asyncio  # Imported here, because it takes a fifth of the time of `import vdrive`.

        if self._has_reader:
            raise RuntimeError("another task waits for an item of this stream")
        loop = asyncio.get_running_loop()
        ready: asyncio.Future[None] = loop.create_future()
        file = self._stream.fileno()

        def wake() -> None:
            if not ready.done():
                ready.set_result(None)

        loop.add_reader(file, wake)
        self._has_reader = True
        try:
            await ready
        finally:
            self._has_reader = False
            loop.remove_reader(file)

    async def __aenter__(self) -> AsyncStream[Item]:
        return self

    async def __aexit__(self, *exception: object) -> None:
        self.close()
