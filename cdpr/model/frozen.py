"""Immutable data, also after copying, its arrays, and checks of arguments."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any, ClassVar, NoReturn, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.base.colours import coloured
from cdpr.base.errors import CdprError
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.native.arrays import DEEPEST, MASKED, masked, real

Array = NDArray[np.float64]
Value = TypeVar("Value")
Number = TypeVar("Number", bound=np.generic)


class Frozen:
    """Mixin of frozen dataclasses: equal if all values are, and with read-only arrays.

    Arrays in attributes, or in mappings there, are also read-only in copies and unpickled objects. (Numpy does not:
    pickled or copied arrays are writeable.)
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def replace(self, **changes: Any) -> Self:
        """Return a copy with other values, checked like those of the constructor.

        Raises:
            CdprError: if a value is wrong or unknown.
        """
        known = [each.name for each in fields(self)]
        for name in changes:
            if name not in known:
                hint = did_you_mean(name, known)
                raise CdprError(f"{type(self).__name__}({name}=): unknown: {hint}allowed: {', '.join(known)}")
        return replace(self, **changes)

    def __eq__(self, other: object) -> bool:
        return equal(self, other) if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        values = (getattr(self, each.name) for each in fields(self))
        return hash((type(self).__name__, *(value for value in values if isinstance(value, str | int | None))))

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            for array in value.values() if isinstance(value, dict) else (value,):
                if isinstance(array, np.ndarray):
                    array.flags.writeable = False
        self.__dict__.update(state)


class FrozenDict(dict[str, Value]):
    """Dictionary that cannot be changed; copies of it neither."""

    def _refuse(self, *arguments: Any, **values: Any) -> NoReturn:
        raise TypeError("this mapping cannot be changed: `replace` of its object returns a changed copy")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return FrozenDict, (dict(self),)


def equal(one: Any, other: Any) -> bool:
    """Return True if two pieces of data are equal; NaN equals NaN."""
    if one is other:
        return True
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        alike = isinstance(one, np.ndarray) and isinstance(other, np.ndarray) and one.dtype == other.dtype
        return alike and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(equal(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(equal, one, other))
    if isinstance(one, Frozen) and type(one) is type(other) and is_dataclass(one):
        return all(equal(getattr(one, each.name), getattr(other, each.name)) for each in fields(one))
    if isinstance(one, float) and isinstance(other, float) and math.isnan(one) and math.isnan(other):
        return True
    return bool(one == other)


def frozen_array(values: Sequence[float] | Sequence[Sequence[float]] | Array) -> Array:
    """Return a read-only, C-contiguous float64 copy of `values`.

    Raises:
        CdprError: if some are masked.
    """
    if masked(values):
        raise CdprError(MASKED)
    array = np.array(values, dtype=np.float64, order="C")
    array.flags.writeable = False
    return array


def read_only(array: NDArray[Number]) -> NDArray[Number]:
    """Return a read-only view of `array`."""
    view = array.view()
    view.flags.writeable = False
    return view


def given_array(values: ArrayLike, shape: tuple[int | None, ...], name: str) -> Array:
    """Return an argument as read-only copy of a shape, in which None is any size.

    Raises:
        CdprError: with the argument's name, if they are no finite numbers or have another shape.
    """
    array: Array = values if type(values) is np.ndarray and values.dtype == np.float64 else given_real(values, name)
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape, strict=True)):
        sizes = " x ".join("any number" if size is None else str(size) for size in shape)
        raise CdprError(f"{name}: expected {sizes} numbers, got {shape_of(array)}")
    # a finite sum, which is fast to compute, proves that all numbers are finite
    if not (array.ndim == 1 and math.isfinite(sum(array.tolist()))) and not np.isfinite(array).all():
        bad = array[~np.isfinite(array)][0]
        raise CdprError(f"{name}: expected finite numbers, got {bad}")
    copied = array.copy()
    copied.flags.writeable = False
    return copied


def given_real(values: ArrayLike, name: str) -> Array:
    """Return an argument as float64 of any shape; raise CdprError with the argument's name unless they are numbers."""
    if isinstance(values, list | tuple) and _has_booleans(values):
        raise CdprError(f"{name}: expected real numbers, got True or False")
    return real(values, name)


def _has_booleans(values: Any, depth: int = DEEPEST) -> bool:
    if isinstance(values, list | tuple):
        return depth > 0 and any(_has_booleans(each, depth - 1) for each in values)
    return type(values) is bool


def shape_of(array: Array) -> str:
    """Return the shape of an argument as text."""
    return " x ".join(map(str, array.shape)) if array.shape else "one number"


def given_number(
    value: Any, name: str, *, least: float = -math.inf, above: float = -math.inf, finite: bool = True
) -> float:
    """Return an argument as number.

    Raises:
        CdprError: with the argument's name, unless it is a number in this range.
    """
    if isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = math.nan
        if number >= least and number > above and (not finite or number < math.inf):
            return number
    wanted = "a number" + (f" greater than {above:g}" if above > -math.inf else "")
    wanted += f" of at least {least:g}" if least > -math.inf else ""
    raise CdprError(f"{name}: expected {wanted}, got {shown(value)}")


def given_numbers(values: Any, count: int, name: str) -> tuple[float, ...]:
    """Return an argument of several numbers as tuple.

    Raises:
        CdprError: with the argument's name, unless they are `count` finite numbers.
    """
    return tuple(given_array(values, (count,), name).tolist())


def given_by_key(values: Any, name: str, allowed: Iterable[str]) -> FrozenDict[float]:
    """Return an argument of numbers by key.

    Raises:
        CdprError: with the argument's name, if it is none, or if a key is not allowed.
    """
    if not isinstance(values, Mapping):
        raise CdprError(f"{name}: expected numbers by key, got {shown(values)}")
    for key in values:
        if key not in (known := list(allowed)):
            raise CdprError(f"{name}: unknown key {shown(key)}; allowed: {', '.join(known) or 'none'}")
    return FrozenDict({key: given_number(value, f"{name}[{key!r}]") for key, value in values.items()})


def given_name(value: Any, name: str) -> str:
    """Return an argument as text; raise CdprError with the argument's name unless it is one."""
    if not isinstance(value, str):
        raise CdprError(f"{name}: expected a text, got {shown(value)}")
    return value


def given_colour(value: Any, name: str) -> str | None:
    """Return an argument as colour "#rrggbb" or None; raise CdprError with the argument's name unless it is one."""
    try:
        return None if value is None else coloured(given_name(value, name))
    except ValueError as error:
        raise CdprError(f"{name}: {error}") from None
