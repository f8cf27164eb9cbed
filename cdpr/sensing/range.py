"""Distance to the obstacles of the world along one ray, as a laser or ultrasonic sensor measures it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from pydantic import Field, field_validator

from cdpr.base.fields import Vector3
from cdpr.base.needs import Needs, of_sensor
from cdpr.model.robot import Array
from cdpr.sensing.message import Columns, Message, singles
from cdpr.sensing.rays import RaySensor, echoes
from cdpr.sensing.sensor import Quantity

if TYPE_CHECKING:
    from cdpr.scene.sensors import SensorDrawing

INFRARED = 1  # radiation type of the message


class Range(RaySensor):
    """Sensor of the distance to the nearest obstacle along a ray from the platform.

    Example:
        >>> import cdpr
        >>> cdpr.sensing.Range(direction=[0.0, 0.0, -1.0], reach=4.0).reach
        4.0
    """

    needs: ClassVar[Needs] = of_sensor()
    quantities: ClassVar[tuple[Quantity, ...]] = (
        Quantity("distance", 1, "m", "Distance to the nearest obstacle along the ray"),
    )

    type: Literal["range"] = "range"
    direction: Vector3 = Field(
        (0.0, 0.0, -1.0), description="direction of the ray, platform axes, of any length; default: down"
    )

    @field_validator("direction")
    @classmethod
    def _has_length(cls, value: Vector3) -> Vector3:
        if not np.linalg.norm(value) > 0.0:
            raise ValueError("expected a vector that is not 0")
        return value

    @property
    def directions(self) -> Array:
        """Unit vector along the ray (1, 3), platform axes."""
        return np.asarray(np.array([self.direction]) / np.linalg.norm(self.direction))

    def drawing(self, extent: float) -> SensorDrawing:
        """Return the ray; x of the sensor's axes is along it."""
        return replace(super().drawing(extent), attitude=_along(self.directions[0]))

    def message(self, cables: Sequence[str]) -> Message:
        """Return the distance."""

        def limit_and_range(read: Columns) -> Array:  # `range` follows `max_range`
            distances = read("distance")
            return singles(np.column_stack([np.full(len(distances), self.reach), echoes(distances, self.reach)]))

        constant = {"radiation_type": INFRARED, "variance": self.distance.noise**2}
        return Message("sensor_msgs/Range", {"max_range": limit_and_range}, constant, framed=True)


def _along(x: Array) -> Array:
    """Return the attitude (4,) of axes whose x is a unit vector (3,)."""
    q = np.array([1.0 + x[0], 0.0, -x[2], x[1]])  # along (1 + x . v, x cross v), for the shortest rotation from x to v
    size = float(np.linalg.norm(q))
    return q / size if size > 1e-9 else np.array([0.0, 0.0, 0.0, 1.0])  # backwards
