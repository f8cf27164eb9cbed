"""Violations of cable limits during a run: lengths, winding speeds, tensions, and commands of a nominal model."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cdpr.log.layout import Layout
from cdpr.mechanics.reach import LENGTHS, Bounds, Kind, Reach
from cdpr.model.robot import Array
from cdpr.tension.checks import LIMIT_TOLERANCE, newton

OF_COMMANDS = "commands that require tensions"

# Commands outside the true limits of the cables, if the controller uses a nominal model with others.
OVERDRAWN = (
    Kind(
        "below_min", "commands that require tensions below tension.min", "N", "tension", upper=False, room="true_margin"
    ),
    Kind(
        "above_max", "commands that require tensions above tension.max", "N", "tension", upper=True, room="true_margin"
    ),
)

# True tensions, if they differ from the commands. (With ideal cables the solver's status reports them.)
TENSIONS = (
    Kind("tension_below_min", "cable tensions lower than allowed", "N", "cable_tension", upper=False),
    Kind("tension_above_max", "cable tensions higher than allowed", "N", "cable_tension", upper=True),
)

KINDS = (*LENGTHS, *OVERDRAWN, *TENSIONS)

# Valid from a time (s) on: lowest and highest tensions (m,), N; a lowest value of None means no limit.
LimitChanges = tuple[tuple[float, tuple[float | None, ...], tuple[float, ...]], ...]


def beyond(
    layout: Layout,
    bounds: Bounds,
    limits: Array,
    broken: Sequence[tuple[int, float]],
    changes: LimitChanges = (),
) -> Reach:
    """Return the counter of samples that violate a limit.

    Args:
        layout: columns of the run's rows.
        bounds: limits of the robot's lengths and winding speeds.
        limits: (2, m), lowest and highest tensions, N.
        broken: index and time (s) of cables that break.
        changes: changed tension limits in the order of time.
    """
    pairs = [pair for pair in (OVERDRAWN, TENSIONS) if all(_needs(kind) in layout.fields for kind in pair)]
    tolerance = LIMIT_TOLERANCE * newton(limits)
    more = [(kind, limit, tolerance) for pair in pairs for kind, limit in zip(pair, limits, strict=True)]
    return Reach(layout.columns, bounds, layout.m, broken, more, tables(changes))


def tables(changes: LimitChanges) -> list[tuple[float, dict[str, Array]]]:
    """Return changes of tension limits by the names of the affected kinds."""
    found = []
    for time, low, high in changes:
        lowest = np.array([-math.inf if value is None else value for value in low])
        pair = lowest, np.array(high)
        found.append((time, {kinds[i].name: pair[i] for kinds in (OVERDRAWN, TENSIONS) for i in (0, 1)}))
    return found


def _needs(kind: Kind) -> str:
    """Return the column that a kind requires."""
    return kind.room or kind.column
