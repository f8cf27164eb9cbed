"""Tolerances of a distribution's checks; the kernel library has the same (checks.hpp)."""

from __future__ import annotations

import math

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
