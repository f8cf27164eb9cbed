"""Inertial measurement unit on the platform."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from pydantic import Field

from cdpr.base.column import PLATFORM
from cdpr.base.fields import ZERO, Position, unit
from cdpr.base.needs import Needs, of_sensor
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.sensing.disturbance import Mount
from cdpr.sensing.errors import Errors
from cdpr.sensing.message import Message, covariance, quantity
from cdpr.sensing.records import Records
from cdpr.sensing.sensor import Quantity, Sensor, Sources, Truth
from cdpr.tension.operations import Operation

if TYPE_CHECKING:
    from cdpr.scene.sensors import SensorDrawing

UNKNOWN = -1.0  # first value of the covariance of a quantity that the message does not contain
LEAST = 1e-6  # relative: a period nearer to a whole number of rows is one


class Imu(Sensor):
    """Sensor of specific force and turn rate at a point of the platform, in its axes.

    The specific force is the mean over a period, (v(t) - v(t - period)) / period - g, so it does not depend on the
    engine; at rest it is g upwards. At time 0 it is that of rest.

    Example:
        >>> import cdpr
        >>> cdpr.sensing.Imu(point=[0.0, 0.0, 0.1], turn_rate={"noise": 1e-3, "drift": 1e-4}).turn_rate.drift
        0.0001
    """

    needs: ClassVar[Needs] = of_sensor()
    mount: ClassVar[tuple[str, ...]] = ("place", "axes")
    measurement: ClassVar[str] = "imu"
    quantities: ClassVar[tuple[Quantity, ...]] = (
        Quantity("force", 3, "m/s^2", "Mean specific force since the measurement before", PLATFORM),
        Quantity("turn_rate", 3, "rad/s", "Angular velocity", PLATFORM),
    )

    type: Literal["imu"] = "imu"
    point: Position = Field(ZERO, description="its place, platform axes", json_schema_extra=unit("m"))
    force: Errors = Field(Errors(), description="errors of the specific force, m/s^2")
    turn_rate: Errors = Field(Errors(), description="errors of the angular velocity, rad/s")

    def truth(self, sources: Sources) -> Truth:
        """Return specific force and turn rate (6,), platform axes."""
        period = self.period or sources.step
        values, before, count = np.zeros(6), np.zeros(3), np.zeros(1)
        mount = Mount(np.array(self.point), np.array([1.0, 0.0, 0.0, 0.0]))
        write = bind(
            "inertial_motion",
            state=sources.state,
            point=mount.place,
            attitude=mount.axes,
            gravity=sources.gravity,
            before=before,
            count=count,
            truth=values,
            period=period,
            every=round(period / sources.step),
        )
        return Truth(values, (Operation("sensors", write, timed=True),), (values, before, count), mount)

    def drawing(self, extent: float) -> SensorDrawing:
        """Return its place."""
        from cdpr.scene.sensors import SensorDrawing  # validation needs no drawings

        return SensorDrawing(self.title, True, np.array(self.point))

    def message(self, cables: Sequence[str]) -> Message:
        """Return specific force and turn rate."""
        fields = {"angular_velocity": quantity("turn_rate"), "linear_acceleration": quantity("force")}
        constant = {
            "orientation": {"w": 1.0},
            "orientation_covariance": [UNKNOWN, *[0.0] * 8],
            "angular_velocity_covariance": covariance(self.turn_rate.noise),
            "linear_acceleration_covariance": covariance(self.force.noise),
        }
        return Message("sensor_msgs/Imu", fields, constant, framed=True)

    def recorded_truth(self, key: str, records: Records) -> Array | None:
        """Return turn rates, or specific forces if its period is a multiple of that of the rows."""
        if key == "turn_rate":
            return records.to_platform(records.turn_rate)
        period = self.period or records.step
        rows = period / (records.every * records.step)
        if abs(rows - round(rows)) > LEAST * rows:
            return None
        n, arm = max(1, round(rows)), records.to_world(np.array(self.point))
        velocity = records.velocity + rotations.cross(records.turn_rate, arm)
        gained = np.zeros_like(velocity)
        gained[n:] = (velocity[n:] - velocity[:-n]) / period
        return records.to_platform(gained - records.gravity)
