"""Unspecified velocities and accelerations of knots, by minimising the integrated squared jerk."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array
from cdpr.trajectory.block_tridiagonal import solve_block_tridiagonal

# Rows: x0, v0 T, a0 T^2, x1, v1 T, a1 T^2; columns: third to fifth coefficient of the quintic in the share s of T.
_HIGH = np.array(
    [
        [-10.0, 15.0, -6.0],
        [-6.0, 8.0, -3.0],
        [-1.5, 1.5, -0.5],
        [10.0, -15.0, 6.0],
        [-4.0, 7.0, -3.0],
        [0.5, -1.0, 0.5],
    ]
)
# Integral over s of the products of the jerks 6, 24 s and 60 s^2.
_JERK = np.array([[36.0, 72.0, 120.0], [72.0, 192.0, 360.0], [120.0, 360.0, 720.0]])
_COST = _HIGH @ _JERK @ _HIGH.T


def minimum_jerk(times: Array, x: Array, v: Array, a: Array) -> tuple[Array, Array]:
    """Return velocities and accelerations (K, 3) at knots with times (K,) and positions x (K, 3).

    Entries of v and a that are not NaN are kept. The others minimise the integral of the squared jerk, so that jerk and
    its derivative are continuous where both were free. (Minimum-jerk spline; Flash and Hogan 1985 for one segment.) The
    unknowns of a knot are coupled only with those of its neighbours, so that time and memory are linear in K.
    """
    v, a = v.copy(), a.copy()
    if not (np.isnan(v).any() or np.isnan(a).any()):
        return v, a
    duration = np.diff(times)
    # in units of the mean duration, fifth powers stay moderate
    unit = (times[-1] - times[0]) / len(duration)
    h = duration / unit
    scale = np.tile(h[:, None] ** np.arange(3), 2)
    cost = _COST * scale[:, :, None] * scale[:, None, :] / h[:, None, None] ** 5
    for axis in range(x.shape[1]):
        known = np.stack([v[:, axis] * unit, a[:, axis] * unit**2], axis=1)
        free = np.isnan(known)
        if free.any():
            found = _solve(cost, np.diff(x[:, axis]), known, free)
            v[:, axis] = np.where(free[:, 0], found[:, 0] / unit, v[:, axis])
            a[:, axis] = np.where(free[:, 1], found[:, 1] / unit**2, a[:, axis])
    return v, a


def _solve(cost: Array, steps: Array, known: Array, free: NDArray[np.bool_]) -> Array:
    """Return velocity and acceleration (K, 2) of one coordinate with displacements `steps` (K - 1,).

    Known values become rows of the identity, and their contributions to other rows move to the right-hand side.
    """
    rates = np.where(free, 0.0, known)
    before, after = cost[:, 1:3], cost[:, 4:6]
    # Gradients with zero unknowns. A common shift of the positions has no cost, so only the step matters.
    ends = np.concatenate([np.zeros((len(steps), 1)), rates[:-1], steps[:, None], rates[1:]], axis=1)
    gradient = np.zeros_like(rates)
    gradient[:-1] += np.einsum("kij,kj->ki", before, ends)
    gradient[1:] += np.einsum("kij,kj->ki", after, ends)
    diagonal = np.zeros((len(rates), 2, 2))
    diagonal[:-1] += before[:, :, 1:3]
    diagonal[1:] += after[:, :, 4:6]
    diagonal = np.where(free[:, :, None] & free[:, None, :], diagonal, np.eye(2) * ~free[:, :, None])
    upper = np.where(free[:-1, :, None] & free[1:, None, :], before[:, :, 4:6], 0.0)
    change = np.where(free, -gradient, 0.0)
    return np.asarray(rates + solve_block_tridiagonal(diagonal, upper, change))
