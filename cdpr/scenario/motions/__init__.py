"""Desired motions, one module per type, and their table. To add a type, write its module and list it here.

Example:
    >>> import cdpr
    >>> cdpr.motions.Quintic(duration=2.0, to={"position": [0.2, 0.0, 1.0]}).to.position
    (0.2, 0.0, 1.0)
"""

from __future__ import annotations

from typing import Annotated

from cdpr.base.kinds import Kinds
from cdpr.scenario.motions.motion import Motion, Pose

__all__ = ["MOTIONS", "AnyMotion", "Motion", "Pose"]

MOTIONS: Kinds[Motion] = Kinds(
    {
        "hold": "cdpr.scenario.motions.hold:Hold",
        "quintic": "cdpr.scenario.motions.quintic:Quintic",
        "waypoints": "cdpr.scenario.motions.waypoints:Waypoints",
        "pick_and_place": "cdpr.scenario.motions.pick_and_place:PickAndPlace",
        "circle": "cdpr.scenario.motions.circle:Circle",
        "helix": "cdpr.scenario.motions.circle:Helix",
        "jerk_limited": "cdpr.scenario.motions.jerk_limited:JerkLimited",
        "csv": "cdpr.scenario.motions.csv:Csv",
        "gcode": "cdpr.scenario.motions.gcode:Gcode",
    }
)
AnyMotion = Annotated[Motion, MOTIONS]
