"""From a point of the null space to tensions, and whether these are an answer."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.tension.checks import RESIDUAL_TOLERANCE
from cdpr.tension.status import INFEASIBLE, OK

# A limit that must be broken by less than this share of the largest coordinate counts as kept: the rounding of an
# ill-conditioned problem whose only solution is a vertex. It is the band within which round-off decides feasibility.
VERTEX_TOLERANCE = 1e-9

# Below this share of the largest tension a breach is the round-off of any sound problem, and balances as well as it can.
ROUND_OFF = 1e-12

# Beyond that the tensions, moved onto the limits, must still balance each row to this share of what the tension stage
# allows, which weighs moments by a length that is unknown here.
STRICTER = 0.1


@kernel
def tensions(N: Array, r: int, box: Array, x: Array, tension: Array) -> None:
    """Write c + N x (m,), moved onto the limits where it breaks them; `box` (3, >= m) holds c and the limits."""
    for i in range(tension.shape[0]):
        s = box[0, i]
        for k in range(r):
            s += N[i, k] * x[k]
        tension[i] = min(max(s, box[1, i]), box[2, i])


@kernel
def verdict(W: Array, wrench: Array, N: Array, r: int, box: Array, x: Array, tension: Array) -> int:
    """Return OK where `tension` (m,), within the limits, is the solution c + N x of W t = wrench, else INFEASIBLE.

    The one place that decides whether what a method has found in the null space is an answer. `tension` may differ
    from c + N x by round-off, and by VERTEX_TOLERANCE where W t is the wrench none the less.
    """
    breach, scale = 0.0, 0.0
    for i in range(tension.shape[0]):
        s = box[0, i]
        for k in range(r):
            s += N[i, k] * x[k]
        scale = max(scale, abs(s), abs(box[0, i]))
        difference = abs(s - tension[i])
        if not difference <= breach:  # NaN, too
            breach = difference
    if breach <= ROUND_OFF * scale:
        return OK
    if not breach <= VERTEX_TOLERANCE * scale:
        return INFEASIBLE
    for j in range(wrench.shape[0]):
        s, size = -wrench[j], 0.0
        for i in range(tension.shape[0]):
            s += W[j, i] * tension[i]
            size = max(size, abs(W[j, i]))
        if not abs(s) <= STRICTER * RESIDUAL_TOLERANCE * max(abs(wrench[j]), min(size, 1.0)):
            return INFEASIBLE
    return OK
