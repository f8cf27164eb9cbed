"""Velocity of the platform, as motion capture estimates it."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from cdpr.base.columns import WORLD
from cdpr.base.needs import Needs, of_sensor
from cdpr.sensing.errors import Errors
from cdpr.sensing.sensor import Quantity, Sensor, Sources, Truth, Used


class Twist(Sensor):
    """Sensor of the platform's velocities. A controller without estimator uses it instead of the true ones.

    Example:
        >>> import cdpr
        >>> cdpr.sensing.Twist(velocity={"noise": 0.01}).velocity.noise
        0.01
    """

    needs: ClassVar[Needs] = of_sensor()
    quantities: ClassVar[tuple[Quantity, ...]] = (
        Quantity("velocity", 3, "m/s", "Velocity of the origin", WORLD),
        Quantity("turn_rate", 3, "rad/s", "Angular velocity", WORLD),
    )
    used: ClassVar[Used] = "twist"

    type: Literal["twist"] = "twist"
    velocity: Errors = Field(Errors(), description="errors of the velocity, m/s")
    turn_rate: Errors = Field(Errors(), description="errors of the angular velocity, rad/s")

    def truth(self, sources: Sources) -> Truth:
        """Return velocity and angular velocity (6,)."""
        return Truth(sources.state[7:])
