"""Where a run begins."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from cdpr.fields import ZERO, Position, Section, Vector3, unit
from cdpr.model.robot import Array
from cdpr.scenario.orientation import UPRIGHT, Orientation


class Initial(Section):
    """State of the platform at time 0, world axes."""

    position: Position = Field(
        description="position of the platform's origin; with the attitude that of the robot's home, if it has one and "
        "unless said",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(UPRIGHT, description="attitude; upright where only the position is said")
    velocity: Vector3 = Field(ZERO, description="velocity of the origin", json_schema_extra=unit("m/s"))
    angular_velocity: Vector3 = Field(ZERO, description="angular velocity", json_schema_extra=unit("rad/s"))

    def state(self) -> Array:
        """Return the state (13,), laid out as `cdpr.model` says."""
        return np.concatenate([self.position, self.orientation.quaternion(), self.velocity, self.angular_velocity])
