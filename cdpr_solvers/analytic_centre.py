"""The analytic centre of the admissible tensions: smooth, and kept off all limits."""

from __future__ import annotations

import math
from typing import Any

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import null_space, safest
from cdpr.tension.active_set import VERTEX_TOLERANCE
from cdpr.tension.null_space import reduce
from cdpr.tension.safest import safest_point
from cdpr.tension.status import INFEASIBLE, NOT_FOUND, OK
from cdpr_solvers.options import per_cable

# Newton's decrement, a length relative to the distance from the limits, below which its full step is the last one:
# the method being quadratic, the error after it is about the square, which is round-off.
CONVERGED = 1e-8

# Below this decrement Newton's full step stays within the limits and converges quadratically (self-concordance).
FULL_STEP = 0.25

# Steps that no sound problem needs: ten are usual, from the centre of the largest ball.
MOST_STEPS = 200

# A set of admissible tensions thinner than this share of the largest tension is as good as a point: its centre is
# that of the largest ball, which differs by no more.
THIN = 1e-10


class AnalyticCentre(CompiledSolver):
    """min -sum w_i [log(t_i - t_min,i) + log(t_max,i - t_i)] with W t = wrench, by Newton's method in the null space.

    Any number of cables and any rank. Inside the feasible set the answer is a smooth function (C-infinity) of pose and
    wrench. Of a barrier with weights: Boyd and Vandenberghe, Convex Optimization (2004), sections 8.5.3 and 9.6.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        n, m = robot.n, robot.m
        super().__init__(
            robot,
            options,
            analytic_centre,
            parameters=per_cable(robot, "weights", options.weights),
            floats=null_space.form_size(m) + m + max(null_space.work_size(n, m), safest.work_size(m, m)),
        )


@kernel
def analytic_centre(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the analytic centre; return OK, INFEASIBLE, NOT_FOUND or BAD_INPUT."""
    m = W.shape[1]
    o = m * m
    N = work[:o].reshape(m, m)
    box = work[o : o + 3 * m].reshape(3, m)
    x = work[o + 3 * m : o + 4 * m]
    rest = work[o + 4 * m :]
    r = reduce(W, wrench, t_min, t_max, box, N, rest)
    if r < 0:
        return -r
    radius = safest_point(True, N, r, box[0], box[1], box[2], x, rest)
    if math.isnan(radius):
        return NOT_FOUND
    largest = 0.0
    for i in range(m):
        tension[i] = _entry(N, r, box[0, i], x, i)
        largest = max(largest, abs(tension[i]))
    if radius < -VERTEX_TOLERANCE * largest:
        return INFEASIBLE
    if r > 0 and THIN * largest < radius < math.inf and not _centre(N, r, box, x, parameters, tension, rest):
        return NOT_FOUND
    for i in range(m):
        tension[i] = min(max(tension[i], box[1, i]), box[2, i])
    return OK


@kernel
def _entry(N: Array, r: int, c: float, x: Array, i: int) -> float:
    """Return entry i of c + N x."""
    for k in range(r):
        c += N[i, k] * x[k]
    return c


@kernel
def _centre(N: Array, r: int, box: Array, x: Array, weights: Array, tension: Array, work: Array) -> bool:
    """Move x, whose tensions lie between the limits, to the centre; return whether it was reached."""
    m = box.shape[1]
    H = work[: r * r].reshape(r, r)
    step = work[r * r : r * r + r]
    lightest = math.inf
    for i in range(m):
        lightest = min(lightest, weights[i])
    for _ in range(MOST_STEPS):
        for a in range(r):
            step[a] = 0.0
            for b in range(a + 1):
                H[a, b] = 0.0
        for i in range(m):
            if box[1, i] < box[2, i]:
                below, above = 1.0 / (tension[i] - box[1, i]), 1.0 / (box[2, i] - tension[i])
                slope, bend = weights[i] * (above - below), weights[i] * (below * below + above * above)
                for a in range(r):
                    step[a] -= slope * N[i, a]
                    for b in range(a + 1):
                        H[a, b] += bend * N[i, a] * N[i, b]
        square = 0.0  # of the decrement: |L^-1 gradient|^2
        for a in range(r):
            for b in range(a + 1):
                s = H[a, b]
                for k in range(b):
                    s -= H[a, k] * H[b, k]
                H[a, b] = math.sqrt(s) if a == b else s / H[b, b]
            s = step[a]
            for k in range(a):
                s -= H[a, k] * step[k]
            step[a] = s / H[a, a]
            square += step[a] * step[a]
        for a in range(r - 1, -1, -1):
            s = step[a]
            for k in range(a + 1, r):
                s -= H[k, a] * step[k]
            step[a] = s / H[a, a]
        decrement = math.sqrt(square / lightest)  # of the barrier scaled so that its smallest weight is 1
        if not decrement < math.inf:  # NaN, too
            return False
        damping = 1.0 if decrement <= FULL_STEP else 1.0 / (1.0 + decrement)
        for a in range(r):
            x[a] += damping * step[a]
        for i in range(m):
            tension[i] = _entry(N, r, box[0, i], x, i)
        if decrement <= CONVERGED:
            return True
    return False
