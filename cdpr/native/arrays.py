"""Conversion of callers' numbers to arrays for compiled operations, which check no types."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import CdprError

FLOAT, INTEGER = np.dtype(np.float64), np.dtype(np.int64)
REAL = "iuf"  # numpy's kinds of real numbers; text, booleans and complex numbers are rejected
WHOLE = "iub"
DEEPEST = 8  # lists in lists that are searched, more than any argument has; a list may contain itself
MASKED = "masked values are not supported; fill them in or remove them"

Array = np.ndarray[Any, Any]


def real(values: ArrayLike, name: str) -> Array:
    """Return `values` as C-contiguous, writeable float64 of any shape; copy only if necessary.

    Raises:
        CdprError: if they are no real numbers, or masked.
    """
    if type(values) is np.ndarray and values.dtype == FLOAT and values.flags.carray:
        return values
    return _converted(values, name, FLOAT, REAL, "real")


def reals(**values: ArrayLike) -> dict[str, Array]:
    """Return arrays as `real` does, by name."""
    return {name: real(each, name) for name, each in values.items()}


def whole(values: ArrayLike, name: str) -> Array:
    """Return `values` as C-contiguous, writeable int64 of any shape; copy only if necessary.

    Raises:
        CdprError: if they are neither whole numbers nor booleans, or masked.
    """
    return _converted(values, name, INTEGER, WHOLE, "whole")


def _converted(values: ArrayLike, name: str, dtype: np.dtype[Any], kinds: str, kind: str) -> Array:
    if masked(values):
        raise CdprError(f"{name}: {MASKED}")
    try:
        found = np.asarray(values)
    except Exception as error:  # `__array__` of other packages, such as of a tensor with gradients, raises anything
        raise CdprError(f"{name}: expected numbers: {error}") from error
    if found.size and found.dtype.kind not in kinds:
        raise CdprError(f"{name}: expected {kind} numbers, got an array of {found.dtype}")
    return np.require(found, dtype, ["C", "A", "W"])


def masked(values: Any, depth: int = DEEPEST) -> bool:
    """Return True if an array, or one in lists and tuples up to this depth, has masked values."""
    if "numpy.ma" not in sys.modules:  # slow to import; without it nothing is masked
        return False
    if isinstance(values, np.ma.MaskedArray):
        return bool(np.ma.getmaskarray(values).any())
    return depth > 0 and isinstance(values, list | tuple) and any(masked(each, depth - 1) for each in values)
