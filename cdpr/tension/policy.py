"""What the cables do where a solver has no admissible answer."""

from __future__ import annotations

import math
from typing import Literal

from cdpr.model.jit import apart, kernel
from cdpr.model.robot import Array
from cdpr.tension.box_least_squares import box_least_squares
from cdpr.tension.checks import judge

Policy = Literal["best_effort", "hold_tension", "stop"]

NEAREST, HOLD, CLIP = range(3)

# What a run says of the samples where a policy replaced the solver's answer.
FALLBACK = {
    "best_effort": "the nearest wrench within the limits instead",
    "hold_tension": "the tensions before held instead",
}
CLIPPED = "the solver minds no limits, its tensions were clipped to them"


def action(policy: Policy, respects_bounds: bool) -> int:
    """Return what `fall_back` is to do under a policy, for a solver that minds the limits or does not."""
    if policy != "best_effort":
        return HOLD
    return NEAREST if respects_bounds else CLIP


@apart
@kernel
def fall_back(
    action: int,
    status: int,
    W: Array,
    wrench: Array,
    weights: Array,
    limits: Array,
    answer: Array,
    tension: Array,
    report: Array,
    work: Array,
) -> bool:
    """Replace the tensions (m,) of the step before; return False, and change nothing, where an input is not finite.

    NEAREST: by those that come nearest to the wrench within the limits (2, m); HOLD: keep them; CLIP: by the solver's
    `answer`, if it gave a finite one, else as NEAREST. All are then within the limits, and `report` (4,) says what they
    do, with the solver's status. `weights` as `judge` says; `work` as `box_least_squares` says.
    """
    n, m = W.shape
    for j in range(n):
        if not math.isfinite(wrench[j]):
            return False
        for i in range(m):
            if not math.isfinite(W[j, i]):
                return False
    clip = action == CLIP
    for i in range(m):
        clip = clip and math.isfinite(answer[i])
    if clip:
        for i in range(m):
            tension[i] = answer[i]
    elif action != HOLD:
        # Should it give up, the tensions that it had reached are the best known.
        box_least_squares(W, wrench, weights, limits[0], limits[1], tension, work)
    for i in range(m):
        tension[i] = min(max(tension[i], limits[0, i]), limits[1, i])
    judge(W, wrench, weights, limits, tension, report)
    report[0] = status
    return True
