"""Pose of the platform, as motion capture measures it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

from pydantic import Field

from cdpr.base.column import WORLD
from cdpr.base.needs import Needs, of_sensor
from cdpr.model.robot import Array
from cdpr.sensing.errors import AttitudeErrors, Errors
from cdpr.sensing.message import XYZW, Message, pose_covariance, quantity
from cdpr.sensing.records import Records
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
    locates: ClassVar[bool] = True
    measurement: ClassVar[str] = "pose"

    type: Literal["pose"] = "pose"
    position: Errors = Field(Errors(), description="errors of the position, m")
    attitude: AttitudeErrors = Field(AttitudeErrors(), description="errors of the attitude, rad")

    def truth(self, sources: Sources) -> Truth:
        """Return position and quaternion (7,)."""
        return Truth(sources.state[:7])

    def message(self, cables: Sequence[str]) -> Message:
        """Return the pose."""
        fields = {"pose.pose.position": quantity("position"), "pose.pose.orientation": quantity("attitude", XYZW)}
        covariance = pose_covariance(self.position.noise, self.attitude.noise)
        return Message("geometry_msgs/PoseWithCovarianceStamped", fields, {"pose": {"covariance": covariance}})

    def recorded_truth(self, key: str, records: Records) -> Array | None:
        """Return positions or quaternions."""
        return records.position if key == "position" else records.attitude
