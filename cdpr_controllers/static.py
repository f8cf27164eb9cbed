"""Static control: gravity compensation with proportional and damping terms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import Controller, SnapshotOfArrays
from cdpr.plugins.controller import Tunable
from cdpr_controllers.law import Law


class Static(SnapshotOfArrays, Controller):
    """Gravity compensation at the current pose with proportional and damping terms towards the desired state.

    wrench = M (kd (v_d - v) + kp (x_d - x)) - G. Without desired acceleration and velocity-dependent terms, the
    platform lags behind a moving target. With both gains zero, the law is pure statics. (The code of the thesis uses
    gains of 50.)
    """

    arrays = ()  # no internal state

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        super().__init__(robot, gravity, control_step, options)
        self._gains = np.zeros(12)
        self.change(options)
        self._body = {"inertial": robot.inertial.copy(), "gravity": np.array(gravity, dtype=np.float64)}
        self._law = Law(self._bound, 6)

    def change(self, options: Any) -> None:
        """Set new gains."""
        self._gains[:6], self._gains[6:] = options.kp, options.kd

    def renew(self, robot: Robot) -> bool:
        """Use the mass properties of another platform."""
        self.robot = robot
        self._body["inertial"][:] = robot.inertial
        return True

    def control(self, time: float, state: Array, desired: Array, wrench: Array) -> None:
        """Write the wrench (6,)."""
        self._law(state, desired, wrench)

    def tunable(self) -> Mapping[str, Tunable]:
        """Return the gains."""
        kp, kd = self._gains[:6], self._gains[6:]
        return {"kp": Tunable(kp, kp.copy()), "kd": Tunable(kd, kd.copy())}

    def compiled(self, state: Array, desired: Array, out: Array) -> Callable[[], object]:
        """Return the law bound to these arrays."""
        return self._bound(state, desired, out)

    def _bound(self, state: Array, desired: Array, out: Array) -> Callable[[], object]:
        return bind("static", gains=self._gains, **self._body, state=state, desired=desired, wrench=out)
