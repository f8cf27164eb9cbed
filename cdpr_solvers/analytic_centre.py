"""The analytic centre of the admissible tensions: smooth, and kept off all limits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.jit import kernel, small
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import active_set, null_space, safest
from cdpr.tension.active_set import extreme
from cdpr.tension.compiled import distribute_once
from cdpr.tension.factors import turn
from cdpr.tension.null_space import ROUNDING, reduce
from cdpr.tension.safest import safest_point
from cdpr.tension.status import BAD_INPUT, NOT_FOUND, OK, UNSUPPORTED, Status
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

# A set of admissible tensions thinner than this share of the largest tension is as good as flat: the cables across it
# have the tensions of the largest ball's centre, which differ by no more from any others, and the rest has a centre of
# its own. Some hundred times the round-off of the tensions themselves.
THIN = 1e-12

# The range of a tension across such a set: the ball's diameter, and some more where limits meet at an angle.
WIDEST = 100.0

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
            rows=_rows(n, m),
            width=max(n, 2 * m + 1),
        )


@small
@kernel
def _rows(n: int, m: int) -> int:
    """Rows of work space: the form, x, limits and centre, and what the methods need."""
    return null_space.form_rows(m) + 4 + max(null_space.work_rows(n), safest.work_rows(m), active_set.work_rows(m) + 4)


@kernel
def analytic_centre(
    W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array
) -> int:
    """Write the analytic centre; return OK, INFEASIBLE, UNSUPPORTED, NOT_FOUND or BAD_INPUT."""
    m = W.shape[1]
    if work.shape[0] < _rows(wrench.shape[0], m) or work.shape[1] < 2 * m + 1 or t_min.shape[0] < m:
        return BAD_INPUT  # made for another robot
    if t_max.shape[0] < m:
        return BAD_INPUT
    N, x, box, rest = work[:m], work[m], work[m + 1 : m + 4], work[m + 7 :]
    low, high, centre = work[m + 4, :m], work[m + 5, :m], work[m + 6, :m]
    for i in range(m):
        low[i], high[i] = t_min[i], t_max[i]
    status = NOT_FOUND
    for locked in range(m):  # each time at least one cable more
        r = reduce(W, wrench, low, high, box, N, rest)
        if r < 0:
            return status if locked else -r
        radius = safest_point(True, N, r, box, x, rest)
        if math.isnan(radius):
            return status
        if radius == math.inf and r > 0:
            return UNSUPPORTED  # the farther, the lower the barrier
        largest = 0.0
        for i in range(m):  # from here on c is the centre of the ball: steps from there are not rounded by its size
            for k in range(r):
                box[0, i] += N[i, k] * x[k]
            largest = max(largest, abs(box[0, i]))
        for k in range(r):
            x[k] = 0.0
        thin = r > 0 and not radius > THIN * largest
        if r > 0 and not thin:
            flat = radius < FLAT * largest
            found = _centre(work[: m + 1], r, box, flat, parameters, rest)
            if not (found or flat):  # it may be flat elsewhere, where a limit is very far
                for k in range(r):
                    x[k] = 0.0
                found = _centre(work[: m + 1], r, box, True, parameters, rest)
            if not found:
                return status
        for i in range(m):
            box[1, i], box[2, i] = t_min[i], t_max[i]
        solution(N, r, box, x, centre)
        settled = settle(W, wrench, box, centre)
        if settled == OK or not locked:
            status = settled
            for i in range(m):
                tension[i] = centre[i]
        if not thin or status != OK or not _lock(THIN * largest, N, r, box, low, high, rest):
            break
    return status


@kernel
def _lock(thin: float, N: Array, r: int, box: Array, low: Array, high: Array, work: Array) -> bool:
    """Lock the cables whose tensions can change by no more than round-off where they are; return whether there are any.

    A set that is as good as flat may still be long: its centre is that of the other cables. `thin` is N.
    """
    m = N.shape[0]
    g, x, point, active, rest = work[0], work[1], work[2, :m], work[3, :m], work[4:]
    found = False
    for i in range(m):
        ends, span, moves = 0.0, 0.0, False
        for k in range(r):
            moves = moves or N[i, k] != 0.0
        if not moves:
            continue
        for side in range(2):
            for k in range(r):
                g[k] = N[i, k] if side == 0 else -N[i, k]
            if extreme(g, N, r, box, x, point, active, rest) < 0:
                return False
            ends += 0.5 * point[i]
            span += point[i] if side == 1 else -point[i]
        if span <= WIDEST * thin:
            low[i] = high[i] = min(max(ends, box[1, i]), box[2, i])
            found = True
    return found


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


def analytic_centre_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    weights: ArrayLike | None = None,
) -> tuple[Array, Status]:
    """Compute the analytic centre of the admissible tensions.

    Boyd and Vandenberghe, Convex Optimization (2004), sections 8.5.3 and 9.6.

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.
        weights: (m,), positive: how strongly each cable is kept off its limits; all 1 by default.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, INFEASIBLE where none are admissible, UNSUPPORTED
        where infinite limits leave no centre, NOT_FOUND where the method gave up, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> analytic_centre_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    shares = np.ones(np.shape(tension_min)) if weights is None else weights
    return distribute_once("analytic_centre", matrix, wrench, tension_min, tension_max, weights=shares)
