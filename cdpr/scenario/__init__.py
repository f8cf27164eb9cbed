"""Scenario and robot files: from strict YAML to checked, typed data.

A file is read in phases, and the problems of all of them are reported at once, each as
`file:line:col: key: what is wrong, what is allowed`:

1. `yaml_nodes`: text to plain data with positions, refusing what no scenario needs (tags, merge keys, bombs);
2. `source`: values set from outside are written into that data; a robot file is put where it is named, its home where
   nothing says where the run begins (`beginning`);
3. `schema`, `robot_schema`, `motions`, `events`: types, units and ranges; `options`: the plugins' own models;
4. `robot_checks`, `run_checks`, `motion_checks`, `event_checks`: what only several sections together can show.

What is allowed and seldom meant is found by `plausible` when it is asked for; `template` writes new files.
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
