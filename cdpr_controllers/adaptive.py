"""Adaptive control in task space: it estimates the mass and the centre of mass of platform and payload."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins.controller import Tunable
from cdpr_controllers.law import WrenchLaw

GAINS, RATES, RANGE = ("slope", "kd"), ("mass_gain", "center_gain"), ("mass_min", "mass_max", "center_max")


class Adaptive(WrenchLaw):
    """Law of Slotine and Li with estimates of the mass m and the first moment h = m c, c the centre of mass.

    With the error e = x_d - x of the pose, the composite error s = e' + slope e and the reference velocity v_r = v + s,
    the law is

        wrench = Y theta + (rest) + kd M_0 s,   theta' = Gamma Y^T s,   theta = (m, h),

    where Y theta + (rest) is the wrench for the reference acceleration a_r = a_d + slope e', and M_0 the nominal
    inertia. The inertia about the platform's origin is the nominal one and not estimated: that of a payload acts as a
    disturbance, unless the nominal robot contains it. With d = theta - theta_true, V = (s^T M s + d^T Gamma^-1 d) / 2
    falls by kd s^T M_0 s per second, so the error vanishes for any mass and centre of mass. The estimates converge to
    the true values only if the motion excites them: gravity alone shows the mass and the horizontal distance of the
    centre, and a rotation about a horizontal axis its height.

    The estimates stay within their range, and do not change if the cables did not exert the requested wrench in the
    previous step. Once a step, theta' is integrated by Euler's method. Noise and other disturbances, such as friction,
    are taken for a mass: the estimates then drift within their range.

    Source: Slotine and Li, "On the adaptive control of robot manipulators" (1987); the regressor of a rigid body is in
    adaptive.hpp. For small attitude errors, whose rate is the difference of the angular velocities.
    """

    operation = "adaptive"
    gains_shape = (2,)

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        self._check_center(robot, options)
        self._rates, self._range = np.zeros(2), np.array([getattr(options, name) for name in RANGE])
        deviation = np.zeros(4)
        self.arrays = (deviation,)
        more = {"rates": self._rates, "range": self._range, "report": np.zeros(4), "deviation": deviation}
        estimates = {"mass": np.zeros(1), "center": np.zeros(3)}
        super().__init__(robot, gravity, control_step, options, **more, **estimates)

    def _check_center(self, robot: Robot, options: Any) -> None:
        farthest = float(np.abs(robot.platform.center_of_mass).max())
        if farthest > options.center_max:
            raise CdprError(
                f"adaptive: the platform's nominal centre of mass has a coordinate of {farthest:g} m, beyond the range "
                f"of the estimate: set center_max above it, now {options.center_max:g} m"
            )

    def change(self, options: Any) -> None:
        """Set new gains; the estimates keep their values."""
        self._given["gains"][:] = [getattr(options, name) for name in GAINS]
        self._rate = np.array([getattr(options, name) for name in RATES])
        self._rates[:] = self._rate * self.control_step

    def renew(self, robot: Robot) -> bool:
        """Use other nominal mass properties; the differences of the estimates from them stay."""
        self._check_center(robot, self.options)
        return super().renew(robot)

    def connect(self, report: Array) -> None:
        """Read the result of the wrench from the report of the tension stage."""
        self._give(report=report)

    def log(self, columns: Mapping[str, Array]) -> None:
        """Write the estimates into their columns."""
        self._give(mass=columns["estimated_mass"], center=columns["estimated_center"])

    def tunable(self) -> Mapping[str, Tunable]:
        """Return the gains."""
        gains, rates = self._given["gains"], self._rates
        plain = {name: Tunable(gains[k : k + 1], gains[k : k + 1].copy()) for k, name in enumerate(GAINS)}
        stepped = {
            name: Tunable(rates[k : k + 1], self._rate[k : k + 1].copy(), per_step=True) for k, name in enumerate(RATES)
        }
        return {**plain, **stepped}

    def reset(self) -> None:
        """Return to the nominal values."""
        self.arrays[0][:] = 0.0
