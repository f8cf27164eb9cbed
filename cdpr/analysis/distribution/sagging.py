"""Static tensions of robots whose cables sag."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.analysis.distribution.distributions import Distribution, distribute
from cdpr.base.defaults import SOLVER
from cdpr.cables import bends
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state
from cdpr.mechanics.potential import rest_lengths
from cdpr.mechanics.sag import sagging_wrench
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.tension import Status
from cdpr.tension.status_array import StatusArray

STRAIGHT = ", with straight cables, as no tensions hold the platform"  # remark on a clearance
MOST_ROUNDS = 60
EXACT = 1e-11  # change of the cables' wrench in the last round, as a share of the load


def resting_lengths(robot: Robot, poses: Array, gravity: Array) -> Array | None:
    """Return the unwound lengths (K, m) [m] at which the cables hold the platform at rest, for their curves.

    The arguments are those of `static_tensions`. The result is None if no cable sags, and NaN at poses without
    admissible tensions: there, `STRAIGHT` is a remark for clearances.
    """
    if not bends(robot):
        return None
    found = static_tensions(robot, poses, gravity=gravity)
    lengths = rest_lengths(robot, poses, found.tension, gravity=gravity)
    lengths[np.asarray(found.status) != Status.OK] = np.nan
    return lengths


def static_tensions(
    robot: Robot,
    poses: Array,
    *,
    solver: str | TensionSolver = SOLVER,
    options: Mapping[str, Any] | None = None,
    gravity: ArrayLike,
    jobs: int | None = None,
) -> Distribution:
    """Distribute the weight of the platform at poses, with the sag of the cables.

    The wrench of cables that sag is not W t. The rest, which depends on the tensions, is added to the load in turn with
    the distribution.

    Args:
        robot: the robot.
        poses: (K, 7) positions [m] and quaternions w, x, y, z.
        solver: name of an installed solver, or a solver object for this robot.
        options: options of a solver given by name.
        gravity: (3,) m/s^2, world axes.
        jobs: threads, as in `distribute`.

    Returns:
        Tensions at the winches. NOT_FOUND, with NaN, where a cable gets less than its least tension.
    """
    given: dict[str, Any] = {"solver": solver, "options": options, "gravity": gravity, "jobs": jobs}
    found = distribute(robot, poses, **given)
    if not bends(robot):
        return found
    bad = np.asarray(found.status) == Status.BAD_INPUT
    down, still = np.array(gravity, dtype=np.float64), np.zeros(3)
    load = np.array([required_wrench(robot, make_state(pose[:3], pose[3:]), down, still, still) for pose in poses])
    scale = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)
    added, open_rows = np.zeros_like(load), np.ones(len(poses), dtype=bool)
    for _ in range(MOST_ROUNDS):
        beside = sagging_wrench(robot, np.ascontiguousarray(poses), found.tension, down)
        changed = np.linalg.norm((beside - added)[:, robot.rows] * scale[robot.rows], axis=1)
        largest = np.linalg.norm(load * scale, axis=1) + np.abs(found.tension).max(axis=1)
        open_rows = ~(changed <= EXACT * largest)
        if not (open_rows & np.isfinite(beside).all(axis=1)).any():
            break
        added = np.where(open_rows[:, None], beside, added)
        found = distribute(robot, poses, load - added, **given)
    status = np.where(open_rows & ~bad, float(Status.NOT_FOUND), np.asarray(found.status, dtype=float))
    tension = np.where(open_rows[:, None], np.nan, found.tension)
    return Distribution(tension, StatusArray(status), found.residual, found.margin, found.at_limit)
