# SPDX-License-Identifier: Apache-2.0
"""Streams as iterators of asyncio, and motions and waits that a task awaits."""
from __future__ import annotations

import functools

from . import _vdrive
from ._errors import Error, Failed, Refused

_PATIENCE = 1.0  # s of a cancelled task for the end of its call
_SLICE = 100  # ticks after which a wait for time looks whether it was cancelled

TYPE_CHECKING = False  # as typing.TYPE_CHECKING: reading that module takes time
if TYPE_CHECKING:
    from typing import Any, Callable, Generator, Generic, Protocol, TypeVar

    Item = TypeVar("Item")
    Taken = TypeVar("Taken", covariant=True)

    class Stream(Protocol[Taken]):
        """What an AsyncStream takes its items from."""

        @property
        def dropped(self) -> int: ...
        @property
        def is_closed(self) -> bool: ...
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
            except Error:
                if self._stream.is_closed:
                    raise StopAsyncIteration from None
                raise
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


async def _in_thread(call: Callable[[], Taken], end: Callable[[], object]) -> Taken:
    """Run a call that waits in a thread of its own. When the task is cancelled, `end` ends the call."""
    import asyncio
    import threading

    loop = asyncio.get_running_loop()
    ended: asyncio.Future[Taken] = loop.create_future()

    def run() -> None:
        try:
            report = functools.partial(ended.set_result, call())
        except StopIteration as error:  # no future takes it
            report = functools.partial(ended.set_exception,
                                       RuntimeError(f"the call raised {error!r}"))
        except BaseException as error:
            report = functools.partial(ended.set_exception, error)
        try:
            loop.call_soon_threadsafe(report)
        except RuntimeError:
            pass  # the loop is closed: nobody waits any more

    # A cancelled task does not ask how the call ended: asyncio would complain.
    ended.add_done_callback(lambda future: future.exception())
    # Not of the executor of the loop, which has a few threads: a hundred motions may be awaited.
    threading.Thread(target=run, name="vdrive await", daemon=True).start()
    try:
        await asyncio.wait([ended])  # a cancelled task leaves it as it is
    except asyncio.CancelledError:
        await asyncio.to_thread(end)
        # A wait on a bench that is paused ends when it goes on: the task does not stay for it.
        await asyncio.wait([ended], timeout=_PATIENCE)
        raise
    return ended.result()


async def wait_motion_async(self: _vdrive.Motion, timeout: float = 60.0) -> None:
    """Wait as wait() does; `await motion` is the same. A task that is cancelled halts the axis.

    The axis is left alone when its motion has ended or has given way to another one, and when another
    session has taken the axis. When the axis cannot be halted the task ends with that error.
    """
    def halt() -> None:
        try:
            if self.has_ended():
                return
        except (Failed, Refused):
            return
        self.axis.halt(until="in_force")

    await _in_thread(lambda: self.wait(timeout), halt)


def await_motion(self: _vdrive.Motion) -> Generator[Any, None, None]:
    """Wait as wait_async() does."""
    return wait_motion_async(self).__await__()


async def wait_all_async(self: _vdrive.AxisGroup, *, timeout: float | None = None) -> None:
    """Wait as wait_all() does. A task that is cancelled halts the group: halt_all()."""
    await _in_thread(lambda: self.wait_all(timeout=timeout), lambda: self.halt_all(until="in_force"))


async def wait_until_async(self: _vdrive.Axis, condition: Callable[[_vdrive.Status], bool],
                           timeout: float = 60.0) -> _vdrive.Status:
    """Wait as wait_until() does; the condition is called in another thread.

    Cancelling the task does not stop the axis.
    """
    is_cancelled: list[bool] = []
    return await _in_thread(
        lambda: self.wait_until(lambda status: bool(is_cancelled) or condition(status), timeout),
        lambda: is_cancelled.append(True))


async def wait_async(self: _vdrive.Session, duration: float, *, bench: int | None = None) -> int:
    """Wait for drive time, as wait() does. Cancelling the task stops no axis."""
    nanoseconds = _vdrive.nanoseconds("duration", duration)
    is_cancelled: list[bool] = []

    def wait() -> int:
        there = self.find_bench(bench)
        now = self.wait(0.0, bench=there.number)
        end = now - -nanoseconds // round(there.period * 1e9)
        while now < end and not is_cancelled:
            now = self.wait_for_tick(min(end, now + _SLICE), bench=there.number)
        return now

    return await _in_thread(wait, lambda: is_cancelled.append(True))
