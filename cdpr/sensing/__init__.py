"""Sensors: what controllers see of the true state; one module per type, and their table.

To add a type, write its module and list it here.

Example:
    >>> import cdpr
    >>> cdpr.sensing.Pose(name="mocap", period=0.01, position={"noise": 0.001}).title
    'mocap'
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cdpr.base.kinds import Kinds
from cdpr.base.lazy import lazily
from cdpr.sensing.errors import AttitudeErrors, Errors
from cdpr.sensing.sensor import Sensor

if TYPE_CHECKING:
    from cdpr.sensing.camera import Camera
    from cdpr.sensing.encoders import Encoders
    from cdpr.sensing.imu import Imu
    from cdpr.sensing.markers import Markers
    from cdpr.sensing.pose import Pose
    from cdpr.sensing.range import Range
    from cdpr.sensing.receiver import Receiver
    from cdpr.sensing.scan import Scan
    from cdpr.sensing.tension import Tension
    from cdpr.sensing.twist import Twist

__all__ = [
    "MAX_SENSORS",
    "SENSORS",
    "AnySensor",
    "AttitudeErrors",
    "Camera",
    "Encoders",
    "Errors",
    "Imu",
    "Markers",
    "Pose",
    "Range",
    "Receiver",
    "Scan",
    "Sensor",
    "Tension",
    "Twist",
]

MAX_SENSORS = 100

SENSORS: Kinds[Sensor] = Kinds(
    {
        "pose": "cdpr.sensing.pose:Pose",
        "twist": "cdpr.sensing.twist:Twist",
        "encoders": "cdpr.sensing.encoders:Encoders",
        "tension": "cdpr.sensing.tension:Tension",
        "imu": "cdpr.sensing.imu:Imu",
        "receiver": "cdpr.sensing.receiver:Receiver",
        "range": "cdpr.sensing.range:Range",
        "scan": "cdpr.sensing.scan:Scan",
        "markers": "cdpr.sensing.markers:Markers",
        "camera": "cdpr.sensing.camera:Camera",
    }
)
AnySensor = Annotated[Sensor, SENSORS]

if not TYPE_CHECKING:  # imported when first used
    _homes = (home.partition(":") for home in SENSORS.homes.values())
    __getattr__ = lazily(__name__, {name: module for module, _, name in _homes})

    def __dir__() -> list[str]:
        return __all__
