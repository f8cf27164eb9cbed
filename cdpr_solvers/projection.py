"""What the closed-form methods share: the solution of W t = wrench nearest to a point, and what it is worth."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.tension.status import NOT_FOUND, OK
from cdpr.tension.verdict import settle


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
def nearest_to_middle(N: Array, r: int, box: Array, middle: Array, tension: Array) -> bool:
    """Write the middle of the limits (m,) and the closed form, the solution nearest to it; `box` as from `reduce`.

    Returns False where a limit is infinite: there is no middle.
    """
    for i in range(tension.shape[0]):
        middle[i] = 0.5 * (box[1, i] + box[2, i])
        if not math.isfinite(middle[i]):
            return False
    nearest_solution(N, r, box[0], middle, tension)
    return True


@kernel
def admitted(W: Array, wrench: Array, r: int, box: Array, tension: Array) -> int:
    """Settle a solution (m,) of W t = wrench; return OK, NOT_FOUND, or INFEASIBLE if it is the only one (r = 0)."""
    status = settle(W, wrench, box, tension)
    return NOT_FOUND if status != OK and r > 0 else status
