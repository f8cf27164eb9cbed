"""Checks of callers' arrays before compiled code uses them: kernels do not check shapes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from cdpr.errors import CdprError
from cdpr.model.masks import MASKED, masked
from cdpr.model.robot import Array

FLOAT = np.dtype(np.float64)
REAL = "iuf"  # numpy's kinds of real numbers; text, booleans and complex numbers are rejected


def checked(values: ArrayLike, shape: tuple[int | None, ...], name: str, *, finite: bool = False) -> Array:
    """Return `values` as C-contiguous, writeable float64 of a shape, in which None is any size; copy only if necessary.

    Raises:
        CdprError: with the name, if they are no real numbers, have another shape, or are not finite with `finite`.
    """
    if type(values) is np.ndarray and values.shape == shape and values.dtype == FLOAT and values.flags.carray:
        array = values
    else:
        array = real(values, name)
        fits = array.ndim == len(shape) and all(
            want in (None, got) for want, got in zip(shape, array.shape, strict=True)
        )
        if not fits:
            raise CdprError(f"{name}: the shape must be {shape_text(shape)}, got {array.shape}")
    # a finite sum, which is fast to compute, proves that all numbers are finite
    if finite and not (array.ndim == 1 and math.isfinite(sum(array.tolist()))) and not np.isfinite(array).all():
        raise CdprError(f"{name}: all numbers must be finite")
    return array


def real(values: ArrayLike, name: str) -> Array:
    """Return `values` as C-contiguous, writeable float64 of any shape.

    Raises:
        CdprError: if they are no real numbers.
    """
    if masked(values):
        raise CdprError(f"{name}: {MASKED}")
    try:
        found = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise CdprError(f"{name}: numbers are expected: {error}") from error
    if found.size and found.dtype.kind not in REAL:
        raise CdprError(f"{name}: real numbers are expected, got an array of {found.dtype}")
    return np.require(found, np.float64, ["C", "A", "W"])


def live(array: Array, shape: tuple[int, ...], name: str) -> Array:
    """Return an array into which compiled code will write, without copying.

    Raises:
        CdprError: if it cannot be used.
    """
    if not isinstance(array, np.ndarray) or array.dtype != np.float64 or array.shape != shape:
        raise CdprError(f"{name}: a float64 array of shape {shape_text(shape)} is expected")
    if not (array.flags.c_contiguous and array.flags.writeable):
        raise CdprError(f"{name}: the array must be C-contiguous and writeable")
    return array


def shape_text(shape: tuple[int | None, ...]) -> str:
    """Return a shape in Python's notation, with K for any size."""
    sizes = ["K" if size is None else str(size) for size in shape]
    return f"({sizes[0]},)" if len(sizes) == 1 else f"({', '.join(sizes)})"
