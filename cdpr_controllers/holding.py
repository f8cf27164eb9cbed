"""Tensions that hold the platform up at a pose: the feed-forward of controllers that put out commands."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from cdpr.cables.lines import lines
from cdpr.mechanics.geometry import cable_geometry
from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.kernels import inverse_dynamics, quaternion
from cdpr.model.robot import Array
from cdpr.tension.box_least_squares import box_least_squares, work_rows
from cdpr.tension.checks import select


class Holding:
    """Balances the weight within the limits, as close to `pretension` (N) in each cable as that allows.

    With pretension 0 it is the distribution of least norm. Where no tensions within the limits balance the weight it
    is the nearest that can be done (`box_least_squares`, which differs from the exact answer by 1e-5 of the load).

    Attributes:
        tension: (m,) N, live.
    """

    def __init__(self, robot: Robot, gravity: Array, pretension: float) -> None:
        n, m = robot.n, robot.m
        rows = np.array(robot.rows)
        weights = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[rows]
        shifted = np.array([robot.tension_min, robot.tension_max]) - pretension
        self.tension = np.full(m, pretension)
        self._state = np.zeros(13)  # at rest
        self._balance = partial(
            balance,
            lines(robot),
            rows,
            weights,
            shifted,
            pretension,
            robot.inertial,
            np.array(gravity, dtype=np.float64),
            self._state,
            self.tension,
            np.zeros((n + 12 + work_rows(n, m), max(6, n, m))),
        )

    def update(self, pose: Array) -> None:
        """Write the tensions for a pose (7,)."""
        self._state[:7] = pose
        self._balance()


@kernel
def balance(
    lines: Array,
    rows: NDArray[np.int64],
    weights: Array,
    shifted: Array,
    pretension: float,
    inertial: Array,
    gravity: Array,
    state: Array,
    tension: Array,
    work: Array,
) -> None:
    """Write the tensions (m,); they stay as they are should the active set give up.

    rows and weights (n,): degrees of freedom, and 1 or 1 / characteristic length; shifted (2, m): limits less
    `pretension`; state (13,) at rest; work a table of some rows.
    """
    n, m = rows.shape[0], lines.shape[0]
    W, wrench, length, rate, change = work[:6], work[6, :6], work[7], work[8], work[9, :m]
    free_wrench, free_W, rest = work[10, :n], work[11 : 11 + n], work[11 + n :]
    cable_geometry(lines, state, W, length, rate)
    zero = (0.0, 0.0, 0.0)
    inverse_dynamics(inertial, gravity, quaternion(state, 3), zero, zero, zero, wrench)
    for j in range(6):
        for i in range(m):
            wrench[j] -= W[j, i] * pretension
    select(rows, W, wrench, free_W, free_wrench)
    if box_least_squares(free_W, free_wrench, weights, shifted[0], shifted[1], change, rest) >= 0:
        for i in range(m):
            tension[i] = pretension + change[i]
