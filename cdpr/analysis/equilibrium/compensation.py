"""Flex compensation: unwound lengths with which the loaded platform rests at given poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.analysis.distribution import distribute
from cdpr.analysis.distribution.sagging import static_tensions
from cdpr.analysis.distribution.source import robot_and_gravity
from cdpr.base.defaults import SOLVER
from cdpr.cables import bends
from cdpr.mechanics.potential import rest_lengths
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.scenario.loader import AnyRobot
from cdpr.tension import Status


@dataclass(frozen=True, eq=False)
class Compensation:
    """Compensated lengths at K poses for a robot with m cables; for a single pose, without the leading axis.

    Attributes:
        lengths: (K, m) unwound lengths of the unloaded cables, with the cable on pulleys [m].
        tension: (K, m) tensions at rest, at the winches [N].
        status: (K,) `cdpr.tension.Status` of the solver.
    """

    lengths: Array
    tension: Array
    status: Any

    @property
    def feasible(self) -> Array:
        """True if the platform rests at the pose with tensions within the limits, (K,)."""
        return np.asarray(self.status == Status.OK)


def compensated_lengths(
    robot: AnyRobot,
    poses: ArrayLike,
    *,
    solver: str | TensionSolver = SOLVER,
    options: Mapping[str, Any] | None = None,
    gravity: ArrayLike | None = None,
    jobs: int | None = None,
) -> Compensation:
    """Compute the unwound lengths with which the loaded platform rests at poses.

    A solver chooses tensions that balance the weight; each cable is then as much shorter as these stretch it. Cables
    that sag are longer, and also carry their own weight. The inverse is `equilibrium`.

    Args:
        robot: a Robot, a file, the name of an example, a dict or a Scenario.
        poses: (7,) or (K, 7) positions [m] and quaternions w, x, y, z.
        solver: name of an installed tension solver, or a solver object for this robot.
        options: options of a solver given by name.
        gravity: (3,) gravity [m/s^2], world axes. Default: that of the scenario, or of the earth.
        jobs: number of threads. It does not change the result.

    Returns:
        Lengths, tensions and statuses. Where no tensions balance the weight, the status is not OK, and the platform
        does not rest there. The status is NOT_FOUND, with NaN, where a cable that sags gets less than its least
        tension.

    Raises:
        CdprError: if an argument is wrong.
        PluginError: as for `distribute`.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca_winches")
        >>> found = cdpr.compensated_lengths(robot, robot.home)
        >>> at_rest = cdpr.equilibrium(robot, lengths=found.lengths)
        >>> bool(abs(at_rest.pose - robot.home).max() < 1e-9)
        True
    """
    robot, gravity = robot_and_gravity(robot, gravity)
    single = np.ndim(poses) == 1
    rows = np.atleast_2d(checked(poses, (7,) if single else (None, 7), "poses", finite=True)).copy()
    found = distribute(robot, poses, solver=solver, options=options, gravity=gravity, jobs=jobs)
    rows[:, 3:] /= np.sqrt(np.einsum("ij,ij->i", rows[:, 3:], rows[:, 3:]))[:, None]
    tension, status = np.atleast_2d(found.tension), found.status
    if bends(robot):
        found = static_tensions(robot, rows, solver=solver, options=options, gravity=gravity, jobs=jobs)
        tension, status = found.tension, found.status[0] if single else found.status
    lengths = rest_lengths(robot, rows, tension, gravity=gravity, jobs=jobs)
    return Compensation(lengths[0] if single else lengths, tension[0] if single else tension, status)
