# SPDX-License-Identifier: Apache-2.0
"""Functions that are called with events and states of axes."""
import atexit
import sys
import threading
import weakref

from . import _vdrive  # noqa: F401  It registers the end of the sessions, which ours comes before.

_running = weakref.WeakSet()


class Observer:
    """Calls a function from threads of Python, until close() or the end of the session.

    What the function raises is reported by `threading.excepthook`, and the calls continue.
    """

    def __init__(self, function, streams, period=0.0):
        self._function = function
        self._streams = streams
        self._period = period
        self._closed = threading.Event()
        self._threads = [threading.Thread(target=self._run, args=(stream,), daemon=True,
                                          name="vdrive observer") for stream in streams]
        _running.add(self)
        for thread in self._threads:
            thread.start()

    def close(self):
        """End the calls; one that runs ends first, unless it is the caller."""
        self._closed.set()
        for stream in self._streams:
            stream.close()
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join()

    def _run(self, stream):
        try:
            for item in stream:
                if self._closed.is_set():
                    return
                self._call(item)
                if self._period and self._closed.wait(self._period):
                    return
        except Exception:  # the source failed: a service that is lost
            self._report()

    def _call(self, item):
        try:
            self._function(item)
        except Exception:
            self._report()

    @staticmethod
    def _report():
        threading.excepthook(threading.ExceptHookArgs((*sys.exc_info(), threading.current_thread())))

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()


def _close_all():
    for observer in list(_running):
        observer.close()


# Functions run in the reverse order of their registration: this one before the end of the sessions.
atexit.register(_close_all)


def on_event(self, observer, *, history=False):
    """Call `observer(event)` for each event, from now on; return the Observer.

    With `history` from the oldest event on that each bench still has; without it, of benches that
    the session has found. It takes the place of events() and of the observer before: a session has
    one stream of events.
    """
    return Observer(observer, [self.events(history=history)])


def on_status(self, observer, axes=None, *, period=0.1):
    """Call `observer(observation)` with the newest state of axes; return the Observer.

    For each bench at most once in `period` s of wall time, when a later tick has come.
    """
    if not period > 0.0:
        raise ValueError("the period is above 0 s")
    handles = self.axes() if axes is None else [axes] if not isinstance(axes, (list, tuple)) else axes
    benches = {}
    for axis in handles:
        handle = self.axis(axis) if isinstance(axis, str) else axis
        benches.setdefault(handle.bench, []).append(handle)
    return Observer(observer, [self.stream(each, capacity=1) for each in benches.values()], period)
