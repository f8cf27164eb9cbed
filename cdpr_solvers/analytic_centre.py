"""The analytic centre of the admissible tensions: smooth, and kept off all limits."""

from __future__ import annotations

import math
from typing import Any

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import null_space, safest
from cdpr.tension.factors import turn
from cdpr.tension.null_space import ROUNDING, reduce
from cdpr.tension.safest import safest_point
from cdpr.tension.status import NOT_FOUND, UNSUPPORTED
from cdpr.tension.verdict import settle, solution
from cdpr_solvers.options import per_cable

# Newton's decrement, a length relative to the distance from the limits, below which its full step is the last one:
# the method being quadratic, the error after it is about the square, which is round-off.
CONVERGED = 1e-8

# Below this decrement Newton's full step stays within the limits and converges quadratically (self-concordance).
FULL_STEP = 0.25

# Steps that no sound problem needs: ten are usual, from the centre of the largest ball.
MOST_STEPS = 200

# Below this decrement one that is not half of the one before is made of round-off: it cannot get better.
NOISE, SHRINKING = 1e-3, 0.5

# A set of admissible tensions thinner than this share of the largest tension is as good as a point: its centre is
# that of the largest ball, which differs by no more. Some hundred times the round-off of the tensions themselves.
THIN = 1e-12

# Below this share it may be so much longer than wide that the Hessian, made of inverse squares of distances, loses the
# long directions to round-off, unless the basis is turned to tell them apart.
FLAT = 1e-4


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
            rows=null_space.form_rows(m) + 1 + max(null_space.work_rows(n), safest.work_rows(m)),
            width=max(n, 2 * m + 1),
        )


@kernel
def analytic_centre(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the analytic centre; return OK, INFEASIBLE, UNSUPPORTED, NOT_FOUND or BAD_INPUT."""
    m = W.shape[1]
    N, x, box, rest = work[:m], work[m], work[m + 1 : m + 4], work[m + 4 :]
    r = reduce(W, wrench, t_min, t_max, box, N, rest)
    if r < 0:
        return -r
    radius = safest_point(True, N, r, box, x, rest)
    if math.isnan(radius):
        return NOT_FOUND
    if radius == math.inf and r > 0:
        return UNSUPPORTED  # the farther, the lower the barrier
    largest = 0.0
    for i in range(m):  # from here on c is the centre of the ball: steps from there are not rounded by its size
        for k in range(r):
            box[0, i] += N[i, k] * x[k]
        largest = max(largest, abs(box[0, i]))
    for k in range(r):
        x[k] = 0.0
    flat = radius < FLAT * largest
    if r > 0 and radius > THIN * largest and not _centre(work[: m + 1], r, box, flat, parameters, rest):
        return NOT_FOUND
    solution(N, r, box, x, tension)
    return settle(W, wrench, box, tension)


@kernel
def _align(basis: Array, r: int, box: Array, spare: Array) -> None:
    """Turn the basis so that its first columns are the directions in which the limits are nearest.

    `basis` (m + 1, >= r) holds N and x, which turns along.
    """
    m = basis.shape[0] - 1
    x = basis[m]
    for k in range(r - 1):
        nearest, closest, size = -1, 0.0, 0.0
        for i in range(m):
            s, square = 0.0, 0.0
            for a in range(r):
                s += basis[i, a] * x[a]
                if a >= k:
                    square += basis[i, a] * basis[i, a]
            length = math.sqrt(square)
            # What is left of a row after the turns before may be their round-off.
            if length > ROUNDING:
                rate = length / min((box[0, i] - box[1, i]) + s, (box[2, i] - box[0, i]) - s)
                if rate > closest:
                    nearest, closest, size = i, rate, length
        if nearest < 0:
            return
        turn(basis, r, k, nearest, size, spare)


@kernel
def _centre(basis: Array, r: int, box: Array, flat: bool, weights: Array, work: Array) -> bool:
    """Move x from zero, where all is within the limits, to the centre; return whether it was reached.

    `basis` as `_align` says, which is called for where the set is `flat`.
    """
    m = basis.shape[0] - 1
    N, x = basis[:m], basis[m]
    H, step = work[:r], work[r]
    lightest, previous = math.inf, math.inf
    for i in range(m):
        lightest = min(lightest, weights[i])
    for _ in range(MOST_STEPS):
        if flat:
            _align(basis, r, box, step)
        for a in range(r):
            step[a] = 0.0
            for b in range(a + 1):
                H[a, b] = 0.0
        for i in range(m):
            s, size = 0.0, 0.0
            for a in range(r):
                s += N[i, a] * x[a]
                size += abs(N[i, a])
            if size > 0.0:
                below, above = 1.0 / ((box[0, i] - box[1, i]) + s), 1.0 / ((box[2, i] - box[0, i]) - s)
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
        length = 1.0
        if decrement > FULL_STEP:
            length = 1.0 / (1.0 + decrement)  # surely within the limits, and lower
            # Along a long set that is next to nothing: as long as it goes on downhill, twice as far.
            while _downhill(N, r, box, x, step, 2.0 * length, weights):
                length *= 2.0
        for a in range(r):
            x[a] += length * step[a]
        if decrement <= CONVERGED or (decrement <= NOISE and decrement > SHRINKING * previous):
            return True
        previous = decrement
    return False


@kernel
def _downhill(N: Array, r: int, box: Array, x: Array, step: Array, length: float, weights: Array) -> bool:
    """Whether x + length step is within the limits and the barrier still falls there in the direction of the step."""
    slope = 0.0
    for i in range(N.shape[0]):
        s, v = 0.0, 0.0
        for a in range(r):
            s += N[i, a] * x[a]
            v += N[i, a] * step[a]
        if v != 0.0:
            below, above = (box[0, i] - box[1, i]) + s + length * v, (box[2, i] - box[0, i]) - s - length * v
            if not (below > 0.0 and above > 0.0):
                return False
            slope += weights[i] * (v / above - v / below)
    return slope < 0.0
