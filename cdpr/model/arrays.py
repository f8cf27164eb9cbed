"""Checks of callers' arrays before compiled code uses them: kernels do not check shapes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import CdprError
from cdpr.model.robot import Array
from cdpr.native.arrays import real


def checked(values: ArrayLike, shape: tuple[int | None, ...], name: str, *, finite: bool = False) -> Array:
    """Return `values` as C-contiguous, writeable float64 of a shape, in which None is any size; copy only if necessary.

    Raises:
        CdprError: with the name, if they are no real numbers, have another shape, or are not finite with `finite`.
    """
    array = real(values, name)
    if array.shape != shape and not (
        array.ndim == len(shape) and all(want in (None, got) for want, got in zip(shape, array.shape, strict=True))
    ):
        raise CdprError(f"{name}: the shape must be {shape_text(shape)}, got {array.shape}")
    # a finite sum, which is fast to compute, proves that all numbers are finite
    if finite and not (array.ndim == 1 and math.isfinite(sum(array.tolist()))) and not np.isfinite(array).all():
        raise CdprError(f"{name}: all numbers must be finite")
    return array


def live(array: Array, shape: tuple[int, ...], name: str) -> Array:
    """Return an array into which compiled code will write, without copying.

    Raises:
        CdprError: if it cannot be used.
    """
    if not isinstance(array, np.ndarray) or array.dtype != np.float64 or array.shape != shape:
        raise CdprError(f"{name}: expected a float64 array of shape {shape_text(shape)}")
    if not (array.flags.c_contiguous and array.flags.writeable):
        raise CdprError(f"{name}: the array must be C-contiguous and writeable")
    return array


def shape_text(shape: tuple[int | None, ...]) -> str:
    """Return a shape in Python's notation, with K for any size."""
    sizes = ["K" if size is None else str(size) for size in shape]
    return f"({sizes[0]},)" if len(sizes) == 1 else f"({', '.join(sizes)})"
