"""The tensions within the limits that come nearest to a wrench: what remains when no distribution is admissible."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.jit import apart, kernel
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.tension import active_set, null_space
from cdpr.tension.active_set import nearest
from cdpr.tension.factors import append, back_substitute, remove
from cdpr.tension.null_space import reduce
from cdpr.tension.row_space import nearest_by_rows, worthwhile
from cdpr.tension.status import NOT_FOUND, OK, UNSUPPORTED, Status

# A cable whose pull changes the squared residual by less than this share of what it could does not enter: round-off.
GRADIENT_TOLERANCE = 1e-12

# A cable whose pull would enlarge the squared residual by more than this share of what it could is at its limit in all
# solutions.
PRESSED = 1e-9

# A cable whose effect beyond that of the cables already free is below this share of its length depends on them.
DEPENDENCE_TOLERANCE = 1e-9


def work_rows(n: int, m: int) -> int:
    """Rows of work space that `box_least_squares` needs."""
    norm = null_space.form_rows(m) + 4 + max(null_space.work_rows(n), active_set.work_rows(m))
    return max(3 * n + 8, norm)


@apart
@kernel
def box_least_squares(
    W: Array, wrench: Array, weights: Array, low: Array, high: Array, tension: Array, work: Array
) -> int:
    """Write the tensions (m,) within low <= t <= high that minimise |D (W t - wrench)|; of several, the least.

    D = diag(weights) (n,): with 1 for forces and 1 / characteristic length for moments the residual is in newtons.
    Any n, m and rank; upper limits may be infinite. Returns the steps taken, -NOT_FOUND if it gave up, or
    -UNSUPPORTED, the tensions untouched, where a lower limit is infinite. `work` has `work_rows(n, m)` rows and
    max(n, m) columns.

    The wrench W t nearest to the wanted one is unique and depends continuously on it, for what the cables can exert is
    a convex set; and so do the tensions of least norm that exert it. They equal the distribution of least norm where
    that exists: nothing jumps when a wrench becomes infeasible.
    """
    n, m = wrench.shape[0], tension.shape[0]
    for i in range(m):
        if low[i] == -math.inf:
            return -UNSUPPORTED
    steps, unique = _nearest_wrench(W, wrench, weights, low, high, tension, work)
    if steps < 0 or unique:
        return steps
    N, box = work[:m], work[m : m + 3]
    x, active, least, reached = work[m + 3], work[m + 4], work[m + 5, :m], work[m + 6, :n]
    rest = work[m + 7 :]
    for j in range(n):
        s = 0.0
        for i in range(m):
            s += W[j, i] * tension[i]
        reached[j] = s
    status = NOT_FOUND
    if worthwhile(n, m):
        for i in range(m):
            x[i] = 0.0
        status = nearest_by_rows(W, reached, low, high, x, least, N, box, rest)
    if status != OK:
        r = reduce(W, reached, low, high, box, N, rest)
        if r >= 0:
            more = nearest(N, r, box, x, least, active, rest)
            if more >= 0:
                steps += more
                status = OK
    if status == OK:
        for i in range(m):
            tension[i] = least[i]
    return steps


@apart
@kernel
def _nearest_wrench(
    W: Array, wrench: Array, weights: Array, low: Array, high: Array, tension: Array, work: Array
) -> tuple[int, bool]:
    """Write some tensions that minimise the residual; return the steps, or -NOT_FOUND, and whether there are no others.

    Stark and Parker, Computational Statistics 10 (1995), BVLS: cables leave their limits one by one where that lessens
    the residual, and return where least squares over those that are free would take them beyond. The free columns of
    D W are kept as triangular factors.
    """
    n, m = wrench.shape[0], tension.shape[0]
    A, J, R = work[:n], work[n : 2 * n], work[2 * n : 3 * n]
    residual, d = work[3 * n], work[3 * n + 1]
    goal, member, projected = work[3 * n + 2], work[3 * n + 3], work[3 * n + 4]  # of the free cables
    place = work[3 * n + 5]  # -1 and 1: at a limit; 0: free
    size = work[3 * n + 6]
    barred = work[3 * n + 7]  # cables that may not enter for the moment
    for j in range(n):
        for i in range(n):
            J[i, j] = 1.0 if i == j else 0.0
        for i in range(m):
            A[j, i] = weights[j] * W[j, i]
    for i in range(m):
        square = 0.0
        for j in range(n):
            square += A[j, i] * A[j, i]
        size[i] = math.sqrt(square)
        place[i] = -1.0
        barred[i] = 0.0
        tension[i] = low[i]
    k = 0
    for steps in range(20 * (m + 1)):
        total = 0.0
        for j in range(n):
            s = weights[j] * wrench[j]
            total += abs(s)
            for i in range(m):
                s -= A[j, i] * tension[i]
                total += abs(A[j, i] * tension[i])
            residual[j] = s
        p, best = -1, GRADIENT_TOLERANCE * total
        unique = True
        for i in range(m):
            if place[i] != 0.0 and low[i] < high[i]:
                s = 0.0
                for j in range(n):
                    s += A[j, i] * residual[j]
                # All solutions have the same residual: where it presses a cable against its limit, there it is in all.
                if not place[i] * s > PRESSED * total * size[i]:
                    unique = False
                if barred[i] == 0.0 and -place[i] * s > best * size[i]:
                    p, best = i, -place[i] * s / size[i]
        if p < 0:
            return steps, unique
        for j in range(n):
            s = 0.0
            for i in range(n):
                s += J[i, j] * A[i, p]
            d[j] = s
        square = 0.0
        for j in range(k, n):
            square += d[j] * d[j]
        if not square > (DEPENDENCE_TOLERANCE * size[p]) ** 2:
            barred[p] = 1.0
            continue
        append(J, R, d, k)
        member[k] = p
        side, place[p] = place[p], 0.0
        k += 1
        moved = False
        while k > 0:
            # Least squares over the free cables: R goal = J^T (what the others leave of the wrench).
            for j in range(n):
                s = weights[j] * wrench[j]
                for i in range(m):
                    if place[i] != 0.0:
                        s -= A[j, i] * tension[i]
                d[j] = s
            for j in range(k):
                s = 0.0
                for i in range(n):
                    s += J[i, j] * d[i]
                projected[j] = s
            back_substitute(R, projected, goal, k)
            if not moved and side * (goal[k - 1] - tension[p]) >= 0.0:
                # By round-off it would move the wrong way: it has nothing to give.
                barred[p] = 1.0
                place[p] = side
                k -= 1
                break
            step, blocked, wall = 1.0, -1, 0.0
            for j in range(k):
                i = int(member[j])
                move = goal[j] - tension[i]
                if goal[j] < low[i] and low[i] - tension[i] > step * move:
                    step, blocked, wall = (low[i] - tension[i]) / move, j, -1.0
                elif goal[j] > high[i] and high[i] - tension[i] < step * move:
                    step, blocked, wall = (high[i] - tension[i]) / move, j, 1.0
            for j in range(k):
                i = int(member[j])
                tension[i] += max(step, 0.0) * (goal[j] - tension[i])
            moved = True
            if blocked < 0:
                break
            i = int(member[blocked])
            place[i] = wall
            tension[i] = low[i] if wall < 0.0 else high[i]
            remove(J, R, projected, member, k, blocked)
            k -= 1
        if moved:
            for i in range(m):
                barred[i] = 0.0
    return -NOT_FOUND, False


def nearest_wrench_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    weights: ArrayLike,
    operation: str = "box_least_squares",
) -> tuple[Array, Status]:
    """Compute the tensions within the limits that minimise |D (W t - wrench)|; of several, the least.

    Stark and Parker, Computational Statistics 10 (1995).

    Args:
        matrix: (n, m), rows of the wrench matrix W, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N, may be inf.
        weights: (n,), the diagonal of D: 1 for forces, 1 / characteristic length, 1/m, for moments.
        operation: "best_effort": first ask for the least tensions that balance the wrench, and say whether they do.

    Returns:
        Tensions (m,) N, NaN where there are none. The status: OK, NOT_FOUND, or UNSUPPORTED where a lower limit is
        infinite; of "best_effort", also INFEASIBLE, with the nearest tensions, and BAD_INPUT.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> nearest_wrench_tension([[1.0, -1.0]], [20.0], [1.0, 1.0], [9.0, 9.0], [1.0])
        (array([9., 1.]), <Status.OK: 0>)
    """
    given = {"matrix": matrix, "wrench": wrench, "tension_min": tension_min, "tension_max": tension_max}
    arrays = {name: np.array(value, dtype=np.float64) for name, value in (given | {"weights": weights}).items()}
    tension = np.full(arrays["tension_min"].shape, np.nan)
    status = Status(bind(operation, **arrays, tension=tension, status=np.empty(1), steps=np.empty(1))())
    if status not in (Status.OK, Status.INFEASIBLE):
        tension[:] = np.nan
    return tension, status
