"""Position of a point on the platform, as a receiver of satellites or of radio beacons measures it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from pydantic import Field

from cdpr.base.column import WORLD
from cdpr.base.fields import ZERO, Position, unit
from cdpr.base.needs import Needs, of_sensor
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.sensing.disturbance import Mount
from cdpr.sensing.errors import Errors
from cdpr.sensing.message import Message, quantity
from cdpr.sensing.records import Records
from cdpr.sensing.sensor import Quantity, Sensor, Sources, Truth
from cdpr.tension.operations import Operation

if TYPE_CHECKING:
    from cdpr.scene.sensors import SensorDrawing


class Receiver(Sensor):
    """Sensor of the position of an antenna on the platform.

    Example:
        >>> import cdpr
        >>> cdpr.sensing.Receiver(antenna=[0.0, 0.0, 0.4], period=0.1, position={"noise": 0.02}).period
        0.1
    """

    needs: ClassVar[Needs] = of_sensor()
    mount: ClassVar[tuple[str, ...]] = ("place",)
    quantities: ClassVar[tuple[Quantity, ...]] = (Quantity("position", 3, "m", "Position of the antenna", WORLD),)
    locates: ClassVar[bool] = True
    measurement: ClassVar[str] = "receiver"

    type: Literal["receiver"] = "receiver"
    antenna: Position = Field(ZERO, description="place of the antenna, platform axes", json_schema_extra=unit("m"))
    position: Errors = Field(Errors(), description="errors of the position, m")

    def truth(self, sources: Sources) -> Truth:
        """Return the position of the antenna (3,), world axes."""
        values = np.zeros(3)
        mount = Mount(np.array(self.antenna), np.zeros((0, 3)))
        write = bind("point_on_platform", state=sources.state, point=mount.place, position=values)
        return Truth(values, (Operation("sensors", write, timed=True),), (values,), mount)

    def measurement_numbers(self) -> list[float]:
        """Return the place of the antenna."""
        return list(self.antenna)

    def drawing(self, extent: float) -> SensorDrawing:
        """Return the antenna."""
        from cdpr.scene.sensors import SensorDrawing  # validation needs no drawings

        return SensorDrawing(self.title, True, np.array(self.antenna))

    def message(self, cables: Sequence[str]) -> Message:
        """Return the position."""
        return Message("geometry_msgs/PointStamped", {"point": quantity("position")}, {})

    def recorded_truth(self, key: str, records: Records) -> Array:
        """Return the positions of the antenna."""
        return records.position + records.to_world(np.array(self.antenna))
