"""Where cables leave their limits: of length and speed, and where others are believed, of tension."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr.log.layout import Layout
from cdpr.mechanics.reach import LENGTHS, Bounds, Kind, Reach
from cdpr.model.robot import Array
from cdpr.tension.checks import LIMIT_TOLERANCE, newton

# Commands beyond the limits that cables have in truth, where the controller believes in others: those at first, for
# where an event changes them, it changes what is believed to the same, and nothing is beyond them.
OVERDRAWN = (
    Kind("below_min", "cables told to pull less", "N", "tension", upper=False, room="true_margin"),
    Kind("above_max", "cables told to pull more", "N", "tension", upper=True, room="true_margin"),
)

KINDS = (*LENGTHS, *OVERDRAWN)


def beyond(layout: Layout, bounds: Bounds, limits: Array, broken: Sequence[tuple[int, float]]) -> Reach:
    """Return what counts the samples of a run.

    Args:
        layout: columns of its rows.
        bounds: of the robot's lengths and winding speeds.
        limits: (2, m) lowest and highest tensions, N.
        broken: cables that break, counted from 0, and when, s.
    """
    kinds = OVERDRAWN if "true_margin" in layout.fields else ()
    tolerance = LIMIT_TOLERANCE * newton(limits)
    more = [(kind, limit, tolerance) for kind, limit in zip(kinds, limits, strict=False)]
    return Reach(layout.columns, bounds, layout.m, broken, more)
