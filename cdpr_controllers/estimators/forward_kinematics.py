"""State from the encoders: forward kinematics, and differences of the poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import Compiled, bind
from cdpr.plugins import Estimator, EstimatorInputs, SensorModel, SnapshotOfArrays
from cdpr.sensing import Encoders
from cdpr_controllers.estimators.length_fit import LengthFit


class ForwardKinematics(SnapshotOfArrays, Estimator):
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
        self._before, self._start = np.zeros(8), np.zeros(13)
        self.arrays = (*self._fit.arrays, self._before)
        self._own: tuple[Array, list[Compiled]] | None = None

    def connect(self, inputs: EstimatorInputs) -> None:
        """Begin at the assumed initial state."""
        self._start = inputs.start

    def log(self, columns: Mapping[str, Array]) -> None:
        """Write the residual of the fit into its column."""
        self._fit.residual = columns["fit_residual"]

    def estimate(self, time: float, out: Array) -> None:
        """Write the state (13,)."""
        if self._own is None or self._own[0] is not out:
            self._own = out, self.compiled(out)
        for operation in self._own[1]:
            operation(time)  # type: ignore[operator]

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
