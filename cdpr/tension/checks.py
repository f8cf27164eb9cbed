"""Tolerances of a distribution's checks; the kernel library has the same (checks.hpp)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr.model.jit import any_width, kernel
from cdpr.model.lanes import choose
from cdpr.model.robot import Array

# A tension counts as within its limits, and as at a limit, to this many newtons, or on robots whose largest limit is
# less than a newton to this share of that (`newton`): finer than any force sensor, coarser than the round-off of every
# exact solver. Accepted tensions are then clipped, so that no limit is broken at all.
LIMIT_TOLERANCE = 1e-6

# A distribution balances the wrench if the residual is below this share of the wrench (or of `newton`): a millionth of
# the load is below any model error, and above what first-order solvers reach when they say that they have converged.
RESIDUAL_TOLERANCE = 1e-6


def newton(limits: Array) -> float:
    """Return what is large beside the tolerances, N: one newton, or the largest of the limits (2, m) if that is less.

    Otherwise nothing would be proved of robots that are held by millinewtons. Of limits that are all zero it is 1.
    """
    largest = max(0.0, *(abs(limit) for limit in limits.ravel().tolist()))  # ignores NaN
    return largest if 0.0 < largest < 1.0 else 1.0


def allowed_residual(wrench: Array, weights: Array, limits: Array) -> float:
    """Return how many newtons of a wrench (n,) a distribution may leave; `weights` (n,) as of `accept_tension`."""
    load = math.hypot(*(weights * wrench).tolist())
    return RESIDUAL_TOLERANCE * max(newton(limits), load)


@any_width
@kernel
def select(rows: NDArray[np.int64], W: Array, wrench: Array, free_W: Array, free_wrench: Array) -> None:
    """Copy the rows of W (6, m) and wrench (6,) that belong to the degrees of freedom into (n, m) and (n,)."""
    for k in range(rows.shape[0]):
        free_wrench[k] = wrench[rows[k]]
        for i in range(W.shape[1]):
            free_W[k, i] = W[rows[k], i]


@any_width
@kernel
def true_margin(limits: Array, tension: Array, held: Array, room: Array) -> None:
    """Write how far the tensions (m,) are from the nearer of the limits (2, m), N, negative beyond.

    NaN for cables whose `held` (m,) is not: broken or jammed, nothing is asked of them.
    """
    for i in range(tension.shape[0]):
        distance = min(tension[i] - limits[0, i], limits[1, i] - tension[i])
        room[i] = choose(held[i] == held[i], math.nan, distance)
