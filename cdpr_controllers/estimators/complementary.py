"""Complementary filter: an integrated inertial measurement unit, corrected by a pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import SensorModel
from cdpr.sensing import Encoders, Imu, Pose
from cdpr_controllers.estimators.compiled import CompiledEstimator
from cdpr_controllers.estimators.length_fit import LengthFit

# Largest gain times the time between two poses, as in complementary.hpp: a correction then removes at most this share
# of an error, twice for the position, without overshoot. The gain of the bias times this time is at most this share of
# that of the attitude: the corrections of both diverge from a share of 1 on.
LARGEST_SHARE = 0.5


class Complementary(CompiledEstimator):
    """State by integration of the IMU at its rate, corrected by the first measured pose, else by forward kinematics.

    The attitude is that of the passive complementary filter with bias of Mahony, Hamel and Pflimlin, Nonlinear
    complementary filters on the special orthogonal group, IEEE TAC 53(5), 2008. Position and velocity follow

        p' = v + 2 w (p_m - p),   v' = R f + g + w^2 (p_m - p)

    for the place of the IMU, with its specific force f, the bandwidth w and the measured position p_m, so that their
    error decays with two equal poles -w. After a gap between poses, such as an occlusion, the next pose corrects as
    after a time of 0.5 / w. Delays of the measurements are not compensated. A guided platform is estimated as a free
    one. It provides no covariance.

    Raises:
        CdprError: without an IMU, without pose sensor and encoders, or with gains too large for their period.
    """

    def __init__(
        self, robot: Robot, gravity: Array, control_step: float, sensors: Sequence[SensorModel], options: Any
    ) -> None:
        super().__init__(robot, gravity, control_step, sensors, options)
        self._imu = self.first(Imu)
        poses = self.of_type(Pose)
        self._fit: LengthFit | None = None
        if poses:
            self._corrector = poses[0]
        elif self.of_type(Encoders):
            self._corrector = self.first(Encoders)
            self._fit = LengthFit(robot, self._corrector)
        else:
            raise CdprError(
                "the estimator corrects the IMU by a pose: add a sensor of the type pose or encoders to sensors"
            )
        gains = {key: float(getattr(options, key)) for key in ("bandwidth", "attitude_gain", "bias_gain")}
        period = self._corrector.sensor.period or control_step
        for key in ("bandwidth", "attitude_gain"):
            if gains[key] * period > LARGEST_SHARE:
                raise CdprError(
                    f"estimator.{key}: expected at most {LARGEST_SHARE / period:g} with a period of {period:g} s of "
                    f"sensor '{self._corrector.title}', got {gains[key]:g}"
                )
        if gains["bias_gain"] * period > LARGEST_SHARE * gains["attitude_gain"]:
            most = LARGEST_SHARE * gains["attitude_gain"] / period
            raise CdprError(
                f"estimator.bias_gain: expected at most {most:g} with attitude_gain {gains['attitude_gain']:g} and a "
                f"period of {period:g} s of sensor '{self._corrector.title}', got {gains['bias_gain']:g}"
            )
        self._gains, self._gravity = np.array(list(gains.values())), np.array(gravity, dtype=np.float64)
        self._memory, self._residual = np.zeros(18), np.zeros(1)
        self.arrays = (self._memory, *(self._fit.arrays if self._fit else ()))

    def log(self, columns: Mapping[str, Array]) -> None:
        """Write the residual of the fit into its column; 0 without a fit."""
        self._residual = columns["fit_residual"]

    def compiled(self, out: Array) -> list[Any]:
        """Return the fit of the pose, if it is not measured, and the filter."""
        imu, corrector, fit = self._imu, self._corrector, self._fit
        mount: Any = imu.sensor
        filtering = bind(
            "complementary_filter",
            inertial=imu.measured,
            moved=imu.fresh,
            moved_age=imu.age,
            pose=fit.pose if fit else corrector.measured,
            valid=fit.fits if fit else np.ones(1),
            corrects=corrector.fresh,
            pose_age=corrector.age,
            start=self._start,
            point=np.array(mount.point, dtype=np.float64),
            gravity=self._gravity,
            gains=self._gains,
            memory=self._memory,
            estimate=out,
        )
        if fit is None:
            return [bind("copy", source=np.zeros(1), target=self._residual), filtering]
        fit.residual = self._residual
        return [fit.bound(self._start), filtering]
