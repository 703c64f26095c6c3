# SPDX-License-Identifier: Apache-2.0
"""Recordings as numpy arrays."""
import csv
import os

import numpy

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
        return self.frames[_ALIASES.get(field, field)]

    def axis(self, axis):
        """Return the records of one axis, by its address or name."""
        for column, known in enumerate(zip(self.axes, self.names)):
            if axis in known:
                return self.frames[:, column]
        raise KeyError(f"the recording has no axis {axis!r}: {', '.join(self.axes)}")

    def __repr__(self):
        return f"<vdrive.Recording of {len(self.axes)} axes, {len(self)} samples>"


def _owner(text):
    return int(text, 16) if text else 0


def _number(field, text):
    return _owner(text) if field == "owner" else int(text)


def _records_of(rows, header, kind):
    """Return one array of records for the rows of an axis."""
    fields = [(name, header.index(name)) for name in kind.names if name in header]
    records = numpy.zeros(len(rows), kind)
    for name, column in fields:
        records[name] = [_number(name, row[column]) for row in rows]
    return records


def load(path, *, bench=None):
    """Read a recording of `vdrive record FILE`: .csv, .jsonl or .mcap.

    bench: its number, where the recording has several. Raises ValueError when the file is not a
    recording, or is damaged. Of an MCAP file that was cut off it reads the whole part; `cut` of the
    recording is the place where it ends.
    """
    if os.fspath(path).lower().endswith(".csv"):
        return _load_csv(path, bench)
    cut, benches = _vdrive.read_recording(os.fspath(path))
    chosen = [each for each in benches if bench in (None, each[0])]
    if len(chosen) > 1:
        raise ValueError(f"{path}: several benches, choose one by its number: bench=...")
    if not chosen:
        return Recording([], [], numpy.zeros((0, 0), _vdrive.record_type()), cut)
    _, axes, names, frames = chosen[0]
    return Recording(axes, names, frames, cut)


def _load_csv(path, bench):
    by_axis, names = {}, {}
    with open(path, newline="", encoding="utf-8") as file:
        reader = csv.reader(file)
        header = next(reader, [])
        if header[:4] != ["axis", "name", "tick", "missed"]:
            raise ValueError(f"{path}: no recording of `vdrive record FILE.csv`")
        for row in reader:
            if len(row) != len(header):
                raise ValueError(f"{path}:{reader.line_num}: {len(row)} columns of {len(header)}")
            if bench is None or row[0].split(".")[0] == str(bench):
                by_axis.setdefault(row[0], []).append(row)
                names[row[0]] = row[1]
    if len({axis.split(".")[0] for axis in by_axis}) > 1:
        raise ValueError(f"{path}: several benches, choose one by its number: bench=...")
    kind = _vdrive.record_type()
    columns = [_records_of(rows, header, kind) for rows in by_axis.values()]
    if any(not numpy.array_equal(column["tick"], columns[0]["tick"]) for column in columns):
        raise ValueError(f"{path}: its axes have different ticks")
    frames = numpy.stack(columns, axis=1) if columns else numpy.zeros((0, 0), kind)
    return Recording(by_axis, names.values(), frames)


def record(self, axes=None, *, ticks, pace="drive"):
    """Record that many samples of axes of one bench; return a Recording.

    With pace "drive" each sample of a lock-step bench is a step of one tick.
    """
    handles = _axes_of(self, axes)
    samples = self.follow(handles, pace=pace, count=ticks)
    frames = [sample.array() for sample in samples]
    kind = _vdrive.record_type()
    table = numpy.stack(frames) if frames else numpy.zeros((0, len(handles)), kind)
    return Recording([axis.id for axis in handles], [axis.name for axis in handles], table)


def _axes_of(session, axes):
    if axes is None:
        return session.axes()
    if isinstance(axes, (str, _vdrive.Axis)):
        axes = [axes]
    return [session.axis(axis) if isinstance(axis, str) else axis for axis in axes]
