"""Inertial measurement unit on the platform."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from cdpr.base.fields import ZERO, Position, unit
from cdpr.base.needs import Needs, of_sensor
from cdpr.native.bind import bind
from cdpr.sensing.disturbance import Mount
from cdpr.sensing.errors import Errors
from cdpr.sensing.sensor import Quantity, Sensor, Sources, Truth
from cdpr.tension.operations import Operation


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
    quantities: ClassVar[tuple[Quantity, ...]] = (
        Quantity("force", 3, "m/s^2", "Mean specific force since the measurement before, platform axes"),
        Quantity("turn_rate", 3, "rad/s", "Angular velocity, platform axes"),
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
