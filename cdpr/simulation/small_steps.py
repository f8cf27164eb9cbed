"""Limit of small steps of stepper drives that lose no step, in which loops with steppers are linear.

A stepper without inertia is then the ideal drive of a length: it reaches the commanded length at the end of the control
period, as its steps do. A rotor keeps its torque curve, with microsteps below round-off. Limits of the
speed do not matter at rest.
"""

from __future__ import annotations

from typing import Any

from cdpr.cables import COMMANDS, LENGTH, WINCH_TYPES, chain_of
from cdpr.cables.chain import COORDINATE
from cdpr.cables.ideal_drive import IDEAL_DRIVE
from cdpr.cables.stepper import MICROSTEPS, STEPPER, STEPPER_MOTOR
from cdpr.model import Robot
from cdpr.scenario import Scenario
from cdpr.scenario.winch_kinds import driven

SMALLEST = 1e12  # microsteps in a full step: a microstep is then below the round-off of lengths
SMALL = "steppers are linearised as drives with very small steps that lose none"


def small_steps(scenario: Scenario) -> dict[str, Any]:
    """Return the changes of a scenario that make the steps of its steppers small; {} without steppers."""
    robot = scenario.sections.robot
    winches = {"robot.winch": robot.winch}
    winches |= {f"robot.cables[{i}].winch": cable.winch for i, cable in enumerate(robot.cables)}
    changes: dict[str, Any] = {}
    for path, winch in winches.items():
        part = None if winch is None else WINCH_TYPES[winch.type][driven(winch)]
        if part is STEPPER:
            changes[f"{path}.type"] = next(
                name for name, (ideal, _) in WINCH_TYPES.items() if ideal is IDEAL_DRIVE and COMMANDS[name] == LENGTH
            )
        elif part is STEPPER_MOTOR:
            changes[f"{path}.{MICROSTEPS.key}"] = SMALLEST
    return changes


def counted_places(robot: Robot, places: Any) -> list[tuple[int, int]]:
    """Return the index of each cable whose winch is a rotor, and of the length of its steps in the winches' states.

    Args:
        robot: the robot.
        places: (m + 1,), as of `cdpr.cables.tables.places_of_states`.
    """
    rotors = [i for i, cable in enumerate(robot.cables) if chain_of(robot, cable).winch is STEPPER_MOTOR]
    return [(i, int(places[i]) + COORDINATE) for i in rotors]
