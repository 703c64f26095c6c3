# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="no-any-return"
"""Checks of arguments: an error names the argument, its value and what it must be."""
from __future__ import annotations

import math
import operator

from . import _vdrive

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any, Callable, Literal, NoReturn, SupportsFloat, SupportsIndex

    NumberSpec = SupportsIndex | SupportsFloat  # an integer, unless it has a unit
    ObjectSpec = int | tuple[int, int] | str
    UntilSpec = Literal["done", "in_force"]
    PaceSpec = Literal["drive", "observe"]
    KeepAliveSpec = Literal["own_thread", "user_frames"]

MOST = 2**63 - 1  # largest count
_LONGEST = 3_200_000_000  # [s] 100 years: longer than any wait, and fits in nanoseconds
_SHOWN = 64  # characters of a value


class Handle:
    """A public object that wraps one of the C++ module."""

    __slots__ = ("__weakref__", "_handle")

    def __init__(self, handle: Any) -> None:
        self._handle = handle

    def __repr__(self) -> str:
        return f"<vdrive.{type(self).__name__}>"

    if not TYPE_CHECKING:  # otherwise every name would count as an attribute
        def __getattr__(self, name):
            if name == "_handle":
                raise TypeError(f"{type(self).__name__}.__init__() was not called")
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __reduce__(self) -> NoReturn:
        raise TypeError(f"cannot pickle {self!r}")


def shown(value: object) -> str:
    """Return the value as a program would write it, shortened, on one line."""
    text = "".join(each if each.isprintable() else ascii(each)[1:-1] for each in repr(value))
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN - _SHOWN // 4]}...{text[-_SHOWN // 4:]}"


def is_number(value: object) -> bool:
    """Return whether the value is a single number, not a truth value (of numpy either) or an array.

    A member of an IntFlag has a length (__len__), but is a number.
    """
    if type(value).__name__ in ("bool", "bool_"):
        return False
    return isinstance(value, int) or not hasattr(value, "__len__") and (
        hasattr(value, "__index__") or hasattr(value, "__float__"))


def real(name: str, value: Any, unit: str = "") -> float:
    """Return the number, which may be infinite or NaN."""
    if not is_number(value):
        raise TypeError(f"{name} = {shown(value)}: must be a number{unit and ' of ' + unit}")
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _rounded(number: float) -> int | None:
    """Return the nearest whole number, halves away from 0; None for infinity and NaN."""
    if not math.isfinite(number):
        return None
    whole = math.trunc(number)
    return whole + round(math.copysign(1, number)) if abs(number - whole) >= 0.5 else whole


def whole(name: str, value: Any, lowest: int = 0, highest: int = MOST, unit: str = "",
          given: tuple[str, float] | None = None) -> int:
    """Return a whole number in this range, whose limits are in `unit`.

    given: name and size of the unit that the program uses; then the number is converted and rounded.
    """
    if type(value) is int and given is None and lowest <= value <= highest:
        return value
    limits = f"from {lowest} to {highest}{unit and ' ' + unit}"
    if not is_number(value):
        raise TypeError(f"{name} = {shown(value)}: must be a "
                        f"{'number' if given else 'whole number ' + limits}")
    number: int | None
    if given is not None:
        number = _rounded(real(name, value) * given[1])
    elif hasattr(value, "__index__"):
        number = operator.index(value)
    else:
        number = _rounded(float(value))
        if number is not None and number != float(value):
            raise ValueError(f"{name} = {shown(value)}: must be a whole number {limits}")
    if number is None or not lowest <= number <= highest:
        raise ValueError(f"{name} = {shown(value)}{' ' + given[0] if given else ''}: must be {limits}")
    return number


def optional(name: str, value: Any, lowest: int = 0, highest: int = MOST, unit: str = "",
             given: tuple[str, float] | None = None) -> int | None:
    """Return whole(), or None for None."""
    return None if value is None else whole(name, value, lowest, highest, unit, given)


def bench_number(value: Any, name: str = "bench") -> int | None:
    """Return the number of a bench, or None."""
    return None if value is None else whole(name, value, 0, 2**32 - 1)


