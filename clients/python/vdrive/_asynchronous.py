# SPDX-License-Identifier: Apache-2.0
"""Calls that a task awaits."""
from __future__ import annotations

import functools

_PATIENCE = 1.0  # s that a cancelled task waits for its call to end

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    import asyncio
    from typing import Callable, TypeVar

    Result = TypeVar("Result")


async def in_thread(call: Callable[[], Result], end: Callable[[], object]) -> Result:
    """Run a waiting call in its own thread. When the task is cancelled, `end` ends the call."""
    import asyncio
    import threading

    loop = asyncio.get_running_loop()
    ended: asyncio.Future[Result] = loop.create_future()

    def run() -> None:
        try:
            report = functools.partial(ended.set_result, call())
        except StopIteration as error:  # a future does not accept it
            report = functools.partial(ended.set_exception,
                                       RuntimeError(f"the call raised {error!r}"))
        except BaseException as error:
            report = functools.partial(ended.set_exception, error)
        try:
            loop.call_soon_threadsafe(report)
        except RuntimeError:
            pass  # the loop is closed: nobody waits any more

    # Retrieve the exception: a cancelled task does not, and asyncio would complain.
    ended.add_done_callback(lambda future: future.exception())
    # Not on the executor of the loop, which has few threads: a hundred motions may be awaited.
    threading.Thread(target=run, name="vdrive await", daemon=True).start()
    try:
        await asyncio.wait([ended])  # does not cancel it with the task
    except asyncio.CancelledError:
        await asyncio.to_thread(end)
        # Limited, because a wait on a paused bench ends only when the bench continues.
        await asyncio.wait([ended], timeout=_PATIENCE)
        raise
    return ended.result()
