"""Pose of the platform, as motion capture measures it."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from cdpr.base.columns import WORLD
from cdpr.base.needs import Needs, of_sensor
from cdpr.sensing.errors import AttitudeErrors, Errors
from cdpr.sensing.sensor import Quantity, Sensor, Sources, Truth, Used


class Pose(Sensor):
    """Sensor of the platform's position and attitude. A controller without estimator uses it instead of the true pose.

    Example:
        >>> import cdpr
        >>> cdpr.sensing.Pose(position={"noise": 0.001}, delay=0.004).position.noise
        0.001
    """

    needs: ClassVar[Needs] = of_sensor()
    quantities: ClassVar[tuple[Quantity, ...]] = (
        Quantity("position", 3, "m", "Platform origin", WORLD),
        Quantity("attitude", 4, "", "Attitude quaternion w, x, y, z", WORLD),
    )
    used: ClassVar[Used] = "pose"

    type: Literal["pose"] = "pose"
    position: Errors = Field(Errors(), description="errors of the position, m")
    attitude: AttitudeErrors = Field(AttitudeErrors(), description="errors of the attitude, rad")

    def truth(self, sources: Sources) -> Truth:
        """Return position and quaternion (7,)."""
        return Truth(sources.state[:7])
