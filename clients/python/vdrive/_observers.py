# SPDX-License-Identifier: Apache-2.0
"""Observers: functions that are called with events, changes of services and states of axes."""
from __future__ import annotations

import atexit
import os
import sys
import threading
import time
import weakref

# Imported first, because it registers the function that ends the sessions: see _close_all below.
from . import _vdrive  # noqa: F401

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any, Callable, Iterator, Protocol, Sequence

    class Stream(Protocol):
        """The source of the items of an Observer."""

        def __iter__(self) -> Iterator[Any]: ...
        def close(self) -> None: ...

_running: weakref.WeakSet[Observer] = weakref.WeakSet()

_PATIENCE_AT_EXIT = 1.0

# The threads of observers that have not ended, and which thread is waiting for which.
_changed = threading.Condition()
_alive: set[threading.Thread] = set()
_waits_for: dict[threading.Thread, threading.Thread] = {}


def _wait_for(thread: threading.Thread, patience: float | None = None) -> None:
    """Wait until a thread ends, at most for `patience`; does not wait for one that waits for the caller."""
    caller = threading.current_thread()

    def is_in_a_circle() -> bool:
        other: threading.Thread | None = thread
        while other is not None and other is not caller:
            other = _waits_for.get(other)
        return other is caller

    with _changed:
        before = _waits_for.get(caller)  # set if a signal handler closes another observer during a wait
        _waits_for[caller] = thread
        try:
            _changed.wait_for(lambda: thread not in _alive or is_in_a_circle(), patience)
        finally:
            if before is None:
                del _waits_for[caller]
            else:
                _waits_for[caller] = before


def check_function(function: object) -> None:
    if not callable(function):
        raise TypeError(f"function = {function!r}: must be callable")


class Observer:
    """Calls a function from Python threads, until close() or the end of the session.

    `threading.excepthook` reports an exception in the function, and the calls continue. When the calls
    end because a bench is lost, `error` is the exception, and `on_end(error)` is called; without
    `on_end`, `threading.excepthook` reports it.
    """

    def __init__(self, function: Callable[[Any], object], streams: Sequence[Stream],
                 on_end: Callable[[Exception], object] | None = None) -> None:
        check_function(function)
        if on_end is not None and not callable(on_end):
            raise TypeError(f"on_end = {on_end!r}: must be callable")
        self._process = os.getpid()
        self._function = function
        self._streams = streams
        self._on_end = on_end
        self._error: Exception | None = None
        self._closed = threading.Event()
        self._threads = [threading.Thread(target=self._run, args=(stream,), daemon=True,
                                          name="vdrive observer") for stream in streams]
        with _changed:
            _running.add(self)
        for thread in self._threads:
            self._start(thread)

    def __repr__(self) -> str:
        return "<vdrive.Observer>"

    @property
    def error(self) -> Exception | None:
        """The exception that ended the calls, the last one if there are several; None while they continue."""
        return self._error

    def close(self) -> None:
        """End the calls. Waits for a call in progress, unless that call itself calls close() or waits for this thread.

        Does nothing in a forked process: the threads belong to the parent.
        """
        if self._process != os.getpid():
            return
        self._end()
        for thread in self._threads:
            _wait_for(thread)

    def _end(self) -> None:
        """End the calls, without waiting for one in progress."""
        self._closed.set()
        for stream in self._streams:
            stream.close()

    @staticmethod
    def _start(thread: threading.Thread) -> None:
        with _changed:
            thread.start()
            _alive.add(thread)  # in time: the thread cannot end before this, because its end needs the lock

    def _run(self, stream: Stream) -> None:
        try:
            self._observe(stream)
        finally:
            with _changed:
                _alive.discard(threading.current_thread())
                _changed.notify_all()

    def _observe(self, stream: Stream) -> None:
        try:
            for item in stream:
                if self._closed.is_set():
                    return
                self._call(self._function, item)
        except Exception as error:  # the source failed, for example because a service is lost
            self._error = error
            if self._on_end is None:
                self._report()
            else:
                self._call(self._on_end, error)

    def _call(self, function: Callable[[Any], object], argument: Any) -> None:
        try:
            function(argument)
        except BaseException:  # also SystemExit, which would end the thread of the package
            self._report()

    @staticmethod
    def _report() -> None:
        threading.excepthook(threading.ExceptHookArgs((*sys.exc_info(), threading.current_thread())))

    def __enter__(self) -> Observer:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _close_all() -> None:
    """End all observers at exit. Calls still in progress end with the sessions, which are closed after this."""
    with _changed:
        observers = list(_running)
    for observer in observers:
        observer._end()
    end = time.monotonic() + _PATIENCE_AT_EXIT
    for observer in observers:
        for thread in observer._threads:
            _wait_for(thread, max(0.0, end - time.monotonic()))


# A forked process has none of these threads.
def _forget_threads_of_parent() -> None:
    global _changed
    _changed = threading.Condition()
    _running.clear()
    _alive.clear()
    _waits_for.clear()


os.register_at_fork(after_in_child=_forget_threads_of_parent)
# Exit functions run in reverse order of registration: this one runs before the sessions are closed.
atexit.register(_close_all)
