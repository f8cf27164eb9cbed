"""Least tension of heavy cables between given ends; their curve is in curve.hpp."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array

COARSE, ROUNDS = 41, 5  # points of a search, and how often it is refined
STEEPEST = 40.0  # atanh of w L / S: at this the cable hangs vertically to round-off
STRAINS = 15  # iterations for the strain


def least_tension(chord: ArrayLike, weight: ArrayLike, axial_stiffness: ArrayLike, gravity: ArrayLike) -> Array:
    """Return the least tension at the upstream end of a heavy cable between two points.

    A cable with less has no equilibrium. With more it has two, taut and slack (`cdpr.cables.catenary`).

    Args:
        chord: (..., 3) m, from the platform to the exit, world axes.
        weight: (...) N/m, weight per unstretched length.
        axial_stiffness: (...) N.
        gravity: (3,) m/s^2, world axes.

    Returns:
        (...) N, 0 without weight.

    Example:
        >>> float(least_tension([5.0, 0.0, 5.0], 2.0 * 9.81, 1e6, [0.0, 0.0, -9.81]).round(1))
        142.5
    """
    across, rise = _level(np.asarray(chord, dtype=np.float64), np.asarray(gravity, dtype=np.float64))
    w, k = np.asarray(weight, dtype=np.float64), 0.5 / np.asarray(axial_stiffness, dtype=np.float64)
    across, rise, w, k = (part[..., None] for part in np.broadcast_arrays(across, rise, w, k))
    low, high = np.full(w.shape, math.log(1e-4)), np.full(w.shape, math.log(STEEPEST))
    shares = np.linspace(0.0, 1.0, COARSE)
    for _ in range(ROUNDS):
        theta = low + shares * (high - low)
        sums = _sums(np.exp(theta), across, rise, w, k)
        best = np.argmin(sums, axis=-1)[..., None]
        width = (high - low) / (COARSE - 1)
        middle = np.take_along_axis(theta, best, axis=-1)
        low, high = middle - width, middle + width
    least = np.take_along_axis(sums, best, axis=-1)
    tension = 0.5 * least + 0.5 * w * rise / (1.0 + k * least)
    return np.asarray(np.maximum(tension, 0.0)[..., 0])


def _level(chord: Array, gravity: Array) -> tuple[Array, Array]:
    """Return horizontal and vertical distances of the ends, m."""
    size = float(np.linalg.norm(gravity))
    up = -gravity / size if size > 0.0 else np.zeros(3)
    rise = chord @ up
    return np.linalg.norm(chord - rise[..., None] * up, axis=-1), rise


def _sums(theta: Array, across: Array, rise: Array, w: Array, k: Array) -> Array:
    """Return the sum of the tensions at both ends, N, of cables with theta = atanh(w L / sum)."""
    strain, sinh, tanh = np.zeros_like(theta), np.sinh(theta), np.tanh(theta)
    for _ in range(STRAINS):
        level = theta / sinh + strain * tanh / sinh
        sums = w / tanh * np.hypot(rise / (1.0 + strain), across / level)
        strain = k * sums
    return np.asarray(sums)
