"""Tolerances of the checks of a distribution; the kernel library has the same (checks.hpp)."""

from __future__ import annotations

import math

from cdpr.model.robot import Array

# Tolerance of a tension within, or at, its limits, N; if the largest limit is below 1 N, the same share of it
# (`newton`). It is finer than any force sensor and coarser than the round-off of exact solvers. Accepted tensions are
# then clipped, so that limits are never exceeded.
LIMIT_TOLERANCE = 1e-6

# A distribution balances the wrench if the residual is below this share of the wrench (or of `newton`): below any model
# error, and above the accuracy of first-order solvers that report convergence.
RESIDUAL_TOLERANCE = 1e-6


def newton(limits: Array) -> float:
    """Return the reference force of the tolerances, N: 1 N, or the largest of the limits (2, m) if smaller.

    Otherwise the checks would be meaningless for robots with limits of millinewtons. If all limits are zero, it is 1.
    """
    largest = max(0.0, *(abs(limit) for limit in limits.ravel().tolist()))  # ignores NaN
    return largest if 0.0 < largest < 1.0 else 1.0


def allowed_residual(wrench: Array, weights: Array, limits: Array) -> float:
    """Return the largest allowed residual of a wrench (n,), N; `weights` (n,) as in `accept_tension`."""
    load = math.hypot(*(weights * wrench).tolist())
    return RESIDUAL_TOLERANCE * max(newton(limits), load)
