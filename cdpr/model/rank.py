"""Rank of a wrench matrix in the presence of round-off."""

from __future__ import annotations

import numpy as np

from cdpr.model.robot import Array

# A row or a singular value below this share of the largest one is round-off: the cables exert nothing along it. An
# entry of W is a difference of coordinates over a length, with an error of a few eps = 2.2e-16 times coordinate over
# length. With six rows and coordinates up to 1e5 cable lengths that is 6 * 1e5 * eps = 1.3e-10. Usable directions are
# far above: at 1e-9, tensions would be 1e9 times their wrench.
RANK_TOLERANCE = 1e-9


def significant(values: Array) -> int:
    """Return the number of singular values, largest first, that are not round-off."""
    return int(np.count_nonzero(values > RANK_TOLERANCE * values.max(initial=0.0)))


def rank(W: Array) -> int:
    """Return the rank of W (n, m), moments divided by the characteristic length."""
    return significant(np.asarray(np.linalg.svd(W, compute_uv=False)))
