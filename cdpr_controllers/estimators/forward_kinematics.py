"""State from the encoders: forward kinematics, and differences of the poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import SensorModel
from cdpr.sensing import Encoders
from cdpr_controllers.estimators.compiled import CompiledEstimator
from cdpr_controllers.estimators.length_fit import LengthFit


class ForwardKinematics(CompiledEstimator):
    """Pose that fits the measured lengths, held between measurements; velocities by differences of the poses.

    The differences magnify noise by one over the period of the encoders: 0.5 mm at 1 kHz give about 0.5 m/s.
    `filter_time` reduces that, and delays the velocities by that time. It provides no covariance.
    """

    def __init__(
        self, robot: Robot, gravity: Array, control_step: float, sensors: Sequence[SensorModel], options: Any
    ) -> None:
        super().__init__(robot, gravity, control_step, sensors, options)
        self._encoders = self.first(Encoders)
        self._fit = LengthFit(robot, self._encoders)
        self._before = np.zeros(8)
        self.arrays = (*self._fit.arrays, self._before)

    def log(self, columns: Mapping[str, Array]) -> None:
        """Write the residual of the fit into its column."""
        self._fit.residual = columns["fit_residual"]

    def compiled(self, out: Array) -> list[Any]:
        """Return the fit, and the differences."""
        encoders, fit = self._encoders, self._fit
        about = {"fresh": encoders.fresh, "age": encoders.age, "start": self._start}
        differences = bind(
            "pose_differences",
            pose=fit.pose,
            fits=fit.fits,
            **about,
            before=self._before,
            estimate=out,
            filter_time=float(self.options.filter_time if self.options else 0.0),
        )
        return [fit.bound(self._start), differences]
