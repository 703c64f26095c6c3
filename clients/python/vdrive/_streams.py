# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="no-any-return"
"""Status of axes over time, and what else comes without a call."""
from __future__ import annotations

from ._arguments import MOST, Handle, optional_nanoseconds, whole
from ._errors import Error
from ._status import Status
from ._values import Event, Lateness, ServiceChange

TYPE_CHECKING = False  # as typing.TYPE_CHECKING: reading that module takes time
if TYPE_CHECKING:
    import asyncio
    from typing import Any, Generic, Iterator, TypeVar

    from numpy.typing import NDArray
    from typing_extensions import Self

    from ._arguments import NumberSpec

    Item = TypeVar("Item")
else:
    class Generic:
        """Of the annotations: a stream of anything."""

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
        """Samples of the stream lost since the one before."""
        return self._handle.missed

    @property
    def skipped(self) -> int:
        """Ticks since the one before that the tick number jumped over: not run, not lost."""
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
        """Whether it shows the same axes with the same values in the same tick."""
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
        """How late its samples were: a Lateness."""
        return Lateness(*self._handle.lateness())

    def take(self, count: NumberSpec) -> NDArray[Any]:
        """Wait for that many observations, or for those that are left of the count of follow().

        A numpy array of records, a row per sample, a column per axis. What it had received when it
        raised is what the next call returns, at once.
        """
        return self._handle.take(whole("count", count))

    def close(self) -> None:
        """End it."""
        self._handle.close()

    def __iter__(self) -> Iterator[Observation]:
        return self

    def __next__(self) -> Observation:
        return Observation(self._handle.__next__())


class _Stream(Handle, Generic[Item]):
    """What a thread of C++ hands over, bounded: the oldest go first when it is full. An iterator."""

    __slots__ = ("_session",)

    def __init__(self, handle: Any, session: object) -> None:
        super().__init__(handle)
        self._session = session  # keeps the session alive

    def _item(self, plain: Any) -> Item:
        raise NotImplementedError

    @property
    def dropped(self) -> int:
        """The number of dropped values, the oldest first, because the program did not take them."""
        return self._handle.dropped()

    @property
    def is_closed(self) -> bool:
        """Whether it was closed and everything that had arrived has been taken."""
        return self._handle.is_closed()

    def next(self, timeout: float | None = None) -> Item | None:
        """Wait for the next one, at most for `timeout` s; None when none has come.

        Raises Failed after close().
        """
        plain = self._handle.next(optional_nanoseconds("timeout", timeout))
        return None if plain is None else self._item(plain)

    def fileno(self) -> int:
        """Return a file that is readable while a value waits, for select, asyncio and similar."""
        return self._handle.fileno()

    def close(self) -> None:
        """End it."""
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
    """Status of axes as it comes, received by a thread of its own. An iterator of observations."""

    __slots__ = ()

    def _item(self, plain: Any) -> Observation:
        return Observation(plain)

    @property
    def axes(self) -> list[str]:
        """Addresses of the axes, in the order of the columns."""
        return self._handle.axes()

    def take(self, timeout: float | None = None, most: int = MOST) -> NDArray[Any]:
        """Wait for samples, at most for `timeout` s, and take at most `most` of those that are there.

        A numpy array of records, a row per sample, a column per axis.
        """
        return self._handle.take(optional_nanoseconds("timeout", timeout), whole("most", most))


class StatusReports(_Stream[Observation]):
    """The newest state of axes at a rate; use it through on_status()."""

    __slots__ = ()

    def _item(self, plain: Any) -> Observation:
        return Observation(plain)


class EventStream(_Stream[Event]):
    """Events of benches as they come. An iterator of events."""

    __slots__ = ()

    def _item(self, plain: Any) -> Event:
        return Event(*plain)


class ServiceStream(_Stream[ServiceChange]):
    """What happens to services, as it comes. An iterator of changes."""

    __slots__ = ()

    def _item(self, plain: Any) -> ServiceChange:
        return ServiceChange(*plain)


class AsyncStream(Generic[Item]):
    """A stream for `async for`. The event loop waits for the file of the stream: no further thread.

    One task at a time waits for an item; RuntimeError for another one.
    """

    def __init__(self, stream: _Stream[Item]) -> None:
        self._stream = stream
        self._has_reader = False

    @property
    def dropped(self) -> int:
        """How many were dropped because the program did not take them."""
        return self._stream.dropped

    def close(self) -> None:
        """End it."""
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