def nanoseconds(name: str, value: Any) -> int:
    """Return a time in ns. value: in s, 0 to 100 years."""
    seconds = real(name, value, "seconds")
    if 0.0 <= seconds <= _LONGEST:
        return round(seconds * 1e9)
    raise ValueError(f"{name} = {shown(value)}: must be from 0 to {_LONGEST} seconds")


def optional_nanoseconds(name: str, value: Any) -> int | None:
    """Return nanoseconds(), or None for None."""
    return None if value is None else nanoseconds(name, value)


def is_utf8(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def text(name: str, value: Any) -> str:
    """Return a text, which may be given as UTF-8 bytes."""
    try:
        if isinstance(value, bytes):
            return value.decode()
    except UnicodeDecodeError:
        pass
    if isinstance(value, str) and is_utf8(value):
        return value
    raise TypeError(f"{name} = {shown(value)}: must be a string")


def texts(name: str, value: Any) -> list[str]:
    if isinstance(value, (str, bytes, dict)) or not hasattr(value, "__getitem__"):
        raise TypeError(f"{name} = {shown(value)}: must be a list of strings")
    try:
        return [text(name, each) for each in value]
    except TypeError:
        raise TypeError(f"{name} = {shown(value)}: must be a list of strings") from None


def word(name: str, value: Any, first: str, *others: str) -> str:
    """Return the value, which must be one of these words."""
    word = text(name, value)
    if word == first or word in others:
        return word
    words = [f'"{each}"' for each in (first, *others)]
    raise ValueError(f"{name} is {', '.join(words[:-1])} or {words[-1]}, not {shown(word)}")


def observes(pace: PaceSpec) -> bool:
    """Return whether a follower only takes what is published and never steps a bench."""
    return word("pace", pace, "drive", "observe") == "observe"


def call_options(timeout: Any, until: UntilSpec) -> tuple[int, bool]:
    """Return the time-out, and whether the call waits only until the command is in force."""
    return nanoseconds("timeout", timeout), word("until", until, "done", "in_force") == "in_force"


def truth(name: str, value: Any) -> bool:
    if value is None or hasattr(type(value), "__bool__"):
        return bool(value)
    raise TypeError(f"{name} = {shown(value)}: must be True or False")


def function(name: str, value: Callable[..., Any]) -> Callable[..., Any]:
    if callable(value):
        return value
    raise TypeError(f"{name} = {shown(value)}: must be a function")


def dictionary(name: str, value: Any, of: str = "") -> dict[Any, Any]:
    if isinstance(value, dict):
        return value
    raise TypeError(f"{name} = {shown(value)}: must be a dict{of}")


def instance(name: str, value: Any, kind: type) -> Any:
    """Return an object of a class of this package."""
    if isinstance(value, kind):
        return value
    raise TypeError(f"{name} = {shown(value)}: must be a vdrive.{kind.__name__}")


def is_iterable(values: object) -> bool:
    """Return whether iter() accepts the values; hasattr() would miss __getitem__ and arrays without a dimension."""
    try:
        iter(values)  # type: ignore[call-overload]
    except TypeError:
        return False
    return True


def row(name: str, values: Any, check: Callable[[str, Any], Any]) -> list[Any]:
    """Return the result of `check` for each value; an error names its place, such as "targets[1]"."""
    if not is_iterable(values):
        raise TypeError(f"{name} = {shown(values)}: must be a sequence")
    return [check(f"{name}[{place}]", value) for place, value in enumerate(values)]


def object_number(object: ObjectSpec) -> int:
    """Return the index and sub-index of an object as one number, as the C++ module takes it."""
    if isinstance(object, str):
        return _vdrive.object_named(text("object", object))
    if isinstance(object, tuple):
        if len(object) != 2:
            raise ValueError(f"an object is (index, subindex), not {shown(object)}")
        return whole("index", object[0], 0, 0xFFFF) << 8 | whole("sub-index", object[1], 0, 0xFF)
    if not is_number(object):
        raise TypeError(f"object = {shown(object)}: must be an index, (index, subindex), or a name")
    return whole("index", object, 0, 0xFFFF) << 8


def value_of_object(value: NumberSpec) -> int:
    return whole("value", value, -2**63, MOST)
