"""Calls of compiled operations with changing arrays.

    status, (matrix, length, rate) = compute(
        "geometry", {"lines": lines, "state": state}, {"matrix": (6, m), "length": (m,), "rate": (m,)}
    )

Binding checks each argument and takes many times as long as a small kernel. So an operation is bound once for each set
of shapes, in each thread. It then runs on the arrays of the call, or on copies if their type or layout differs. For
constant arrays, use `cdpr.native.bind`. The instruction set is that of the first call.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.native.arrays import INTEGER, Array, real, whole
from cdpr.native.bind import DTYPES, bind
from cdpr.native.operations import operations

MOST = 64  # bound operations kept by a thread
MOST_ARRAYS, MOST_BYTES = 8, 1024  # of `Bound.on`

Shape = tuple[int, ...]
# The call, its inputs, its results, the positions of both in its struct (none if a result is an input, too), and the
# shapes and types of the results.
Bound = tuple[Any, tuple[Array, ...], tuple[Array, ...], bytes, list[tuple[Shape, np.dtype[Any]]]]


class _Kept(threading.local):
    """Bound operations of a thread, by name, shapes and numbers."""

    def __init__(self) -> None:
        self.bound: dict[object, Bound] = {}


_kept = _Kept()


def compute(
    name: str, inputs: Mapping[str, ArrayLike], outputs: Mapping[str, Shape], **numbers: float
) -> tuple[int, tuple[Array, ...]]:
    """Call an operation with arrays.

    Args:
        name: operation, a key of `cdpr.native.operations.operations()`.
        inputs: arrays that it reads, by name; also the initial content of arrays that it reads and writes.
        outputs: shapes of the arrays that it writes, by name.
        numbers: values by name.

    Returns:
        The status code; the arrays of `outputs`, in that order.

    Raises:
        TypeError: if a name is missing or unknown.
        ValueError: if the shapes do not match.
        CdprError: if an input is not made of real numbers.

    Example:
        >>> compute("positive_definite", {"matrix": [[4.0]], "right": [2.0]}, {"solution": (1,)}, damping=0.0)
        (0, (array([0.5]),))
    """
    given = [value if type(value) is np.ndarray else _numbers(name, key, value) for key, value in inputs.items()]
    shapes = [array.shape for array in given]
    # -0.0 and 0.0 are equal, and so are 1.0 and 1: their texts differ
    key = name, *inputs, *outputs, *shapes, *outputs.values(), *numbers, *map(repr, numbers.values())
    found = _kept.bound.get(key)
    if found is None:
        found = _bound(name, inputs, outputs, numbers)
        if len(_kept.bound) >= MOST:
            _kept.bound.clear()
        _kept.bound[key] = found
    call, read, written, positions, kinds = found
    if positions:
        fresh = tuple([np.empty(*kind) for kind in kinds])
        try:
            return call.on(positions, *given, *fresh), fresh
        except (BufferError, TypeError, ValueError):
            pass  # an input is of another type, or not contiguous
    for argument, array, value in zip(inputs, read, given, strict=True):
        array[...] = _numbers(name, argument, value)
    status: int = call()
    return status, tuple([array.copy() for array in written])


def _bound(
    name: str, inputs: Mapping[str, ArrayLike], outputs: Mapping[str, Shape], numbers: Mapping[str, float]
) -> Bound:
    dtypes = _dtypes(name)
    read = {key: _numbers(name, key, value).copy() for key, value in inputs.items()}
    written = {key: read[key] if key in read else np.empty(shape, dtypes.get(key)) for key, shape in outputs.items()}
    call = bind(name, **{**read, **written}, **numbers)
    names = [field.name for field in operations()[name].fields]
    several = (*read, *written)
    alone = len(several) <= MOST_ARRAYS and read.keys().isdisjoint(written) and len(call.words) <= MOST_BYTES
    positions = bytes(names.index(each) for each in several) if alone else b""
    kinds = [(array.shape, array.dtype) for array in written.values()]
    return call, tuple(read.values()), tuple(written.values()), positions, kinds


def _numbers(name: str, key: str, value: ArrayLike) -> Array:
    """Return an input as an array of the type that the operation reads."""
    return (whole if _dtypes(name).get(key) == INTEGER else real)(value, key)


@cache
def _dtypes(name: str) -> dict[str, np.dtype[Any]]:
    """Return the element types of an operation's arrays, by name; empty for an unknown one, which `bind` rejects."""
    operation = operations().get(name)
    return {field.name: DTYPES[field.type] for field in operation.fields if field.is_array} if operation else {}
