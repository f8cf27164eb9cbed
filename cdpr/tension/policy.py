"""Fallback policies for samples without an admissible answer of the solver."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.arrays import real, reals
from cdpr.native.bind import bind

Policy = Literal["best_effort", "hold_tension", "stop"]

NEAREST, HOLD, CLIP = range(3)

# Memory about a solver: whether its answer had any content when it was replaced, and whether the check that a rejected
# answer failed was reported.
WRITTEN, TOLD = range(2)

# Descriptions of the replacement in a run.
FALLBACK = {
    "best_effort": "the nearest wrench within the limits instead",
    "hold_tension": "the previous tensions were held instead",
}
CLIPPED = "the solver ignores limits, so its tensions were clipped"


def action(policy: Policy, respects_bounds: bool) -> int:
    """Return the action of `replace_tension` under a policy, for a solver that does or does not respect the limits."""
    if policy != "best_effort":
        return HOLD
    return NEAREST if respects_bounds else CLIP


def replace_tension(
    policy: Policy,
    status: int,
    matrix: ArrayLike,
    wrench: ArrayLike,
    weights: ArrayLike,
    limits: ArrayLike,
    previous: ArrayLike,
    answer: ArrayLike | None = None,
) -> tuple[Array, Array] | None:
    """Return the replacement of a solver's inadmissible answer under a policy.

    Args:
        policy: "best_effort": the tensions within the limits closest to the wrench or, if `answer` is given, that
            answer clipped to the limits; "hold_tension" and "stop": the tensions of the previous step.
        status: status of the solver, a `cdpr.tension.Status` other than OK.
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m, required wrench of the cables.
        weights: (n,), 1 for forces, 1 / characteristic length, 1/m, for moments.
        limits: (2, m) N.
        previous: (m,) N, tensions of the previous step.
        answer: (m,) N, answer of a solver that ignores limits.

    Returns:
        Tensions (m,) N within the limits, and their report (4,) as in `cdpr.tension.checks`: status, residual, N,
            margin, N, and number of cables at a limit. None if an input is not finite.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> replace_tension("best_effort", 1, [[1.0, -1.0]], [20.0], [1.0], [[1.0, 1.0], [9.0, 9.0]], [5.0, 5.0])
        (array([9., 1.]), array([ 1., 12.,  0.,  2.]))
    """
    tension = real(previous, "previous").copy()
    own = np.full(tension.shape, np.nan) if answer is None else answer
    arrays = reals(matrix=matrix, wrench=wrench, weights=weights, limits=limits, answer=own)
    arrays |= {"tension": tension, "report": np.full(4, np.nan)}
    values = {"action": action(policy, answer is None), "answered": 0}
    code = bind("replace_tension", known=np.zeros(2, dtype=np.int64), **arrays, **values)(float(status))
    return None if code else (arrays["tension"], arrays["report"])
