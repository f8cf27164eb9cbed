"""The tensions nearest to a target where cables are many: Newton's method on the few equations, not the many cables."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.jit import apart, kernel, small
from cdpr.model.kinds import ROW, TABLE, WHOLE
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.tension.null_space import reduce_to_rows
from cdpr.tension.status import INFEASIBLE, NOT_FOUND, OK, Status

# What the equations may be missed by, as a share of the largest number in them: the round-off of a sum over many
# cables. Newton goes on as long as that shrinks.
BALANCED = 1e-13

# Below this it will not shrink any more.
ROUND_OFF = 5e-16

# A direction proves that no tensions balance the wrench if all together exert less along it than is wanted, by this
# share of what is summed up: far above the round-off, so that the proof holds.
PROOF = 1e-9

# So much of the direction's length may be missing from what a cable exerts along it, or be too much.
DIRECTION_ERROR = 1e-14

# Added to the eigenvalues of the Hessian, which lie between 0 and 1: zeros where fewer cables than equations are free.
REGULARISATION = 1e-12

# Ten steps are usual. What needs more is a set of admissible tensions that is as good as a point.
MOST_STEPS = 40

# How far a tension moves at most in the first trial of a line search, in largest tensions: beyond any limit, mostly.
FAR = 10.0

# A line search ends where the slope has fallen to this share.
FLAT = 0.1

# Trials of a line search: a few are usual, and a fourfold step each time has then gone beyond all numbers.
MOST_TRIALS = 60


# What `nearest_by_rows` takes and returns, for those who call it by its address.
BY_ROWS = WHOLE(TABLE, *[ROW] * 5, TABLE, TABLE, TABLE)


@small
@kernel
def worthwhile(n: int, m: int) -> bool:
    """Whether the rows of W (n, m) are fewer than the dimensions of its null space."""
    return m - n > n


@apart
@kernel
def nearest_by_rows(
    W: Array, wrench: Array, low: Array, high: Array, target: Array, tension: Array, B: Array, box: Array, work: Array
) -> int:
    """Write the tensions (m,) nearest to `target` with W t = wrench and low <= t <= high; return a status.

    OK and INFEASIBLE are proved; NOT_FOUND leaves the question to `null_space` and `active_set`, as where the
    admissible tensions are as good as a point. BAD_INPUT as `reduce`. B is (m, m), `box` (3, m), `work` has
    `null_space.work_rows(n)` rows and max(n, m) columns.

    The optimum is t(y) = target + B y, each cut off at its limits, for the y (k,) with B^T t(y) = b, k the rank of W.
    So t(y) keeps the limits and all conditions of optimality but the equations, whatever y is. Newton's method with a
    line search solves these: they are the gradient of a concave function, piecewise quadratic, so that near the
    solution a step is exact (Qi and Sun, Mathematical Programming 58, 1993). Where there is none that function has no
    bound, along a direction that is the proof (Farkas). A step costs k^2 m instead of the (m - n) (2 m - n) of an
    active set in the null space, and there are fewer.
    """
    m = tension.shape[0]
    k = reduce_to_rows(W, wrench, low, high, box, B, work)
    if k < 0:
        return -k
    c = box[0]
    G, b, y, d, left = work[:k], work[k], work[k + 1], work[k + 2], work[k + 3]
    offset, rate = work[k + 4], box[0]  # target + B y, and how it changes
    for j in range(k):
        b[j] = y[j] = 0.0
        for i in range(m):
            b[j] += B[i, j] * c[i]
            y[j] += B[i, j] * (c[i] - target[i])
    for i in range(m):
        offset[i] = target[i]
        for j in range(k):
            offset[i] += B[i, j] * y[j]
    before = math.inf
    for _ in range(MOST_STEPS):
        # What the equations lack, and how they change with y through the cables that are free.
        for j in range(k):
            left[j] = b[j]
            for q in range(j + 1):
                G[j, q] = 0.0
            G[j, j] = REGULARISATION
        size, missing = 0.0, 0.0
        for i in range(m):
            t = min(max(offset[i], low[i]), high[i])
            tension[i] = t
            size = max(size, abs(t))
            if low[i] < high[i]:
                for j in range(k):
                    left[j] -= B[i, j] * t
            if low[i] < offset[i] < high[i]:
                for j in range(k):
                    for q in range(j + 1):
                        G[j, q] += B[i, j] * B[i, q]
        for j in range(k):
            missing, size = max(missing, abs(left[j])), max(size, abs(b[j]))
        close = missing <= BALANCED * size
        if missing <= ROUND_OFF * size or (close and missing > 0.5 * before):
            return OK
        if not missing < math.inf:
            return NOT_FOUND
        before = missing
        _newton(G, k, left, d)
        slope, wanted, reach, total, fastest, error = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(k):
            slope += d[j] * left[j]
            wanted += d[j] * b[j]
            total += abs(d[j] * b[j])
            error += DIRECTION_ERROR * abs(d[j])
        for i in range(m):
            s = 0.0
            for j in range(k):
                s += B[i, j] * d[j]
            rate[i] = s
            fastest = max(fastest, abs(s))
            if low[i] < high[i]:
                more, less = s + error, s - error
                most = max(more * high[i], more * low[i], less * high[i], less * low[i])
                reach += most
                total += abs(most)
        if wanted - reach > PROOF * total:
            return INFEASIBLE
        step = 1.0
        if not close:  # where a line search would look at round-off
            # With fewer cables free than equations Newton's step is far too long.
            step = _line_search(min(1.0, FAR * size / fastest), rate, wanted, slope, offset, low, high, m)
        if step < 0.0:
            return NOT_FOUND
        for i in range(m):
            offset[i] += step * rate[i]
    return NOT_FOUND


@kernel
def _newton(G: Array, k: int, right: Array, d: Array) -> None:
    """Solve G d = right, G (k, k) positive definite, of which the lower triangle is given and lost."""
    for j in range(k):
        for q in range(j + 1):
            s = G[j, q]
            for p in range(q):
                s -= G[j, p] * G[q, p]
            G[j, q] = math.sqrt(max(s, REGULARISATION)) if q == j else s / G[q, q]
    for j in range(k):
        s = right[j]
        for p in range(j):
            s -= G[j, p] * d[p]
        d[j] = s / G[j, j]
    for j in range(k - 1, -1, -1):
        s = d[j]
        for p in range(j + 1, k):
            s -= G[p, j] * d[p]
        d[j] = s / G[j, j]


@kernel
def _line_search(
    step: float, rate: Array, wanted: float, start: float, offset: Array, low: Array, high: Array, m: int
) -> float:
    """Return a step > 0, the given one if it will do, where the slope, `start` > 0 at 0, has fallen to about zero.

    -1 where there is none within reach. The slope at a step is `wanted` less what the cables exert along the direction,
    at offset + step * rate within their limits.
    """
    near, far, slope_near, slope_far = 0.0, math.inf, start, 0.0
    for _ in range(MOST_TRIALS):
        slope = wanted
        for i in range(m):
            if low[i] < high[i]:
                slope -= rate[i] * min(max(offset[i] + step * rate[i], low[i]), high[i])
        if abs(slope) <= FLAT * start:
            return step
        if slope > 0.0:
            near, slope_near = step, slope
        else:
            far, slope_far = step, slope
        if far == math.inf:
            step *= 4.0
        else:
            # The secant, kept off the ends so that the interval shrinks.
            share = slope_near / (slope_near - slope_far)
            step = near + min(max(share, 0.1), 0.9) * (far - near)
    return -1.0


def nearest_tension_by_rows(
    matrix: ArrayLike, wrench: ArrayLike, tension_min: ArrayLike, tension_max: ArrayLike, target: ArrayLike
) -> tuple[Array, Status]:
    """Compute the admissible tensions nearest to a target, by Newton's method in the row space of W.

    Qi and Sun, Mathematical Programming 58 (1993). For many cables: a step takes n^2 m operations.

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.
        target: (m,) N.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, INFEASIBLE, NOT_FOUND where this method cannot
        tell, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> nearest_tension_by_rows([[1.0, -1.0, 1.0]], [3.0], [1.0] * 3, [9.0] * 3, [1.0] * 3)[1]
        <Status.OK: 0>
    """
    given = {"matrix": matrix, "wrench": wrench, "tension_min": tension_min, "tension_max": tension_max}
    arrays = {name: np.array(value, dtype=np.float64) for name, value in (given | {"target": target}).items()}
    tension = np.empty(arrays["tension_min"].shape)
    status = Status(bind("nearest_by_rows", **arrays, tension=tension, status=np.empty(1))())
    if status != Status.OK:
        tension[:] = np.nan
    return tension, status
