"""The tensions within the limits that come nearest to the wrench, whether they balance it or not."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import box_least_squares as box
from cdpr.tension.box_least_squares import box_least_squares
from cdpr.tension.status import BAD_INPUT, INFEASIBLE, OK

# Tensions of least residual balance the wrench if what is left of it is below this share: round-off.
BALANCED = 1e-11


class BestEffort(CompiledSolver):
    """min |D (W t - wrench)| with t_min <= t <= t_max, of several optima that of least 2-norm; D as in the stage.

    Any n, m and rank: for underactuated robots and cables that failed. The answer is that of `qp` where the wrench can
    be balanced, and the status says whether it is.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        weights = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[robot.rows]
        super().__init__(robot, options, best_effort, parameters=weights.tolist(), rows=box.work_rows(robot.n, robot.m))


@kernel
def best_effort(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the nearest tensions; return OK, INFEASIBLE, NOT_FOUND or BAD_INPUT."""
    n, m = W.shape
    if parameters.shape[0] != n or wrench.shape[0] != n or work.shape[1] < max(n, m):
        return BAD_INPUT  # made for another robot
    if t_min.shape[0] < m or t_max.shape[0] < m:
        return BAD_INPUT
    sound = 0.0
    for i in range(m):
        if not t_min[i] <= t_max[i]:
            return BAD_INPUT
        for j in range(n):
            sound += 0.0 * W[j, i]
    for j in range(n):
        sound += 0.0 * wrench[j]
    if sound != 0.0:
        return BAD_INPUT
    steps = box_least_squares(W, wrench, parameters, t_min, t_max, tension, work)
    if steps < 0:
        return -steps
    left, load = 0.0, 0.0
    for j in range(n):
        s = -wrench[j]
        for i in range(m):
            s += W[j, i] * tension[i]
            load = max(load, parameters[j] * abs(W[j, i] * tension[i]))
        left = max(left, parameters[j] * abs(s))
        load = max(load, parameters[j] * abs(wrench[j]))
    return OK if left <= BALANCED * load else INFEASIBLE
