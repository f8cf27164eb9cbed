"""Desired motions, one module per type, and their table. To add a type, write its module and list it here."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cdpr.scenario.motions.circle import Circle, Helix
from cdpr.scenario.motions.csv import Csv
from cdpr.scenario.motions.gcode import Gcode
from cdpr.scenario.motions.hold import Hold
from cdpr.scenario.motions.jerk_limited import AngularLimits, JerkLimited, Limits, Stop
from cdpr.scenario.motions.motion import Motion, Pose
from cdpr.scenario.motions.pick_and_place import PickAndPlace
from cdpr.scenario.motions.quintic import Knot, Quintic
from cdpr.scenario.motions.waypoints import Waypoint, Waypoints

__all__ = [
    "AngularLimits",
    "AnyMotion",
    "Circle",
    "Csv",
    "Gcode",
    "Helix",
    "Hold",
    "JerkLimited",
    "Knot",
    "Limits",
    "Motion",
    "PickAndPlace",
    "Pose",
    "Quintic",
    "Stop",
    "Waypoint",
    "Waypoints",
]

AnyMotion = Annotated[
    Hold | Quintic | Waypoints | PickAndPlace | Circle | Helix | JerkLimited | Csv | Gcode, Field(discriminator="type")
]
