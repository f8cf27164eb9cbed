"""Minimum-norm solution and null space of W t = wrench by a pivoted orthogonal factorisation."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array

# A row of W whose remainder is below this share of the largest one counts as dependent: well above the round-off of
# the factorisation (1e-15) and well below any usable direction.
RANK_TOLERANCE = 1e-9

# A dependent row is consistent if the wrench agrees with the other rows to this share of its largest entry.
CONSISTENCY_TOLERANCE = 1e-9


def work_size(n: int, m: int) -> int:
    """Floats that `split` needs as work space."""
    return n * m + 3 * n


@kernel
def split(W: Array, wrench: Array, particular: Array, basis: Array, work: Array) -> int:
    """Split W t = wrench, W (n, m), into t = particular + basis[:, :m - rank] @ x; return the rank.

    `particular` (m,) is the solution of least norm, the columns of `basis` (m, m) are orthonormal and span the null
    space, so that |t|^2 = |particular|^2 + |x|^2. Returns -1 - rank where W is rank-deficient and the wrench lies
    outside its range. `work` holds n m + 3 n floats.

    Householder factorisation of W^T with column pivoting (Golub and Van Loan, algorithm 5.4.1).
    """
    n, m = W.shape
    V = work[: n * m].reshape(n, m)  # row j: column j of W^T, below the diagonal the Householder vectors
    scale = work[n * m : n * m + n]
    rhs = work[n * m + n : n * m + 2 * n]
    diagonal = work[n * m + 2 * n : n * m + 3 * n]
    for j in range(n):
        rhs[j] = wrench[j]
        for i in range(m):
            V[j, i] = W[j, i]
    rank = 0
    largest = 0.0
    for k in range(min(n, m)):
        pivot, best = k, -1.0
        for j in range(k, n):
            square = 0.0
            for i in range(k, m):
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
            for i in range(m):
                V[k, i], V[pivot, i] = V[pivot, i], V[k, i]
        alpha = V[k, k]
        beta = -norm if alpha >= 0.0 else norm
        # H = 1 - scale v v^T with v = column - beta e_k turns the column into beta e_k.
        V[k, k] = alpha - beta
        scale[k] = 1.0 / (norm * (norm + abs(alpha)))
        diagonal[k] = beta
        for j in range(k + 1, n):
            s = 0.0
            for i in range(k, m):
                s += V[k, i] * V[j, i]
            s *= scale[k]
            for i in range(k, m):
                V[j, i] -= s * V[k, i]
        rank += 1
    # R^T y = wrench, row by row; dependent rows must agree.
    allowed = 0.0
    for j in range(n):
        allowed = max(allowed, abs(rhs[j]))
    allowed *= CONSISTENCY_TOLERANCE
    consistent = True
    for j in range(n):
        s = rhs[j]
        for k in range(min(j, rank)):
            s -= V[j, k] * rhs[k]
        if j < rank:
            rhs[j] = s / diagonal[j]
        elif not abs(s) <= allowed:  # NaN is not consistent either
            consistent = False
    for c in range(m - rank):  # Q e_c, in `particular` for want of other space
        for i in range(m):
            particular[i] = 1.0 if i == rank + c else 0.0
        _reflect(V, scale, rank, particular)
        for i in range(m):
            basis[i, c] = particular[i]
    for i in range(m):
        particular[i] = rhs[i] if i < rank else 0.0
    _reflect(V, scale, rank, particular)
    return rank if consistent else -1 - rank


@kernel
def _reflect(V: Array, scale: Array, rank: int, x: Array) -> None:
    """Apply Q = H_0 ... H_{rank-1} to x in place."""
    m = x.shape[0]
    for k in range(rank - 1, -1, -1):
        s = 0.0
        for i in range(k, m):
            s += V[k, i] * x[i]
        s *= scale[k]
        for i in range(k, m):
            x[i] -= s * V[k, i]
