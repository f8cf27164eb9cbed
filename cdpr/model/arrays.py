"""Arrays of callers, checked before compiled code gets them: a kernel believes every shape that it is told."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from cdpr.errors import CdprError
from cdpr.model.masks import MASKED, masked
from cdpr.model.robot import Array

FLOAT = np.dtype(np.float64)
REAL = "iuf"  # kinds of numpy's numbers that are real; text, truth values and complex numbers are mistakes


def checked(values: ArrayLike, shape: tuple[int | None, ...], name: str, *, finite: bool = False) -> Array:
    """Return `values` as C-contiguous, writeable float64 of a shape, copied only where they are not; None is any size.

    Raises CdprError naming the values where they are no real numbers, have another shape, or, if `finite` is asked
    for, one of them is not finite.
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
    # A finite sum, which is quick, has no other numbers in it.
    if finite and not (array.ndim == 1 and math.isfinite(sum(array.tolist()))) and not np.isfinite(array).all():
        raise CdprError(f"{name}: all numbers must be finite")
    return array


def real(values: ArrayLike, name: str) -> Array:
    """Return `values` as C-contiguous, writeable float64 of any shape; CdprError where they are no real numbers."""
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
    """Return an array that compiled code is to write into, itself and no copy; CdprError where it cannot be used."""
    if not isinstance(array, np.ndarray) or array.dtype != np.float64 or array.shape != shape:
        raise CdprError(f"{name}: a float64 array of shape {shape_text(shape)} is expected")
    if not (array.flags.c_contiguous and array.flags.writeable):
        raise CdprError(f"{name}: the array must be C-contiguous and writeable")
    return array


def shape_text(shape: tuple[int | None, ...]) -> str:
    """A shape as Python writes it, with K for any size."""
    sizes = ["K" if size is None else str(size) for size in shape]
    return f"({sizes[0]},)" if len(sizes) == 1 else f"({', '.join(sizes)})"
