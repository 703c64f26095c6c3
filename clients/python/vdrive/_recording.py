# SPDX-License-Identifier: Apache-2.0
"""Recordings as numpy arrays."""
from __future__ import annotations

import os

from . import _vdrive
from ._arguments import optional, optional_nanoseconds, real

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any, Iterable

    from numpy import float64, uint64
    from numpy.typing import NDArray

    Path = str | bytes | os.PathLike[str] | os.PathLike[bytes]


class Recording:
    """Status of axes of one bench over time.

    `frames` is a numpy array of records, with a row per sample and a column per axis. Its fields have
    the names of the members of the status (`recording.frames.dtype.names`) and the short names of
    Status. `recording["position"]` is one field, an array of numbers of the same shape. `cut` is the
    place where the file was cut off, or empty. `period` is the length of a tick in s, None if the file
    does not contain it.
    """

    def __init__(self, axes: Iterable[str], names: Iterable[str], frames: NDArray[Any],
                 cut: str = "", period: float | None = None) -> None:
        self.cut = cut
        self.period = period
        self.axes = list(axes)
        self.names = list(names)
        self.frames = frames

    @property
    def ticks(self) -> NDArray[uint64]:
        """The tick of each sample."""
        ticks: NDArray[uint64] = self._of_samples("tick")
        return ticks

    @property
    def time(self) -> NDArray[float64]:
        """The drive time of each sample since the first one [s]."""
        if self.period is None:
            raise ValueError("the file does not contain the period of a tick: load(..., period=0.001)")
        ticks = self.ticks
        since: NDArray[float64] = (ticks - ticks[:1]) * self.period if len(ticks) else ticks * 0.0
        return since

    @property
    def missed(self) -> int:
        """Total number of lost samples."""
        return int(self._of_samples("missed").sum())

    def _of_samples(self, field: str) -> NDArray[Any]:
        """Return a field that is the same for all axes of a sample, as in the record of the first axis."""
        records: NDArray[Any] = self.frames[field]
        return records[:, 0] if records.shape[1] else records.reshape(-1)

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, field: str) -> NDArray[Any]:
        try:
            numbers: NDArray[Any] = self.frames[field]
            return numbers
        except ValueError:
            import difflib

            near = difflib.get_close_matches(str(field), self.frames.dtype.fields or (), n=1,
                                             cutoff=0.5)
            hint = f" (did you mean {near[0]!r}?)" if near else ""
            raise KeyError(f"a recording has no field {field!r}{hint}") from None

    def axis(self, axis: str) -> NDArray[Any]:
        """Return the records of one axis, by its address or name."""
        for column, known in enumerate(zip(self.axes, self.names)):
            if axis in known:
                records: NDArray[Any] = self.frames[:, column]
                return records
        raise KeyError(f"the recording has no axis {axis!r}: {', '.join(self.axes)}")

    def save(self, path: Path) -> None:
        """Write the recording to a file, as `vdrive record` does: .csv, .jsonl or .mcap by the ending.

        load() and `vdrive convert` read it. An existing file is replaced only when the new one is
        complete. .mcap keeps `period`; no format keeps `cut`. Raises ValueError for another ending, no
        sample, ticks that go back, frames of another shape or type, and .mcap without a `period`;
        OSError when the file cannot be written. An existing file is then unchanged.
        """
        import numpy

        name = os.fsdecode(path)
        target = os.path.realpath(name)
        if os.path.exists(target) and not os.path.isfile(target):
            raise OSError(f"cannot write {name!r}: it is not a regular file")
        # In the same directory: a rename is atomic only within one file system.
        temporary = os.path.join(os.path.dirname(target),
                                 f".vdrive.{os.urandom(8).hex()}{os.path.splitext(name)[1]}")
        try:
            _vdrive.write_recording(temporary, self.axes, self.names,
                                    optional_nanoseconds("period", self.period),
                                    numpy.ascontiguousarray(self.frames))
            with open(temporary, "rb") as written:
                os.fsync(written.fileno())
            os.replace(temporary, target)
        except ValueError as error:
            raise ValueError(f"cannot save {name!r}: {error}") from None
        except OSError as error:
            reason = error.strerror or str(error).rpartition(": ")[2]
            raise OSError(f"cannot write {name!r}: {reason}") from None
        finally:
            if os.path.exists(temporary):
                os.unlink(temporary)

    def __repr__(self) -> str:
        return f"<vdrive.Recording of {len(self.axes)} axes, {len(self)} samples>"


def load(path: str | os.PathLike[str], *, bench: int | None = None,
         period: float | None = None) -> Recording:
    """Read a recording of `vdrive record FILE`: .csv, .jsonl or .mcap.

    bench: its number, needed if the recording has several. period: the length of a tick in s, for a
    .csv or .jsonl file, which does not contain it. Raises FileNotFoundError, or another OSError, when the
    file cannot be opened; ValueError when it is not a recording, is damaged or has only other benches.
    An MCAP file that was cut off is read up to its last complete chunk; `cut` of the recording is that
    place.
    """
    bench = optional("bench", bench)
    period = None if period is None else real("period", period)
    if period is not None and not 0.0 < period < float("inf"):
        raise ValueError(f"period = {period!r}: must be a time in s above 0")
    os.close(os.open(path, os.O_RDONLY | os.O_NONBLOCK))  # raises OSError if it cannot be opened
    cut, benches = _vdrive.read_recording(os.fspath(path))
    chosen = [each for each in benches if bench in (None, each[0])]
    if len(chosen) > 1:
        raise ValueError(f"{path}: several benches, choose one by its number: bench=...")
    if benches and not chosen:
        raise ValueError(f"{path}: bench = {bench} is not in it, it has "
                         f"{', '.join(str(each[0]) for each in benches)}")
    if not chosen:
        import numpy  # Imported here, because it takes most of the time of `import vdrive`.

        return Recording([], [], numpy.zeros((0, 0), _vdrive.record_type()), cut, period)
    _, recorded_period, axes, names, frames = chosen[0]
    return Recording(axes, names, frames, cut, recorded_period or period)
