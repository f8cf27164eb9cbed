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

from cdpr.scenario.initial import Initial
from cdpr.scenario.loader import load_any, load_robot, load_scenario
from cdpr.scenario.motions import (
    AngularLimits,
    Circle,
    Csv,
    Gcode,
    Helix,
    Hold,
    JerkLimited,
    Knot,
    Limits,
    PickAndPlace,
    Pose,
    Quintic,
    Stop,
    Waypoint,
    Waypoints,
)
from cdpr.scenario.orientation import Euler, Orientation
from cdpr.scenario.scenario import Scenario
from cdpr.scenario.schema import Simulation, World

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
