"""Pose from measured cable lengths, by forward kinematics from the previous pose."""

from __future__ import annotations

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.cables.tables import line_table
from cdpr.mechanics.forward_kinematics import scales
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import Compiled, bind
from cdpr.plugins import SensorModel


class LengthFit:
    """Compiled fit of the pose to the lengths of encoders, each time that new ones arrive.

    The first fit starts at the assumed initial pose, each other one at the last pose. A fit that does not converge does
    not change the pose. Lengths are those of straight cables: unwound lengths of cables that stretch or sag differ.

    Attributes:
        pose: (7,) position, m, and quaternion w, x, y, z, world frame, live.
        fits: (1,), 1 if the fit to the last lengths converged, live.
        residual: (1,), m, norm of the remaining differences, live; NaN after a fit that did not converge.
        arrays: its memory.

    Args:
        robot: robot with at least as many cables as degrees of freedom.
        encoders: sensor of the lengths.
        residual: array for `residual`; a new one by default.

    Raises:
        CdprError: if the robot has fewer cables.
    """

    def __init__(self, robot: Robot, encoders: SensorModel, residual: Array | None = None) -> None:
        if robot.m < robot.n:
            raise CdprError(
                f"the estimator computes the pose from encoders, but {robot.m} lengths do not determine {robot.n} "
                "degrees of freedom: choose another estimator"
            )
        self._robot, self._encoders = robot, encoders
        self.pose, self.fits = np.zeros(7), np.zeros(1)
        self.residual = np.zeros(1) if residual is None else residual
        self.arrays = (self.pose, self.fits)

    def bound(self, start: Array) -> Compiled:
        """Return the operation for a state (13,) at time 0."""
        rows, scale = scales(self._robot)
        lengths = self._encoders.measured[: self._robot.m]
        given = {"lines": line_table(self._robot), "rows": rows, "scale": scale, "target": lengths, "pose": self.pose}
        more = {"fresh": self._encoders.fresh, "start": start, "fits": self.fits, "residual": self.residual}
        n = self._robot.n
        return bind("fit_lengths", **given, **more, inverse=np.zeros((n, n)))
