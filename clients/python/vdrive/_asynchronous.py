# SPDX-License-Identifier: Apache-2.0
"""Streams as iterators of asyncio."""
from __future__ import annotations

TYPE_CHECKING = False  # as typing.TYPE_CHECKING: reading that module takes time
if TYPE_CHECKING:
    from typing import Generic, Protocol, TypeVar

    from . import _vdrive

    Item = TypeVar("Item")
    Taken = TypeVar("Taken", covariant=True)

    class Stream(Protocol[Taken]):
        """What an AsyncStream takes its items from."""

        @property
        def dropped(self) -> int: ...
        def next(self, timeout: float | None = None) -> Taken | None: ...
        def fileno(self) -> int: ...
        def close(self) -> None: ...
else:
    class Generic:
        """Of the annotations: a stream of anything."""

        def __class_getitem__(cls, item):
            return cls

    Item = None


class AsyncStream(Generic[Item]):
    """A stream for `async for`. The event loop waits for the file of the stream: no further thread.

    One task at a time waits for an item; RuntimeError for another one.
    """

    def __init__(self, stream: Stream[Item]) -> None:
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
            except StopIteration:
                raise StopAsyncIteration from None
            if item is not None:
                return item
            await self._readable()

    async def _readable(self) -> None:
        import asyncio  # Here, because it takes a fifth of the time of `import vdrive`.

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


def follow_async(self: _vdrive.Session, axes: _vdrive.AxesSpec = None, *,
                 capacity: int = 10000) -> AsyncStream[_vdrive.Observation]:
    """Follow the published status of axes of one bench with `async for`.

    Keeps the newest `capacity` samples. Never steps a lock-step bench.
    """
    return AsyncStream(self.stream(axes, capacity=capacity))


def events_async(self: _vdrive.Session, *, history: bool = False,
                 capacity: int = 10000) -> AsyncStream[_vdrive.Event]:
    """Follow the events of benches with `async for`; see events()."""
    return AsyncStream(self.events(history=history, capacity=capacity))
