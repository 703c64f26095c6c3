# SPDX-License-Identifier: Apache-2.0
"""Calls that a task awaits."""
from __future__ import annotations

import functools

_PATIENCE = 1.0  # s of a cancelled task for the end of its call

TYPE_CHECKING = False  # as typing.TYPE_CHECKING: reading that module takes time
if TYPE_CHECKING:
    import asyncio
    from typing import Callable, TypeVar

    Result = TypeVar("Result")


async def in_thread(call: Callable[[], Result], end: Callable[[], object]) -> Result:
    """Run a call that waits in a thread of its own. When the task is cancelled, `end` ends the call."""
    import asyncio
    import threading

    loop = asyncio.get_running_loop()
    ended: asyncio.Future[Result] = loop.create_future()

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
