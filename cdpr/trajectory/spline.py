"""Velocities and accelerations for the knots that give none: the curve of least integrated squared jerk."""

from __future__ import annotations

import numpy as np

from cdpr.model.robot import Array

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

    Entries of v and a that are not NaN are kept. The rest minimise the integral of the squared jerk, so that jerk and
    its derivative are continuous where both were free. (Minimum-jerk spline; Flash and Hogan 1985 for one segment.)
    """
    count = len(times)
    cost = np.zeros((3 * count, 3 * count))
    for k, duration in enumerate(np.diff(times)):
        scale = np.tile([1.0, duration, duration**2], 2)
        block = slice(3 * k, 3 * k + 6)
        cost[block, block] += _COST * np.outer(scale, scale) / duration**5
    v, a = v.copy(), a.copy()
    for axis in range(x.shape[1]):
        knots = np.stack([x[:, axis], v[:, axis], a[:, axis]], axis=1).ravel()
        free = np.isnan(knots)
        if free.any():
            known = ~free
            # Scaling each unknown to a unit diagonal keeps the system well conditioned for uneven times.
            scale = 1.0 / np.sqrt(np.diag(cost)[free])
            system = cost[np.ix_(free, free)] * np.outer(scale, scale)
            knots[free] = scale * np.linalg.solve(system, -scale * (cost[np.ix_(free, known)] @ knots[known]))
            v[:, axis], a[:, axis] = knots[1::3], knots[2::3]
    return v, a
