"""Sliding-mode control in task space with a boundary layer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins.controller import Tunable
from cdpr_controllers.law import WrenchLaw

PARTS = ("slope", "gain", "layer")
SURFACE = {"surface": "sliding_velocity", "spin_surface": "sliding_turn_rate"}  # arrays of the law, columns


class SlidingMode(WrenchLaw):
    """Inverse dynamics with a switching term that rejects bounded disturbances.

    The sliding variable is s = e' + slope e with the error e = x_d - x, for position and attitude. The law is

        wrench = M a + C(omega) - G,   a = a_d + slope e' + gain s / max(|s|, layer),

    so s' = d - gain s / max(|s|, layer) with the disturbance d, an acceleration: that of unknown forces, a wrong mass,
    friction. If |d| <= D < gain,

    - |s| falls by gain - D or more per second, until it is at most layer D / gain;
    - then |e| falls to at most layer D / (gain slope).

    Within the boundary layer, |s| < layer, the law is linear: computed torque with kp = slope gain / layer and
    kd = slope + gain / layer. A thin layer has small errors, but amplifies noise, and chatters if the product of
    gain / layer and the delay of the loop (at least the control step) is not well below 1. With slope 10, gain 2 and
    layer 0.2, it is the law of `computed_torque` with kp = 100 and kd = 20, but limited to `gain`.

    Sources: Slotine and Li, Applied Nonlinear Control (1991), sections 7.1 and 7.2, boundary layer; Spong, Hutchinson
    and Vidyasagar, Robot Modeling and Control (2006), section 8.4, the direction s / |s| instead of the sign of each
    component. The law is the same in all axes.
    """

    operation = "sliding_mode"
    gains_shape = (3, 2)

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        surfaces = {name: np.zeros(3) for name in SURFACE}
        super().__init__(robot, gravity, control_step, options, **surfaces)

    def change(self, options: Any) -> None:
        """Set new slope, gain and layer."""
        for k, name in enumerate(PARTS):
            self._given["gains"][k] = getattr(options, name)

    def log(self, columns: Mapping[str, Array]) -> None:
        """Write the sliding variable into its column."""
        self._give(**{name: columns[column] for name, column in SURFACE.items()})

    def tunable(self) -> Mapping[str, Tunable]:
        """Return slope, gain and layer."""
        gains = self._given["gains"]
        return {name: Tunable(gains[k], gains[k].copy()) for k, name in enumerate(PARTS)}
