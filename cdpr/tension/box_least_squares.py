"""The tensions within the limits that come nearest to a wrench: what remains when no distribution is admissible."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.tension import active_set, null_space
from cdpr.tension.active_set import nearest
from cdpr.tension.factors import append, back_substitute, remove
from cdpr.tension.null_space import reduce
from cdpr.tension.status import NOT_FOUND

# A cable whose pull changes the squared residual by less than this share of what it could does not enter: round-off.
GRADIENT_TOLERANCE = 1e-12

# A cable whose effect beyond that of the cables already free is below this share of its length depends on them.
DEPENDENCE_TOLERANCE = 1e-9


def work_size(n: int, m: int) -> int:
    """Floats that `box_least_squares` needs as work space."""
    bounded = n * m + 2 * n * n + 5 * n + 3 * m
    norm = null_space.form_size(m) + 4 * m + n
    return norm + max(bounded, null_space.work_size(n, m), active_set.work_size(m, m))


@kernel
def box_least_squares(
    W: Array, wrench: Array, weights: Array, low: Array, high: Array, tension: Array, work: Array
) -> int:
    """Write the tensions (m,) within low <= t <= high that minimise |D (W t - wrench)|; of several, the least.

    D = diag(weights) (n,): with 1 for forces and 1 / characteristic length for moments the residual is in newtons.
    Any n, m and rank. Returns the steps taken, -NOT_FOUND if it gave up. `work` holds `work_size` floats.

    The wrench W t nearest to the wanted one is unique and depends continuously on it, for what the cables can exert is
    a convex set; and so do the tensions of least norm that exert it. They equal the distribution of least norm where
    that exists: nothing jumps when a wrench becomes infeasible.
    """
    n, m = W.shape
    steps = _nearest_wrench(W, wrench, weights, low, high, tension, work)
    if steps < 0:
        return steps
    N = work[: m * m].reshape(m, m)
    o = m * m
    box = work[o : o + 3 * m].reshape(3, m)
    o += 3 * m
    x = work[o : o + m]
    active = work[o + m : o + 2 * m]
    least = work[o + 2 * m : o + 3 * m]
    reached = work[o + 4 * m : o + 4 * m + n]
    rest = work[o + 4 * m + n :]
    for j in range(n):
        s = 0.0
        for i in range(m):
            s += W[j, i] * tension[i]
        reached[j] = s
    r = reduce(W, reached, low, high, box, N, rest)
    if r >= 0:
        more = nearest(N, r, box[0], box[1], box[2], x, least, active, rest)
        if more >= 0:
            steps += more
            for i in range(m):
                tension[i] = least[i]
    return steps


@kernel
def _nearest_wrench(
    W: Array, wrench: Array, weights: Array, low: Array, high: Array, tension: Array, work: Array
) -> int:
    """Write some tensions that minimise the residual.

    Stark and Parker, Computational Statistics 10 (1995), BVLS: cables leave their limits one by one where that lessens
    the residual, and return where least squares over those that are free would take them beyond. The free columns of
    D W are kept as triangular factors.
    """
    n, m = W.shape
    o = n * m
    A = work[:o].reshape(n, m)
    J = work[o : o + n * n].reshape(n, n)
    o += n * n
    R = work[o : o + n * n].reshape(n, n)
    o += n * n
    residual = work[o : o + n]
    d = work[o + n : o + 2 * n]
    goal = work[o + 2 * n : o + 3 * n]  # tensions of the free cables by least squares
    member = work[o + 3 * n : o + 4 * n]  # their numbers
    unused = work[o + 4 * n : o + 5 * n]
    o += 5 * n
    place = work[o : o + m]  # -1 and 1: at a limit; 0: free
    size = work[o + m : o + 2 * m]
    barred = work[o + 2 * m : o + 3 * m]  # cables that may not enter for the moment
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
        for i in range(m):
            if place[i] != 0.0 and barred[i] == 0.0 and low[i] < high[i]:
                s = 0.0
                for j in range(n):
                    s += A[j, i] * residual[j]
                if -place[i] * s > best * size[i]:
                    p, best = i, -place[i] * s / size[i]
        if p < 0:
            return steps
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
                unused[j] = s
            back_substitute(R, unused, goal, k)
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
            remove(J, R, unused, member, k, blocked)
            k -= 1
        if moved:
            for i in range(m):
                barred[i] = 0.0
    return -NOT_FOUND
