"""Tension distribution in null-space form: W t = wrench, low <= t <= high as low <= c + N x <= high."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.tension.status import BAD_INPUT, INFEASIBLE

# A row of W whose remainder is below this share of the largest one counts as dependent: well above the round-off of
# the factorisation (1e-15) and well below any usable direction.
RANK_TOLERANCE = 1e-9

# A dependent row is consistent if the wrench agrees with the other rows to this share of the largest load.
CONSISTENCY_TOLERANCE = 1e-9


def work_size(n: int, m: int) -> int:
    """Floats that `reduce` needs as work space."""
    return n * m + 3 * n + 2 * m


def form_size(m: int) -> int:
    """Floats that the form takes: N (m, m) and the box (3, m)."""
    return m * m + 3 * m


@kernel
def reduce(W: Array, wrench: Array, t_min: Array, t_max: Array, box: Array, N: Array, work: Array) -> int:
    """Write all solutions of W t = wrench, W (n, m), as t = c + N[:, :r] x; return r, the redundancy.

    `box` (3, m) receives c and the limits. c is the solution of least norm, but for cables whose limits are equal: they
    are locked, or cut, where that is 0. Their tension is given, their rows of N are zero, and the others balance what
    is left. The columns of N (m, m) are orthonormal and orthogonal to c, so that |t|^2 = |c|^2 + |x|^2.

    Returns -INFEASIBLE where W is rank-deficient and the wrench outside its range, -BAD_INPUT where an entry is not
    finite or a lower limit above the upper one. `work` holds n m + 3 n + 2 m floats.
    """
    n, m = W.shape
    V = work[: n * m]  # row j: the entries of W for free cables, row j of W
    rhs = work[n * m : n * m + n]
    cable = work[n * m + 3 * n : n * m + 3 * n + m]  # number of each free cable
    free, sound = 0, 0.0
    for i in range(m):
        low, high = t_min[i], t_max[i]
        if not low <= high:  # NaN, too
            return -BAD_INPUT
        box[0, i] = low  # what a locked cable keeps
        box[1, i] = low
        box[2, i] = high
        if low < high:
            cable[free] = i
            free += 1
    load = 0.0
    for j in range(n):
        s = wrench[j]
        load = max(load, abs(s))
        for i in range(m):
            sound += 0.0 * W[j, i]
            if not t_min[i] < t_max[i]:
                s -= W[j, i] * t_min[i]
                load = max(load, abs(W[j, i] * t_min[i]))
        sound += 0.0 * s
        rhs[j] = s
        for k in range(free):
            V[j * free + k] = W[j, int(cable[k])]
    if sound != 0.0:
        return -BAD_INPUT
    return _factorise(n, free, CONSISTENCY_TOLERANCE * load, box, N, work)


@kernel
def _factorise(n: int, free: int, allowed: float, box: Array, N: Array, work: Array) -> int:
    """Householder factorisation of V^T with column pivoting (Golub and Van Loan, algorithm 5.4.1), V (n, free)."""
    m = box.shape[1]
    V = work[: n * free].reshape(n, free)  # below the diagonal of its transpose: the Householder vectors
    rhs = work[n * m : n * m + n]
    scale = work[n * m + n : n * m + 2 * n]
    diagonal = work[n * m + 2 * n : n * m + 3 * n]
    cable = work[n * m + 3 * n : n * m + 3 * n + m]
    rank = 0
    largest = 0.0
    for k in range(min(n, free)):
        pivot, best = k, -1.0
        for j in range(k, n):
            square = 0.0
            for i in range(k, free):
                square += V[j, i] * V[j, i]
            if square > best:
                pivot, best = j, square
        norm = math.sqrt(best)
        if k == 0:
            largest = norm
        if not norm > RANK_TOLERANCE * largest:
            break
        if pivot != k:
            rhs[k], rhs[pivot] = rhs[pivot], rhs[k]
            for i in range(free):
                V[k, i], V[pivot, i] = V[pivot, i], V[k, i]
        alpha = V[k, k]
        beta = -norm if alpha >= 0.0 else norm
        # H = 1 - scale v v^T with v = column - beta e_k turns the column into beta e_k.
        V[k, k] = alpha - beta
        scale[k] = 1.0 / (norm * (norm + abs(alpha)))
        diagonal[k] = beta
        for j in range(k + 1, n):
            s = 0.0
            for i in range(k, free):
                s += V[k, i] * V[j, i]
            s *= scale[k]
            for i in range(k, free):
                V[j, i] -= s * V[k, i]
        rank += 1
    # R^T y = rhs, row by row; dependent rows must agree.
    for j in range(n):
        s = rhs[j]
        for k in range(min(j, rank)):
            s -= V[j, k] * rhs[k]
        if j < rank:
            rhs[j] = s / diagonal[j]
        elif not abs(s) <= allowed:
            return -INFEASIBLE
    r = free - rank
    y = work[n * m + 3 * n + m : n * m + 3 * n + 2 * m]  # over the free cables
    for i in range(m):
        for column in range(r):
            N[i, column] = 0.0
    for column in range(r):
        for i in range(free):
            y[i] = 1.0 if i == rank + column else 0.0
        _reflect(V, scale, rank, y)
        for i in range(free):
            N[int(cable[i]), column] = y[i]
    for i in range(free):
        y[i] = rhs[i] if i < rank else 0.0
    _reflect(V, scale, rank, y)
    for i in range(free):
        box[0, int(cable[i])] = y[i]
    return r


@kernel
def _reflect(V: Array, scale: Array, rank: int, x: Array) -> None:
    """Apply Q = H_0 ... H_{rank-1} to the first entries of x in place."""
    size = V.shape[1]
    for k in range(rank - 1, -1, -1):
        s = 0.0
        for i in range(k, size):
            s += V[k, i] * x[i]
        s *= scale[k]
        for i in range(k, size):
            x[i] -= s * V[k, i]
