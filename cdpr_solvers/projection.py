"""What the closed-form methods share: the solution of W t = wrench nearest to a point, and what it is worth."""

from __future__ import annotations

from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.tension.checks import LIMIT_TOLERANCE
from cdpr.tension.status import INFEASIBLE, NOT_FOUND, OK


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
def nearest_to_middle(N: Array, r: int, box: Array, middle: Array, tension: Array) -> None:
    """Write the middle of the limits (m,) and the closed form, the solution nearest to it; `box` as from `reduce`."""
    for i in range(tension.shape[0]):
        middle[i] = 0.5 * (box[1, i] + box[2, i])
    nearest_solution(N, r, box[0], middle, tension)


@kernel
def verdict(r: int, box: Array, tension: Array) -> int:
    """Return OK if a solution is within the limits, else NOT_FOUND, or INFEASIBLE where it is the only one (r = 0)."""
    for i in range(tension.shape[0]):
        if not box[1, i] - LIMIT_TOLERANCE <= tension[i] <= box[2, i] + LIMIT_TOLERANCE:
            return NOT_FOUND if r > 0 else INFEASIBLE
    return OK
