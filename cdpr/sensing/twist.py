"""Velocity of the platform, as motion capture estimates it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

from pydantic import Field

from cdpr.base.column import WORLD
from cdpr.base.needs import Needs, of_sensor
from cdpr.model.robot import Array
from cdpr.sensing.errors import Errors
from cdpr.sensing.message import Message, pose_covariance, quantity
from cdpr.sensing.records import Records
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
    measurement: ClassVar[str] = "twist"

    type: Literal["twist"] = "twist"
    velocity: Errors = Field(Errors(), description="errors of the velocity, m/s")
    turn_rate: Errors = Field(Errors(), description="errors of the angular velocity, rad/s")

    def truth(self, sources: Sources) -> Truth:
        """Return velocity and angular velocity (6,)."""
        return Truth(sources.state[7:])

    def message(self, cables: Sequence[str]) -> Message:
        """Return the velocities."""
        fields = {"twist.twist.linear": quantity("velocity"), "twist.twist.angular": quantity("turn_rate")}
        covariance = pose_covariance(self.velocity.noise, self.turn_rate.noise)
        return Message("geometry_msgs/TwistWithCovarianceStamped", fields, {"twist": {"covariance": covariance}})

    def recorded_truth(self, key: str, records: Records) -> Array | None:
        """Return velocities or angular velocities."""
        return records.velocity if key == "velocity" else records.turn_rate
