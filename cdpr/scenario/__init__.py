"""Scenario and robot files: from strict YAML to validated, typed data.

A file is read in phases. The problems of all phases are reported together, each as
`file:line:col: key: what is wrong, what is allowed`:

1. `yaml_nodes`: text to plain data with positions; rejects tags, merge keys and alias bombs.
2. `source`: applies overrides, inserts the robot file, and sets the initial pose to the robot's home by default
   (`beginning`).
3. `schema`, `robot_schema`, `motions`, `events`: types, units and ranges; `options`: the plugins' own models.
4. `robot_checks`, `run_checks`, `motion_checks`, `event_checks`: checks across sections.

`plausible` finds values that are allowed but probably not intended; `template` writes new files.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

_HOME = {
    "AngularLimits": "cdpr.scenario.motions.jerk_limited",
    "Circle": "cdpr.scenario.motions.circle",
    "Csv": "cdpr.scenario.motions.csv",
    "Euler": "cdpr.scenario.orientation",
    "Gcode": "cdpr.scenario.motions.gcode",
    "Helix": "cdpr.scenario.motions.circle",
    "Hold": "cdpr.scenario.motions.hold",
    "Initial": "cdpr.scenario.initial",
    "JerkLimited": "cdpr.scenario.motions.jerk_limited",
    "Knot": "cdpr.scenario.motions.quintic",
    "Limits": "cdpr.scenario.motions.jerk_limited",
    "Orientation": "cdpr.scenario.orientation",
    "PickAndPlace": "cdpr.scenario.motions.pick_and_place",
    "Pose": "cdpr.scenario.motions.motion",
    "Quintic": "cdpr.scenario.motions.quintic",
    "Scenario": "cdpr.scenario.scenario",
    "Simulation": "cdpr.scenario.schema",
    "Stop": "cdpr.scenario.motions.jerk_limited",
    "Waypoint": "cdpr.scenario.motions.waypoints",
    "Waypoints": "cdpr.scenario.motions.waypoints",
    "World": "cdpr.scenario.schema",
    "load_any": "cdpr.scenario.loader",
    "load_robot": "cdpr.scenario.loader",
    "load_scenario": "cdpr.scenario.loader",
}

__all__ = [
    "AngularLimits",
    "Circle",
    "Csv",
    "Euler",
    "Gcode",
    "Helix",
    "Hold",
    "Initial",
    "JerkLimited",
    "Knot",
    "Limits",
    "Orientation",
    "PickAndPlace",
    "Pose",
    "Quintic",
    "Scenario",
    "Simulation",
    "Stop",
    "Waypoint",
    "Waypoints",
    "World",
    "load_any",
    "load_robot",
    "load_scenario",
]

if TYPE_CHECKING:
    from cdpr.scenario.initial import Initial
    from cdpr.scenario.loader import load_any, load_robot, load_scenario
    from cdpr.scenario.motions.circle import Circle, Helix
    from cdpr.scenario.motions.csv import Csv
    from cdpr.scenario.motions.gcode import Gcode
    from cdpr.scenario.motions.hold import Hold
    from cdpr.scenario.motions.jerk_limited import AngularLimits, JerkLimited, Limits, Stop
    from cdpr.scenario.motions.motion import Pose
    from cdpr.scenario.motions.pick_and_place import PickAndPlace
    from cdpr.scenario.motions.quintic import Knot, Quintic
    from cdpr.scenario.motions.waypoints import Waypoint, Waypoints
    from cdpr.scenario.orientation import Euler, Orientation
    from cdpr.scenario.scenario import Scenario
    from cdpr.scenario.schema import Simulation, World
else:  # a file uses few kinds of motions
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__, _HOME)
