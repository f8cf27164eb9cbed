"""What the cables do where a solver has no admissible answer."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.native.bind import bind

Policy = Literal["best_effort", "hold_tension", "stop"]

NEAREST, HOLD, CLIP = range(3)

# What is known of a solver: whether it has written anything into its answer where that had to be replaced, and whether
# it was told which check a refused answer failed.
WRITTEN, TOLD = range(2)

# What a run says of the samples where a policy replaced the solver's answer.
FALLBACK = {
    "best_effort": "the nearest wrench within the limits instead",
    "hold_tension": "the tensions before held instead",
}
CLIPPED = "the solver minds no limits, its tensions were clipped to them"


def action(policy: Policy, respects_bounds: bool) -> int:
    """Return what `replace_tension` is to do under a policy, for a solver that minds the limits or does not."""
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
    """Return what a policy replaces a solver's answer by, where it is not admissible.

    Args:
        policy: "best_effort": by the tensions nearest to the wrench within the limits, or, where the solver minds no
            limits and `answer` is given, by that at the limits; "hold_tension" and "stop": by those of the step before.
        status: Of the solver, a `cdpr.tension.Status` other than OK.
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        weights: (n,), 1 for forces, 1 / characteristic length, 1/m, for moments.
        limits: (2, m) N.
        previous: (m,) N, tensions of the step before.
        answer: (m,) N, of a solver that minds no limits.

    Returns:
        Tensions (m,) N within the limits, and the report (4,) of `cdpr.tension.checks` on them: status, residual, N,
        margin, N, and number of cables at a limit. None where an input is not finite.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> replace_tension("best_effort", 1, [[1.0, -1.0]], [20.0], [1.0], [[1.0, 1.0], [9.0, 9.0]], [5.0, 5.0])
        (array([9., 1.]), array([ 1., 12.,  0.,  2.]))
    """
    given = {"matrix": matrix, "wrench": wrench, "weights": weights, "limits": limits}
    arrays = {name: np.array(value, dtype=np.float64) for name, value in given.items()}
    arrays |= {"tension": np.array(previous, dtype=np.float64), "report": np.full(4, np.nan)}
    arrays["answer"] = np.array(np.full(arrays["tension"].shape, np.nan) if answer is None else answer, dtype=float)
    values = {"action": action(policy, answer is None), "answered": 0}
    code = bind("replace_tension", known=np.zeros(2, dtype=np.int64), **arrays, **values)(float(status))
    return None if code else (arrays["tension"], arrays["report"])
