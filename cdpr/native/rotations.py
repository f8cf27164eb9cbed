"""Rotations as unit quaternions (w, x, y, z): compiled operations on numpy arrays. Conventions: see `cdpr.model`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.native.arrays import reals
from cdpr.native.bind import bind

Array = NDArray[np.float64]


def rotate(quaternion: ArrayLike, vector: ArrayLike) -> Array:
    """Rotate vectors by unit quaternions.

    Args:
        quaternion: (k, 4) or (4,), unit quaternions w, x, y, z.
        vector: (k, 3) or (3,), any unit.

    Returns:
        (k, 3) or (3,), R(q) v.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> rotate([0.0, 0.0, 0.0, 1.0], [1.0, 2.0, 3.0])  # half a turn about z
        array([-1., -2.,  3.])
    """
    return _compute("rotations", ("rotated", 3), quaternion=quaternion, vector=vector)


def multiply(left: ArrayLike, right: ArrayLike) -> Array:
    """Return Hamilton products of quaternions: the rotation `right`, then `left`.

    Args:
        left: (k, 4) or (4,), quaternions w, x, y, z.
        right: (k, 4) or (4,).

    Returns:
        (k, 4) or (4,).

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> multiply([0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0])  # i j = k
        array([0., 0., 0., 1.])
    """
    return _compute("quaternion_products", ("product", 4), left=left, right=right)


def rotation_vector(quaternion: ArrayLike) -> Array:
    """Return the rotation vectors of unit quaternions.

    Args:
        quaternion: (k, 4) or (4,), unit quaternions w, x, y, z of either sign.

    Returns:
        (k, 3) or (3,), rad, axes of the frame in which the quaternion turns, at most pi long.

    Raises:
        ValueError: The shape does not match.

    Example:
        >>> rotation_vector([1.0, 0.0, 0.0, 0.0])
        array([0., 0., 0.])
    """
    return _compute("rotation_vectors", ("vector", 3), quaternion=quaternion)


def from_rotation_vector(vector: ArrayLike) -> Array:
    """Return the unit quaternions of rotation vectors.

    Args:
        vector: (k, 3) or (3,), rad.

    Returns:
        (k, 4) or (4,), w, x, y, z.

    Raises:
        ValueError: The shape does not match.

    Example:
        >>> from_rotation_vector([0.0, 0.0, 0.0])
        array([1., 0., 0., 0.])
    """
    return _compute("quaternions", ("quaternion", 4), vector=vector)


def _compute(name: str, answer: tuple[str, int], **given: ArrayLike) -> Array:
    arrays: dict[str, Any] = reals(**given)
    single = all(array.ndim == 1 for array in arrays.values())
    arrays = {key: array[None] if single else array for key, array in arrays.items()}
    out = np.empty((max(len(array) for array in arrays.values()), answer[1]))
    bind(name, **arrays, **{answer[0]: out})()
    return out[0] if single else out
