# SPDX-License-Identifier: Apache-2.0
"""Streams as iterators of asyncio."""


class AsyncStream:
    """A stream for `async for`. The event loop waits for the file of the stream: no further thread."""

    def __init__(self, stream):
        self._stream = stream

    @property
    def dropped(self):
        """How many were dropped because the program did not take them."""
        return self._stream.dropped

    def close(self):
        """End it."""
        self._stream.close()

    def __aiter__(self):
        return self

    async def __anext__(self):
        while True:
            try:
                item = self._stream.next(timeout=0)
            except StopIteration:
                raise StopAsyncIteration from None
            if item is not None:
                return item
            await self._readable()

    async def _readable(self):
        import asyncio  # Here, because it takes a fifth of the time of `import vdrive`.

        loop = asyncio.get_running_loop()
        ready = loop.create_future()
        file = self._stream.fileno()
        loop.add_reader(file, lambda: ready.done() or ready.set_result(None))
        try:
            await ready
        finally:
            loop.remove_reader(file)

    async def __aenter__(self):
        return self

    async def __aexit__(self, *exception):
        self.close()


def follow_async(self, axes=None, *, capacity=10000):
    """Follow the published status of axes of one bench with `async for`.

    Keeps the newest `capacity` samples. Never steps a lock-step bench.
    """
    return AsyncStream(self.stream(axes, capacity=capacity))


def events_async(self, *, history=False, capacity=10000):
    """Follow the events of benches with `async for`; see events()."""
    return AsyncStream(self.events(history=history, capacity=capacity))
