"""Desired motions, one module per type, and their table. To add a type, write its module and list it here.

Example:
    >>> import cdpr
    >>> cdpr.motions.Quintic(duration=2.0, to={"position": [0.2, 0.0, 1.0]}).to.position
    (0.2, 0.0, 1.0)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cdpr.base.kinds import Kinds
from cdpr.base.lazy import lazily
from cdpr.scenario.motions.motion import Motion, Pose

if TYPE_CHECKING:
    from cdpr.scenario.motions.circle import Circle, Helix
    from cdpr.scenario.motions.csv import Csv
    from cdpr.scenario.motions.gcode import Gcode
    from cdpr.scenario.motions.hold import Hold
    from cdpr.scenario.motions.jerk_limited import AngularLimits, JerkLimited, Limits, Stop
    from cdpr.scenario.motions.pick_and_place import PickAndPlace
    from cdpr.scenario.motions.quintic import Knot, Quintic
    from cdpr.scenario.motions.waypoints import Waypoint, Waypoints

_PARTS = {
    "AngularLimits": "cdpr.scenario.motions.jerk_limited",
    "Knot": "cdpr.scenario.motions.quintic",
    "Limits": "cdpr.scenario.motions.jerk_limited",
    "Stop": "cdpr.scenario.motions.jerk_limited",
    "Waypoint": "cdpr.scenario.motions.waypoints",
}

__all__ = [
    "MOTIONS",
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

if not TYPE_CHECKING:  # imported when first used
    _homes = (home.partition(":") for home in MOTIONS.homes.values())
    __getattr__ = lazily(__name__, {name: module for module, _, name in _homes} | _PARTS)

    def __dir__() -> list[str]:
        return __all__
