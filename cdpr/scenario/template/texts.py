"""New files as text, validated before they are returned."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from cdpr.base.files import seen_from
from cdpr.plugins.registry import registry
from cdpr.scenario import examples
from cdpr.scenario.loader import load_robot, load_scenario
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.schema import ScenarioSection
from cdpr.scenario.template.commented import commented
from cdpr.scenario.template.new_robot import Sizes, robot_data
from cdpr.scenario.template.new_scenario import scenario_data

MOVES = "A slow move from home, then rest."
RESTS = "No motion generated: no nearby pose found at which the cables control all degrees of freedom."
WRITTEN = "Written by cdpr new scenario; lengths in m, times in s, angles in rad."


def robot_text(file: str, sizes: Sizes, name: str) -> str:
    """Return a new robot file of this name; `file` is its future path.

    Raises:
        CdprError: if the robot cannot balance its weight.
    """
    frame, platform = ("x".join(f"{part:g}" for part in size) for size in (sizes.frame, sizes.platform))
    head = (
        f"A platform of {platform} m and {sizes.mass:g} kg in a frame of {frame} m. "
        "Written by cdpr new robot; lengths in m, masses in kg, forces in N, angles in rad."
    )
    text = commented(RobotSection, robot_data(sizes, name), registry(), head)
    load_robot(file, text=text)  # an error here would be internal, so it must not be written
    return text


def scenario_text(
    file: str, source: str | None, sizes: Sizes, changes: Mapping[str, float] = MappingProxyType({})
) -> str:
    """Return a new scenario for the robot in `source` (a file or an example), or for a new inline robot.

    `changes` are values by dotted key (section and key).
    """
    section: str | dict[str, Any]
    if source is None:
        section = robot_data(sizes, "robot")
        robot = load_robot("robot", text=json.dumps(section))
    else:
        robot = load_robot(source)
        section = seen_from(os.path.dirname(file), examples.resolve(source, "robot"))
    data = scenario_data(robot, section, registry())
    for key, value in changes.items():
        section_name, _, name = key.partition(".")
        data[section_name][name] = value
    head = f"{MOVES if 'trajectory' in data else RESTS} {WRITTEN}"
    text = commented(ScenarioSection, data, registry(), head)
    load_scenario(file, text=text)  # as above
    return text
