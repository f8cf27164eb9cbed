"""Built-in estimators."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cdpr.base.fields import MAX_MAGNITUDE, Vector3
from cdpr.plugins import PluginOptions

Deviation = Annotated[float, Field(ge=0.0, le=MAX_MAGNITUDE)]
ZERO = (0.0, 0.0, 0.0)


class EkfOptions(PluginOptions):
    """Options of the estimator `ekf`."""

    force_noise: Deviation | None = Field(
        None,
        description="density of the unknown force on the platform, white noise; default: 0.001 of the weight",
        json_schema_extra={"unit": "N sqrt(s)"},
    )
    moment_noise: Deviation | None = Field(
        None,
        description="density of the unknown moment; default: that of the force times the characteristic length",
        json_schema_extra={"unit": "N m sqrt(s)"},
    )
    noise_floor: Annotated[float, Field(gt=0.0, le=MAX_MAGNITUDE)] = Field(
        1e-6, description="smallest standard deviation of a measured value, in its unit; for sensors without noise"
    )
    position_error: Deviation = Field(
        0.01, description="standard deviation of the position at the start", json_schema_extra={"unit": "m"}
    )
    rotation_error: Deviation = Field(
        0.01, description="standard deviation of the attitude at the start", json_schema_extra={"unit": "rad"}
    )
    velocity_error: Deviation = Field(
        0.01, description="standard deviation of the velocity at the start", json_schema_extra={"unit": "m/s"}
    )
    turn_rate_error: Deviation = Field(
        0.01, description="standard deviation of the angular velocity at the start", json_schema_extra={"unit": "rad/s"}
    )
    position_offset: Vector3 = Field(
        ZERO, description="offset of the first estimate from the start, world axes", json_schema_extra={"unit": "m"}
    )
    rotation_offset: Vector3 = Field(
        ZERO,
        description="rotation vector of the first estimate from the attitude at the start, platform axes",
        json_schema_extra={"unit": "rad"},
    )
