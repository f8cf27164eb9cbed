"""From a point of the null space to tensions, and whether these are an answer."""

from __future__ import annotations

from cdpr.model.jit import apart, kernel
from cdpr.model.lanes import choose
from cdpr.model.robot import Array
from cdpr.tension.checks import RESIDUAL_TOLERANCE
from cdpr.tension.status import INFEASIBLE, OK

# A limit that must be broken by less than this share of the largest coordinate counts as kept: the rounding of an
# ill-conditioned problem whose only solution is a vertex. It is the band within which round-off decides feasibility.
VERTEX_TOLERANCE = 1e-9

# A breach below this share of the largest tension is the round-off of any sound problem: it balances as well as it can.
ROUND_OFF = 1e-12

# Beyond that the tensions, moved onto the limits, must still balance each row to this share of what the tension stage
# allows, which weighs moments by a length that is unknown here.
STRICTER = 0.1

# Share of the largest tension that replaces a newton in what may be left of a wrench, where it is more, from 1 kN on:
# what is left by moving a tension onto a limit by round-off grows with the tensions.
LARGE = 1e-3


@kernel
def solution(N: Array, r: int, box: Array, x: Array, tension: Array) -> None:
    """Write c + N x (m,); `box` (3, >= m) holds c and the limits."""
    for i in range(tension.shape[0]):
        tension[i] = box[0, i]
        for k in range(r):
            tension[i] += N[i, k] * x[k]


@apart
@kernel
def settle(W: Array, wrench: Array, box: Array, tension: Array) -> int:
    """Return OK where a solution (m,) of W t = wrench keeps the limits in `box`, else INFEASIBLE.

    Where it breaks them by so little that it may be OK, it is moved onto them.
    """
    breach, scale = 0.0, 0.0
    for i in range(tension.shape[0]):
        scale = max(scale, abs(tension[i]))
        breach = _larger(breach, max(box[1, i] - tension[i], tension[i] - box[2, i]))
    if not breach <= VERTEX_TOLERANCE * scale:
        return INFEASIBLE
    for i in range(tension.shape[0]):
        tension[i] = min(max(tension[i], box[1, i]), box[2, i])
    return _judge(W, wrench, tension, breach, scale)


@kernel
def verdict(W: Array, wrench: Array, N: Array, r: int, box: Array, x: Array, tension: Array) -> int:
    """Return OK where `tension` (m,), within the limits, is the solution c + N x of W t = wrench, else INFEASIBLE."""
    breach, scale = compared(N, r, box, x, tension)
    return _judge(W, wrench, tension, breach, scale)


@kernel
def compared(N: Array, r: int, box: Array, x: Array, tension: Array) -> tuple[float, float]:
    """Return by how much `tension` differs from the solution c + N x at most, and how large that is; of lanes, too."""
    breach, scale = 0.0, 0.0
    for i in range(tension.shape[0]):
        s = box[0, i]
        for k in range(r):
            s += N[i, k] * x[k]
        scale = max(scale, abs(s))
        breach = _larger(breach, abs(s - tension[i]))
    return breach, scale


@kernel
def _larger(a: float, b: float) -> float:
    """The larger one, NaN if either is that."""
    return choose((b <= a) | (a != a), a, b)


@kernel
def _judge(W: Array, wrench: Array, tension: Array, breach: float, scale: float) -> int:
    """Whether tensions within the limits are an answer that differ by `breach` from a solution as large as `scale`.

    The one place that decides it, for all methods that work in the null space.
    """
    if breach <= ROUND_OFF * scale:
        return OK
    if not breach <= VERTEX_TOLERANCE * scale:
        return INFEASIBLE
    one = max(1.0, LARGE * scale)  # N
    for j in range(wrench.shape[0]):
        s, size = -wrench[j], 0.0
        for i in range(tension.shape[0]):
            s += W[j, i] * tension[i]
            size = max(size, abs(W[j, i]))
        if not abs(s) <= STRICTER * RESIDUAL_TOLERANCE * max(abs(wrench[j]), one * min(size, 1.0)):
            return INFEASIBLE
    return OK
