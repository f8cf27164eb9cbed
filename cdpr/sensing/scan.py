"""Distances to the obstacles of the world along rays in a plane, as a laser scanner measures them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from cdpr.base.fields import Number, unit
from cdpr.base.needs import Needs, of_sensor
from cdpr.model.robot import Array
from cdpr.sensing.message import Columns, Message, singles
from cdpr.sensing.rays import RaySensor, echoes
from cdpr.sensing.sensor import Quantity

MOST_RAYS = 4096
Angle = Annotated[Number, Field(ge=-2.0 * np.pi, le=2.0 * np.pi)]


class Scan(RaySensor):
    """Planar scanner on the platform.

    Its rays are in the platform's x-y plane, from the angle `first` to `last` about z, measured from x.

    Example:
        >>> import cdpr
        >>> cdpr.sensing.Scan(first=-1.0, last=1.0, rays=3).directions.round(3)
        array([[ 0.54 , -0.841,  0.   ],
               [ 1.   ,  0.   ,  0.   ],
               [ 0.54 ,  0.841,  0.   ]])
    """

    needs: ClassVar[Needs] = of_sensor()

    type: Literal["scan"] = "scan"
    first: Angle = Field(-0.75 * np.pi, description="angle of the first ray", json_schema_extra=unit("rad"))
    last: Angle = Field(0.75 * np.pi, description="angle of the last ray", json_schema_extra=unit("rad"))
    rays: Annotated[int, Field(ge=2, le=MOST_RAYS)] = Field(181, description="number of rays")

    @property
    def quantities(self) -> tuple[Quantity, ...]:  # type: ignore[override]
        """Distances."""
        return (Quantity("distance", self.rays, "m", "Distance to the nearest obstacle along each ray"),)

    @property
    def directions(self) -> Array:
        """Directions of the rays (rays, 3), platform axes."""
        angles = np.linspace(self.first, self.last, self.rays)
        return np.column_stack([np.cos(angles), np.sin(angles), np.zeros(self.rays)])

    def message(self, cables: Sequence[str]) -> Message:
        """Return the distances."""

        def ranges(read: Columns) -> Array:  # an odd number is followed by the empty `intensities`
            return singles(echoes(read("distance"), self.reach))

        constant = {
            "angle_min": self.first,
            "angle_max": self.last,
            "angle_increment": (self.last - self.first) / (self.rays - 1),
            "scan_time": self.period,
            "range_max": self.reach,
            "ranges": [0.0] * self.rays,
        }
        return Message("sensor_msgs/LaserScan", {"ranges": ranges}, constant, framed=True)
