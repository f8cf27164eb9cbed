"""Immutable data, also after copying, and its arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.base.errors import CdprError
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.native.arrays import MASKED, masked, real

Array = NDArray[np.float64]


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


def read_only(array: Array) -> Array:
    """Return a read-only view of `array`."""
    view = array.view()
    view.flags.writeable = False
    return view


def given_array(values: ArrayLike, shape: tuple[int | None, ...], name: str) -> Array:
    """Return an argument as read-only array of a shape, in which None is any size; read-only arrays are not copied.

    Raises:
        CdprError: with the argument's name, if they are no finite numbers or have another shape.
    """
    frozen = type(values) is np.ndarray and not values.flags.writeable and values.dtype == np.float64
    array = values if frozen else real(values, name)
    assert isinstance(array, np.ndarray)
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape, strict=True)):
        sizes = " x ".join("any number" if size is None else str(size) for size in shape)
        found = " x ".join(map(str, array.shape)) if array.shape else "one number"
        raise CdprError(f"{name}: expected {sizes} numbers, got {found}")
    if frozen and array.flags.c_contiguous:
        return array
    if not np.isfinite(array).all():
        bad = array[~np.isfinite(array)][0]
        raise CdprError(f"{name}: expected finite numbers, got {bad}")
    return frozen_array(array)


def given_number(
    value: Any, name: str, *, least: float = -math.inf, above: float = -math.inf, finite: bool = True
) -> float:
    """Return an argument as number.

    Raises:
        CdprError: with the argument's name, unless it is a number in this range.
    """
    wanted = "a number" + (f" greater than {above:g}" if above > -math.inf else "")
    wanted += f" of at least {least:g}" if least > -math.inf else ""
    number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not number or not (value >= least and value > above) or (finite and not math.isfinite(value)):
        raise CdprError(f"{name}: expected {wanted}, got {shown(value)}")
    return float(value)


def given_name(value: Any, name: str) -> str:
    """Return an argument as text; raise CdprError with the argument's name unless it is one."""
    if not isinstance(value, str):
        raise CdprError(f"{name}: expected a text, got {shown(value)}")
    return value
