"""Distance to the obstacles of the world along one ray, as a laser or ultrasonic sensor measures it."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field, field_validator

from cdpr.base.fields import ZERO, Position, Positive, Vector3, unit
from cdpr.base.needs import Needs, of_sensor
from cdpr.sensing.errors import Errors
from cdpr.sensing.rays import ray_truth
from cdpr.sensing.sensor import Quantity, Sensor, Sources, Truth


class Range(Sensor):
    """Sensor of the distance to the nearest obstacle along a ray from the platform.

    Example:
        >>> import cdpr
        >>> cdpr.sensing.Range(direction=[0.0, 0.0, -1.0], reach=4.0).reach
        4.0
    """

    needs: ClassVar[Needs] = of_sensor()
    mount: ClassVar[tuple[str, ...]] = ("place", "axes")
    quantities: ClassVar[tuple[Quantity, ...]] = (
        Quantity("distance", 1, "m", "Distance to the nearest obstacle along the ray"),
    )

    type: Literal["range"] = "range"
    point: Position = Field(ZERO, description="start of the ray, platform axes", json_schema_extra=unit("m"))
    direction: Vector3 = Field(
        (0.0, 0.0, -1.0), description="direction of the ray, platform axes, of any length; default: down"
    )
    reach: Positive = Field(10.0, description="distance without an obstacle", json_schema_extra=unit("m"))
    distance: Errors = Field(Errors(), description="errors of the distance, m")

    @field_validator("direction")
    @classmethod
    def _has_length(cls, value: Vector3) -> Vector3:
        if not np.linalg.norm(value) > 0.0:
            raise ValueError("expected a vector that is not 0")
        return value

    def truth(self, sources: Sources) -> Truth:
        """Return the distance (1,)."""
        direction = np.array([self.direction]) / np.linalg.norm(self.direction)
        return ray_truth(sources, self.point, direction, self.reach)
