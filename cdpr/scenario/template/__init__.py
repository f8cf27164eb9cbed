"""New robot and scenario files: plain data from a few sizes, written with what the schema says of each key."""

from cdpr.scenario.template.commented import commented
from cdpr.scenario.template.new_robot import Sizes, robot_data
from cdpr.scenario.template.new_scenario import scenario_data
from cdpr.scenario.template.texts import RESTS, robot_text, scenario_text

__all__ = ["RESTS", "Sizes", "commented", "robot_data", "robot_text", "scenario_data", "scenario_text"]
