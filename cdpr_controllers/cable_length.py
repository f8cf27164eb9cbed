"""Control of the length and rate of each cable, as in the drives of a cable robot, without measurement of the pose."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.mechanics.forward_kinematics import scales
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import Controller, SnapshotOfArrays
from cdpr.plugins.controller import Tunable
from cdpr_controllers.holding import holding_arguments
from cdpr_controllers.law import Law


class CableLength(SnapshotOfArrays, Controller):
    """One PID law per cable around tensions that hold the platform.

    The law is command = f + kp e + z + kd e' with e = l - l_d, so a cable that is too long gets more tension. Inverse
    kinematics gives the desired lengths and rates from the desired pose and twist. The measured lengths and rates are
    the only values taken from the state. The tensions f balance the weight (holding.hpp) at the pose that forward
    kinematics finds from the measured lengths. It starts from the previous pose, or from the desired pose at first and
    after a fit that did not converge. Without forward kinematics, f is computed at the desired pose.

    z is the integral of ki e over time: a sum over the control steps including the current one. Anti-windup limits it
    to +-integral_limit, and stops its growth while the cable is at the tension limit towards which the integral pushes.
    If the geometry is wrong, more lengths than degrees of freedom cannot all reach their desired values. The integrals
    then work against each other up to their limits.
    """

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        super().__init__(robot, gravity, control_step, options)
        n, m = robot.n, robot.m
        if options.forward_kinematics and m < n:
            raise CdprError(
                f"cable_length: {m} lengths do not determine {n} degrees of freedom; set forward_kinematics: false"
            )
        self._gains = np.zeros((4, m))
        self.change(options)
        self._integral, self._feed = np.zeros(m), np.full(m, options.pretension)
        self._pose, self._tracking = np.zeros(7), np.zeros(1)
        self.arrays = (self._pose, self._tracking, self._integral, self._feed)
        self._arguments = self._constants(robot, gravity, options)
        self._sensed: Array | None = None
        self._law = Law(self._bound, m)

    def _constants(self, robot: Robot, gravity: Array, options: Any) -> dict[str, Any]:
        return {
            **holding_arguments(robot, gravity, options.pretension),
            "scale": scales(robot)[1],
            "limits": np.array([robot.tension_min, robot.tension_max]),
            "estimates": int(options.forward_kinematics),
        }

    def _bound(self, state: Array, desired: Array, out: Array) -> Callable[[], object]:
        sensed = self._sensed
        return bind(
            "cable_length",
            **self._arguments,
            gains=self._gains,
            state=state,
            desired=desired,
            sensed=np.zeros((2, self.robot.m)) if sensed is None else sensed,
            senses=int(sensed is not None),
            pose=self._pose,
            tracking=self._tracking,
            integral=self._integral,
            feed=self._feed,
            command=out,
        )

    def change(self, options: Any) -> None:
        """Set new gains and limits. The integrals keep their values, within the new limits from the next step on."""
        m = self.robot.m
        given = {"kp": options.kp, "kd": options.kd, "ki": options.ki, "integral_limit": options.integral_limit}
        for name, value in given.items():
            if np.ndim(value) and len(value) != m:
                raise CdprError(f"cable_length: {name} has {len(value)} values, the robot {m} cables")
        self._gains[:] = [np.broadcast_to(value, m) for value in given.values()]
        self._gains[2] *= self.control_step
        self._ki = options.ki

    def sense(self, cables: Array) -> None:
        """Use the true lengths and rates at the cables, even if the controller's model of the robot differs."""
        self._sensed = cables
        self._law = Law(self._bound, self.robot.m)

    def renew(self, robot: Robot) -> bool:
        """Use the mass properties of another platform; integrals and the estimate of the pose stay."""
        self.robot = robot
        self._arguments["inertial"][:] = robot.inertial
        return True

    def control(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the commands (m,)."""
        self._law(state, desired, out)

    def compiled(self, state: Array, desired: Array, out: Array) -> Callable[[], object]:
        """Return the law bound to these arrays."""
        return self._bound(state, desired, out)

    def tunable(self) -> Mapping[str, Tunable]:
        """Return the gains and limits."""
        kp, kd, per_step, limit = self._gains
        return {
            "kp": Tunable(kp, kp.copy()),
            "kd": Tunable(kd, kd.copy()),
            "ki": Tunable(per_step, np.broadcast_to(self._ki, self.robot.m).astype(float), per_step=True),
            "integral_limit": Tunable(limit, limit.copy()),
        }

    def reset(self) -> None:
        """Reset the integrals and the estimate of the pose."""
        self._integral[:] = 0.0
        self._tracking[0] = 0.0
