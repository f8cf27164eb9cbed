"""What the closed-form methods share: the solution of W t = wrench nearest to a point, and what it is worth."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.tension.status import INFEASIBLE, NOT_FOUND, OK, UNSUPPORTED
from cdpr.tension.verdict import settle

# How far round-off may move a solution, as a share of it, where W is as ill-conditioned as `reduce` lets pass.
ROUND_OFF = 1e-6

# What a solution may leave unbalanced, as a share of the largest row: half of what is exact.
BALANCED = 5e-10


@kernel
def nearest_solution(N: Array, r: int, c: Array, target: Array, tension: Array) -> None:
    """Write t = c + N N^T target (m,), of all solutions c + N x, N (m, >= r), the one nearest to `target` (m,).

    It is target + W^+ (wrench - W target), computed without a cancellation: `reduce` makes c orthogonal to N.
    """
    m = tension.shape[0]
    for i in range(m):
        tension[i] = c[i]
    for k in range(r):
        x = 0.0
        for i in range(m):
            x += N[i, k] * target[i]
        for i in range(m):
            tension[i] += N[i, k] * x


@kernel
def nearest_to_middle(N: Array, r: int, box: Array, middle: Array, tension: Array) -> int:
    """Write the middle of the limits (m,) and the closed form, the solution nearest to it; `box` as from `reduce`.

    Returns UNSUPPORTED where a limit is infinite: there is no middle. INFEASIBLE where the closed form is farther from
    it than the corners of the limits, otherwise OK: all admissible tensions lie in the ball through the corners, of
    radius |t_max - t_min| / 2, which with equal limits for all is sqrt(m) (t_max - t_min) / 2. (Thesis 6.29 prints
    t_m / 2, half the middle, for (t_max - t_min) / 2, both here and for the ball that lies within the limits; most
    feasible wrenches would be refused.)
    """
    outer, distance, size = 0.0, 0.0, 0.0
    for i in range(tension.shape[0]):
        middle[i] = 0.5 * (box[1, i] + box[2, i])
        if not math.isfinite(middle[i]):
            return UNSUPPORTED
    nearest_solution(N, r, box[0], middle, tension)
    for i in range(tension.shape[0]):
        outer += (0.5 * (box[2, i] - box[1, i])) ** 2
        distance += (tension[i] - middle[i]) ** 2
        size += tension[i] ** 2
    return INFEASIBLE if math.sqrt(distance) > math.sqrt(outer) + ROUND_OFF * math.sqrt(size) else OK


@kernel
def admitted(W: Array, wrench: Array, r: int, box: Array, tension: Array) -> int:
    """Settle a solution (m,) of W t = wrench; return OK, NOT_FOUND, or INFEASIBLE if it is the only one (r = 0).

    NOT_FOUND also where, moved onto limits, it no more balances the wrench as exactly as these methods promise.
    """
    status = settle(W, wrench, box, tension)
    if r <= 0:
        return status
    lack, rows = 0.0, 0.0
    for j in range(wrench.shape[0]):
        s, size = -wrench[j], abs(wrench[j])
        for i in range(tension.shape[0]):
            s += W[j, i] * tension[i]
            size += abs(W[j, i] * tension[i])
        lack, rows = max(lack, abs(s)), max(rows, size)
    return OK if status == OK and lack <= BALANCED * rows else NOT_FOUND
