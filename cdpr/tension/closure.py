"""Whether cables can pull against each other: strictly positive null vectors of the wrench matrix."""

from __future__ import annotations

import numpy as np

from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.tension import active_set, null_space
from cdpr.tension.active_set import nearest
from cdpr.tension.null_space import reduce


def positive_null_vector(W: Array) -> Array | None:
    """Return tensions t (m,), each at least 1, with W t = 0 for W (n, m); None where there are none.

    Null vectors may be scaled, so some t > 0 exists if and only if some t >= 1 does: the nearest point to zero of the
    polytope { N x >= 1 }, N a basis of the null space, decides it in finitely many steps.

    Where W has full rank and such a t exists, the cables can balance every wrench (wrench closure): the platform is
    fully constrained. Where none exists there is, by Stiemke's lemma, a twist with W^T twist >= 0 and not zero: a
    motion that slackens cables and stretches none, which only a load such as the weight keeps from happening.
    """
    W = checked(W, (None, None), "W")
    n, m = W.shape
    box, basis, x, point, active = np.zeros((3, m)), np.zeros((m, m)), np.zeros(m), np.zeros(m), np.zeros(m)
    low, high = np.ones(m), np.full(m, np.inf)
    work = np.zeros((max(null_space.work_rows(n), active_set.work_rows(m)), max(n, m)))
    r = reduce(W, np.zeros(n), low, high, box, basis, work)
    if r < 0:
        return None
    steps = nearest(basis, r, box, x, point, active, work)
    return point if steps >= 0 else None
