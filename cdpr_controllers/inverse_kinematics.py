"""Inverse kinematics: the commands of the winches for the desired motion, without feedback of the pose."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.cables import bends
from cdpr.cables.tables import chain_table, command_kinds
from cdpr.mechanics.properties import home_pose
from cdpr.mechanics.sag import least_tensions
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import Controller, SnapshotOfArrays
from cdpr_controllers.holding import holding_arguments
from cdpr_controllers.law import Law


class InverseKinematics(SnapshotOfArrays, Controller):
    """Unwound lengths, or their rates, for the desired pose, as printers, plotters and camera robots use them.

    A winch with the command "length" receives the unstretched length of its cable at the desired pose, and one with
    "rate" the rate of that length; errors of rates add up. The tension of the cable there is `pretension`, or with
    `flex_compensation` the one that holds the platform (holding.hpp). A winch with the command "tension" receives that
    holding tension. The state is not used: the platform sinks as far as its cables stretch.
    """

    output = "command"

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        super().__init__(robot, gravity, control_step, options)
        _check_pretension(robot, gravity, options)
        self._feed = np.full(robot.m, options.pretension)
        self.arrays = (self._feed,)
        self._arguments = {
            **holding_arguments(robot, gravity, options.pretension),
            "chains": chain_table(robot),
            "takes": command_kinds(robot),
            "feed": self._feed,
            "compensates": int(options.flex_compensation),
        }
        self._law = Law(self._bound, robot.m)

    def _bound(self, state: Array, desired: Array, out: Array) -> Callable[[], object]:
        return bind("inverse_kinematics", **self._arguments, desired=desired, command=out)

    def renew(self, robot: Robot) -> bool:
        """Use the mass properties of another platform."""
        self.robot = robot
        self._arguments["inertial"][:] = robot.inertial
        return True

    def control(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the commands (m,)."""
        self._law(state, desired, out)

    def compiled(self, state: Array, desired: Array, out: Array) -> Callable[[], object]:
        """Return the law bound to these arrays."""
        return self._bound(state, desired, out)

    def reset(self) -> None:
        """Reset the holding tensions, which remain if none are found."""
        self._feed[:] = self.options.pretension


def _check_pretension(robot: Robot, gravity: Array, options: Any) -> None:
    """Raise CdprError if cables that sag have no length at the pretension, as their weight requires more."""
    if not bends(robot) or options.flex_compensation:
        return
    home = home_pose(robot)[0]
    least = float(least_tensions(robot, home[None, :3], home[None, 3:], gravity).max())
    if not options.pretension >= least:
        raise CdprError(
            f"controller.pretension: expected at least {least:.4g} N, which cables that sag need to carry their weight "
            f"at the home pose, got {options.pretension:g}"
        )
