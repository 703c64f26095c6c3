# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="no-any-return"
"""The drive alone: a bank of axes that the program steps itself."""
from __future__ import annotations

from . import _vdrive
from ._arguments import (
    Handle,
    dictionary,
    is_number,
    nanoseconds,
    object_number,
    real,
    shown,
    value_of_object,
    whole,
)
from ._errors import ConfigurationError

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any, Mapping, Sequence, overload

    import numpy
    from numpy.typing import ArrayLike, NDArray

    from ._arguments import NumberSpec, ObjectSpec

    ModelSpec = Mapping[str, str | float]
else:
    def overload(function):
        """Replace typing.overload, which only type checkers need."""
        return function

_MOST_AXES = 1_000_000


def _is_one(axis: Any) -> bool:
    """Return whether this is the number of one axis; an array with one number is not."""
    return isinstance(axis, int) or hasattr(axis, "__index__") and not hasattr(axis, "__len__")


def _axis(axis: Any) -> int:
    return whole("axis", axis, -2**63)  # the bank checks the upper limit


def _axes(axes: Any) -> NDArray[numpy.int64] | None:
    return None if axes is None else _integers("axis", axes)


def _integers(name: str, values: Any) -> NDArray[numpy.int64]:
    """Return a whole number, or one row of whole numbers, as an array."""
    import numpy

    if type(values) is int and -2**63 <= values < 2**63:
        return numpy.array(values, numpy.int64)
    try:
        row = numpy.asarray(values)
    except ValueError:  # rows of different lengths
        row = numpy.empty((0, 0))
    if row.ndim == 1 and row.size == 0:
        return numpy.empty(0, numpy.int64)
    if row.ndim <= 1 and row.dtype.kind in "iuf":
        # Checked in its own type first: numpy would truncate a fraction.
        if row.dtype.kind == "i" or (
                (numpy.floor(row) == row) & (row >= -2.0**63) & (row < 2.0**63)).all():
            return numpy.ascontiguousarray(row, numpy.int64).reshape(row.shape)
    raise TypeError(f"{name} = {shown(values)}: must be a whole number or one row of whole numbers")


def _model(keys: Any) -> dict[str, Any]:
    """Return a model with its numbers as floats; the C++ module checks the keys."""
    return {key if isinstance(key, str) else shown(key): each if isinstance(each, str)
            else real("", each) if is_number(each) and key not in ("coupling", "feedback")
            else shown(each) for key, each in dict(keys).items()}


def _models(model: Any, axes: int) -> list[dict[str, Any]]:
    """Return one model for all axes, one for each, or none."""
    if model is None:
        return []
    if isinstance(model, dict):
        return [_model(model)]
    if not hasattr(model, "__getitem__") or not hasattr(model, "__len__") or len(model) != axes:
        raise ConfigurationError(f"model is a dict for all axes or a sequence of {axes} dicts")
    return [_model(each) for each in model]


class AxisBank(Handle):
    """Servo drives without a service, clock and network: the caller writes objects and steps.

    Only one thread at a time may use a bank.
    """

    __slots__ = ()

    def __init__(self, axes: NumberSpec, *, period: float = 0.001,
                 model: ModelSpec | Sequence[ModelSpec] | None = None,
                 parameters: Mapping[ObjectSpec, int] = {}) -> None:
        """Create `axes` axes and power them up.

        `period`: length of a tick, 125 us to 10 ms, in s. `model`: a dict for all axes, or a sequence
        with one per axis, with the keys of `model` in a configuration. `parameters`: values of objects
        at power-up.
        """
        try:
            count = whole("axes", axes, 1, _MOST_AXES)
        except ValueError as error:
            raise ConfigurationError(str(error)) from None
        values = [(object_number(object), value_of_object(value))
                  for object, value in dictionary("parameters", parameters).items()]
        super().__init__(_vdrive.AxisBank(count, nanoseconds("period", period),
                                          _models(model, count), values))

    def __len__(self) -> int:
        return self._handle.size()

    @property
    def period(self) -> float:
        """Length of a tick, in s."""
        return self._handle.period()

    @property
    def tick(self) -> int:
        """Ticks since the bank was made."""
        return self._handle.tick()

    @property
    def status(self) -> NDArray[Any]:
        """The status image of each axis after the last tick.

        A read-only numpy array of records, with a field for each member. It is a view of the memory of
        the bank: a step, a power cycle and restore() change its values; those of a copy() stay. The
        array keeps the bank alive. Do not read it while another thread steps.
        """
        return self._handle.status()

    def status_hash(self) -> int:
        """Return a hash of all status images, to compare runs."""
        return self._handle.status_hash()

    def write(self, axis: int | ArrayLike | None, object: ObjectSpec,
              value: int | ArrayLike) -> None:
        """Write an object of one axis or of several; it takes effect immediately.

        `axis`: a number from 0, a row of numbers, or None for all axes. For several axes `value` is one
        value for all of them or a row with one per axis. Refused is raised for the first axis that
        refuses; the axes before it have been written.
        """
        number = object_number(object)
        if _is_one(axis):
            self._handle.write(_axis(axis), number, value_of_object(value))  # type: ignore[arg-type]
        else:
            self._handle.write_each(_axes(axis), number, _integers("value", value))

    @overload
    def read(self, axis: int, object: ObjectSpec) -> int: ...
    @overload
    def read(self, axis: Sequence[int] | NDArray[Any] | None,
             object: ObjectSpec) -> NDArray[numpy.int64]: ...
    def read(self, axis: Any, object: ObjectSpec) -> Any:
        """Read an object of one axis, or an array with the values of several. Arguments as in write()."""
        number = object_number(object)
        if _is_one(axis):
            return self._handle.read(_axis(axis), number)
        return self._handle.read_each(_axes(axis), number)

    def step(self, ticks: NumberSpec = 1) -> int:
        """Step every axis. Return the tick. Ctrl-C ends the call between two ticks."""
        return self._handle.step(whole("ticks", ticks))

    def set_load_noise(self, axis: int | ArrayLike | None, rms: float, seed: int = 0) -> None:
        """Add white noise to the load torque of an axis, or of several, from the next tick on.

        `rms` in N.m at the load, 0 = none. Each axis gets its own sequence with a new value each tick,
        which the seed determines. The noise is part of a snapshot.
        """
        noise = real("rms", rms, "N.m")
        if not 0.0 <= noise <= _vdrive.LARGEST_LOAD_NOISE:
            raise ValueError(f"rms = {shown(rms)}: must be from 0 to "
                             f"{_vdrive.LARGEST_LOAD_NOISE:g} N.m")
        axes = _axis(axis) if _is_one(axis) else axis
        self._handle.set_load_noise(_axes(axes), noise, whole("seed", seed))

    def power_cycle(self, axis: NumberSpec) -> None:
        """Switch an axis off and on again: the position stays, faults are gone."""
        self._handle.power_cycle(_axis(axis))

    def snapshot(self) -> bytes:
        """Return the whole state as bytes, for restore()."""
        return self._handle.snapshot()

    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot of this bank, or of one made with the same arguments.

        It must be from the same version of vdrive. Raises ValueError with the reason if it cannot be restored.
        """
        if not isinstance(snapshot, bytes):
            raise TypeError(f"snapshot = {shown(snapshot)}: must be bytes")
        self._handle.restore(snapshot)
