# SPDX-License-Identifier: Apache-2.0
"""Recordings as numpy arrays."""
import os

from . import _vdrive

_ALIASES = {
    "position": "load_position_actual_value",
    "demand": "position_demand_value",
    "following_error": "load_position_error_value",
    "velocity": "load_velocity_actual_value",
    "torque": "torque_actual_value",
    "statusword": "ds402_statusword",
}


class Recording:
    """Status of axes of one bench over time.

    `frames` is a numpy array of records, a row a sample, a column an axis; its fields are named
    after the members of the status (`recording.frames.dtype.names`). `recording["position"]` is
    one of them, an array of numbers of the same shape; the short names of Status are known, too.
    `cut` is the place where a file was cut off; empty for a whole one.
    """

    def __init__(self, axes, names, frames, cut=""):
        self.cut = cut
        self.axes = list(axes)
        self.names = list(names)
        self.frames = frames

    @property
    def ticks(self):
        """The tick of each sample."""
        return self.frames["tick"][:, 0]

    @property
    def missed(self):
        """Samples that were lost, in all."""
        return int(self.frames["missed"][:, 0].sum())

    def __len__(self):
        return len(self.frames)

    def __getitem__(self, field):
        try:
            return self.frames[_ALIASES.get(field, field)]
        except ValueError:
            import difflib

            names = [*_ALIASES, *(self.frames.dtype.names or ())]
            near = difflib.get_close_matches(str(field), names, n=1, cutoff=0.5)
            hint = f" (did you mean {near[0]!r}?)" if near else ""
            raise KeyError(f"a recording has no field {field!r}{hint}") from None

    def axis(self, axis):
        """Return the records of one axis, by its address or name."""
        for column, known in enumerate(zip(self.axes, self.names)):
            if axis in known:
                return self.frames[:, column]
        raise KeyError(f"the recording has no axis {axis!r}: {', '.join(self.axes)}")

    def __repr__(self):
        return f"<vdrive.Recording of {len(self.axes)} axes, {len(self)} samples>"


def load(path, *, bench=None):
    """Read a recording of `vdrive record FILE`: .csv, .jsonl or .mcap.

    bench: its number, where the recording has several. Raises ValueError when the file is not a
    recording, or is damaged. Of an MCAP file that was cut off it reads the whole part; `cut` of the
    recording is the place where it ends.
    """
    cut, benches = _vdrive.read_recording(os.fspath(path))
    chosen = [each for each in benches if bench in (None, each[0])]
    if len(chosen) > 1:
        raise ValueError(f"{path}: several benches, choose one by its number: bench=...")
    if not chosen:
        import numpy  # Here, because it takes most of the time of `import vdrive`.

        return Recording([], [], numpy.zeros((0, 0), _vdrive.record_type()), cut)
    _, axes, names, frames = chosen[0]
    return Recording(axes, names, frames, cut)


def record(self, axes=None, *, ticks, pace="drive"):
    """Record that many samples of axes of one bench; return a Recording.

    With pace "drive" each sample of a lock-step bench is a step of one tick.
    """
    handles = _axes_of(self, axes)
    frames = self.follow(handles, pace=pace).take(ticks)
    return Recording([axis.id for axis in handles], [axis.name for axis in handles], frames)


def _axes_of(session, axes):
    if axes is None:
        return session.axes()
    if isinstance(axes, (str, _vdrive.Axis)):
        axes = [axes]
    return [session.axis(axis) if isinstance(axis, str) else axis for axis in axes]
