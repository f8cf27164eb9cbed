"""Built-in estimators: metadata and options. Implementations are imported when used."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cdpr.base.defaults import ESTIMATOR
from cdpr.base.fields import MAX_MAGNITUDE, NonNegative, Positive, unit
from cdpr.plugins import Column, PluginInfo, PluginOptions, hookimpl

RESIDUAL = Column(
    "fit_residual",
    1,
    "m",
    "Norm of the differences between the measured lengths and those of the fitted pose; NaN if no pose fits, 0 without "
    "a fit",
)


class ForwardKinematicsOptions(PluginOptions):
    """Options of the estimator `forward_kinematics`."""

    filter_time: Annotated[NonNegative, Field(le=10.0)] = Field(
        0.0,
        description="time constant of the first-order filter of the velocities; 0: plain differences of the poses",
        json_schema_extra=unit("s"),
    )


class ComplementaryOptions(PluginOptions):
    """Options of the estimator `complementary`."""

    bandwidth: Positive = Field(
        10.0,
        description="bandwidth of the correction of position and velocity by the measured or fitted pose",
        json_schema_extra=unit("rad/s"),
    )
    attitude_gain: Positive = Field(
        5.0, description="gain of the correction of the attitude, k_P of Mahony et al.", json_schema_extra=unit("1/s")
    )
    bias_gain: NonNegative = Field(
        0.5,
        description="gain of the estimate of the gyroscope's bias, k_I of Mahony et al.",
        json_schema_extra=unit("1/s^2"),
    )


UNUSED = "bias", "drift", "gain", "hysteresis"  # believed errors that no estimator here corrects
LEAST_FLOOR = 1e-12  # its square is far above the smallest normal number, so that no variance becomes 0
Deviation = Annotated[NonNegative, Field(le=MAX_MAGNITUDE)]


class EkfOptions(PluginOptions):
    """Options of the estimator `ekf`."""

    force_noise: Deviation | None = Field(
        None,
        description="density of the unknown force on the platform, white noise; default: 0.001 of the weight",
        json_schema_extra=unit("N sqrt(s)"),
    )
    moment_noise: Deviation | None = Field(
        None,
        description="density of the unknown moment; default: that of the force times the characteristic length",
        json_schema_extra=unit("N m sqrt(s)"),
    )
    noise_floor: Annotated[float, Field(ge=LEAST_FLOOR, le=MAX_MAGNITUDE)] = Field(
        1e-6, description="smallest standard deviation of a measured value, in its unit; for sensors without noise"
    )
    position_error: Deviation = Field(
        0.01, description="standard deviation of the position at the start", json_schema_extra=unit("m")
    )
    rotation_error: Deviation = Field(
        0.01, description="standard deviation of the attitude at the start", json_schema_extra=unit("rad")
    )
    velocity_error: Deviation = Field(
        0.01, description="standard deviation of the velocity at the start", json_schema_extra=unit("m/s")
    )
    turn_rate_error: Deviation = Field(
        0.01, description="standard deviation of the angular velocity at the start", json_schema_extra=unit("rad/s")
    )


@hookimpl
def cdpr_estimators() -> list[PluginInfo]:
    """Return the built-in estimators."""
    return [
        PluginInfo(
            name=ESTIMATOR,
            factory="cdpr_controllers.estimators.none:Measured",
            summary="no estimator: the first measured pose and twist, or the true state without such sensors",
            properties={"direct": True, "sensors": ("pose", "twist")},
        ),
        PluginInfo(
            name="forward_kinematics",
            factory="cdpr_controllers.estimators.forward_kinematics:ForwardKinematics",
            summary="pose from the encoders by forward kinematics, velocities by differences, filtered on request",
            properties={"sensors": ("encoders",), "chord_lengths": True, "unused_errors": UNUSED},
            options=ForwardKinematicsOptions,
            columns=(RESIDUAL,),
        ),
        PluginInfo(
            name="complementary",
            factory="cdpr_controllers.estimators.complementary:Complementary",
            summary="integrated IMU, corrected by a measured pose or by forward kinematics (Mahony et al. 2008)",
            properties={"sensors": ("imu", "encoders"), "chord_lengths": ("pose",), "unused_errors": UNUSED},
            options=ComplementaryOptions,
            columns=(RESIDUAL,),
        ),
        PluginInfo(
            name="ekf",
            factory="cdpr_controllers.estimators.ekf:Ekf",
            summary="error-state Kalman filter of the platform's state, from several types of sensors (Sola)",
            properties={"sensors": ("encoders",), "covariance": True, "innovation": True, "unused_errors": UNUSED},
            options=EkfOptions,
        ),
    ]
