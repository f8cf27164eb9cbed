"""Wrench closure: strictly positive null vectors of the wrench matrix."""

from __future__ import annotations

import numpy as np

from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.tension.active_set import nearest_point
from cdpr.tension.admissible import general_solution
from cdpr.tension.status import Status


def positive_null_vector(W: Array) -> Array | None:
    """Return tensions t (m,), each at least 1, with W t = 0 for W (n, m); None if there are none.

    Null vectors may be scaled, so some t > 0 exists if and only if some t >= 1 does. The nearest point to zero of the
    polytope { N x >= 1 }, with N a basis of the null space, decides it in finitely many steps.

    If W has full rank and such a t exists, the cables can balance every wrench (wrench closure): the platform is fully
    constrained. If none exists, there is, by Stiemke's lemma, a nonzero twist with W^T twist >= 0: a motion that
    slackens cables and stretches none, prevented only by a load such as the weight.
    """
    W = checked(W, (None, None), "W")
    n, m = W.shape
    low, high = np.ones(m), np.full(m, np.inf)
    form = general_solution(W, np.zeros(n), low, high)
    if form is None:
        return None
    center, basis = form
    _, point, status = nearest_point(basis, center, low, high)
    return point if status == Status.OK else None
