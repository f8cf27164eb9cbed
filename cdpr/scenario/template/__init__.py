"""New robot and scenario files from a few sizes, with a comment on every key."""

from cdpr.scenario.template.commented import commented
from cdpr.scenario.template.new_robot import Sizes, crowded, robot_data
from cdpr.scenario.template.new_scenario import controller_data, scenario_data
from cdpr.scenario.template.texts import RESTS, robot_text, scenario_text

__all__ = [
    "RESTS",
    "Sizes",
    "commented",
    "controller_data",
    "crowded",
    "robot_data",
    "robot_text",
    "scenario_data",
    "scenario_text",
]
