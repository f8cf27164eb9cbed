"""Derivatives of many rotation vectors; used before the loop, so not compiled."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from cdpr.model.robot import Array
from cdpr.model.rotations import cross

# rad; smaller angles use series with truncation errors below 1e-14.
SMALL_ANGLE = 0.05


def rotation_vector_rates(phi: Array, omega: Array, alpha: Array) -> tuple[Array, Array]:
    """Return derivatives (K, 3) of rotation vectors phi (K, 3), |phi| <= pi, for body rates omega and alpha (K, 3).

    phi' = J^-1 omega and phi'' = J^-1 (alpha - J' phi') with J of `body_rates.hpp` and
    J^-1 = 1 + [phi] / 2 + c [phi]^2, c = (1 - t / 2 cot(t / 2)) / t^2, t = |phi|. (Chirikjian 2012, section 10.6.)
    """
    c, da, db, b = _coefficients(_dot(phi, phi))
    rate = _inverse(phi, c, omega)
    growth, turned = _dot(phi, rate), cross(phi, rate)
    drift = 0.0 - da * growth * turned + db * growth * cross(phi, turned) + b * cross(rate, turned)
    return rate, _inverse(phi, c, alpha - drift)


def _coefficients(square: Array) -> tuple[Array, Array, Array, Array]:
    """Return c, a' / (t t'), b' / (t t') and b of angles t from squares (K, 1); a, b as in `body_rates.hpp`."""
    small = np.sqrt(square) < SMALL_ANGLE
    large = np.where(small, 1.0, square)
    t = np.sqrt(large)
    sine, cosine, tangent = _each(math.sin, t), _each(math.cos, t), _each(math.tan, 0.5 * t)
    cube = square * square * square
    near = (
        1.0 / 12.0 + square / 720.0 + square * square / 30240.0 + cube / 1209600.0,
        -1.0 / 12.0 + square / 180.0 - square * square / 6720.0,
        -1.0 / 60.0 + square / 1260.0 - square * square / 60480.0,
        1.0 / 6.0 - square / 120.0 + square * square / 5040.0 - cube / 362880.0,
    )
    far = (
        (1.0 - 0.5 * t / tangent) / large,
        (t * sine - 2.0 * (1.0 - cosine)) / (large * large),
        (3.0 * sine - 2.0 * t - t * cosine) / (large * large * t),
        (t - sine) / (large * t),
    )
    c, da, db, b = (np.where(small, *pair) for pair in zip(near, far, strict=True))
    return c, da, db, b


def _each(function: Callable[[float], float], values: Array) -> Array:
    """Apply a function to each of (K, 1) values; numpy's own functions depend on the processor, unlike the kernels."""
    return np.fromiter(map(function, values[:, 0].tolist()), np.float64, len(values))[:, None]


def _inverse(phi: Array, c: Array, values: Array) -> Array:
    """Return J^-1 times vectors (K, 3)."""
    once = cross(phi, values)
    return np.asarray(values + 0.5 * once + c * cross(phi, once))


def _dot(a: Array, b: Array) -> Array:
    """Return the dot products (K, 1) of vectors (K, 3)."""
    x, y, z = (a * b).T
    return np.asarray(x + y + z)[:, None]
