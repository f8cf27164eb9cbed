"""Contact between cables in a run of a robot without cable diameters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cdpr.log.clearance_rows import add_rows
from cdpr.log.run import Run
from cdpr.mechanics.assumed_diameters import assumption, with_diameters
from cdpr.mechanics.clearance import clearance
from cdpr.mechanics.closest import Closest
from cdpr.mechanics.contacts import passing
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle

MOST = 4001  # rows that are checked in longer runs


def cables_in_contact(robot: Robot, run: Run, obstacles: Sequence[Obstacle] = ()) -> str | None:
    """Return a description of cables in contact, for a robot without all cable diameters; None if there are none."""
    if all(cable.diameter is not None for cable in robot.cables) or not robot.unilateral:
        return None  # reported by the summary, or rigid legs
    rows = some_rows(run)
    closest = Closest(clearance(with_diameters(robot), obstacles, gravity=run.header.gravity), run.header.broken)
    if len(rows):
        add_rows(closest, run.header.layout, rows)
    least = closest.least
    if least is None or least.clearance >= 0.0:
        return None
    names, gap = closest.name(least), 1e3 * least.clearance
    text = passing(names, least.clearance) or f"{names} touch: their clearance falls to {gap:.4g} mm"
    return f"{text} at {least.time:.4g} s{assumption(robot)}"


def some_rows(run: Run) -> Array:
    """Return `MOST` evenly spread rows of a run; all rows of a shorter one."""
    count = len(run.rows)
    return np.asarray(run.rows[np.linspace(0, max(count - 1, 0), min(count, MOST)).round().astype(np.int64)])
