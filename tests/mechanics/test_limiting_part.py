"""The part that limits a step is the one whose change makes longer steps stable."""

from __future__ import annotations

import re

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT

from cdpr import simulate
from cdpr.base.errors import Diverged
from cdpr.mechanics.limiting_part import limiting_part
from cdpr.mechanics.stability import longest, oscillator
from cdpr.scenario import load_scenario
from cdpr.simulation.build import faults
from cdpr.simulation.loop_problems import loop_problems

TOO_LONG = 0.05  # s
HANGPRINTER = ROOT / "scenarios" / "hangprinter.yaml"
SERVO = {"type": "position", "drum_radius": 0.05, "inertia": 0.01, "velocity_gain": 0.2, "position_gain": 5.0}
GAINS = SERVO | {"velocity_gain": 40.0}
MOTOR = {"type": "torque", "drum_radius": 0.05, "inertia": 0.01, "viscous_friction": 50.0}


def limits(changes):
    """Return the longest stable step (s) and the part that limits it."""
    scenario = load_scenario(HANGPRINTER, overrides=changes)
    about = oscillator(scenario.robot, scenario.initial.state(), scenario.gravity)
    return longest(about.semi_implicit, TOO_LONG), limiting_part(scenario.robot, about.M, about.parts, TOO_LONG)


@pytest.mark.parametrize(
    ("changes", "remedy", "text"),
    [
        (
            {"robot.cables[1].axial_stiffness": 1e7},
            {"robot.cables[1].axial_stiffness": 5e4},
            "cable 'B' limits it by its stiffness, against the platform",
        ),
        (
            {"robot.cables[3].damping": 5000.0},
            {"robot.cables[3].damping": 20.0},
            "cable 'D' limits it by its damping, against the platform",
        ),
        (
            {"robot.winch": SERVO, "robot.cables[2].winch": GAINS},
            {"robot.winch": SERVO},
            "cable 'C' limits it by the control of its winch, against the inertia of its winch",
        ),
        (
            {"robot.winch": SERVO, "robot.cables[0].winch": MOTOR},
            {"robot.winch": SERVO},
            "cable 'A' limits it by the friction of its winch, against the inertia of its winch",
        ),
    ],
    ids=["stiffness", "damping", "servo", "friction"],
)
def test_the_part_is_the_one_that_was_changed(changes, remedy, text):
    short, part = limits(changes)
    long, _ = limits(remedy)
    assert part == text
    assert long > 2.0 * short


def test_parts_sum_up_to_the_oscillator():
    scenario = load_scenario(ROOT / "scenarios" / "winch.yaml")
    about = oscillator(scenario.robot, scenario.initial.state(), scenario.gravity)
    for whole, name in ((about.K, "stiffness"), (about.C, "damping")):
        total = sum(getattr(each, name) * np.outer(each.direction, each.direction) for each in about.parts)
        np.testing.assert_allclose(total, whole, rtol=1e-12, atol=1e-12 * np.abs(whole).max())  # round-off


def test_equal_cables_are_counted():
    """Cables between a point mass and the corners of a square above it."""
    scenario = load_scenario(ROOT / "scenarios" / "camera_robot.yaml")
    about = oscillator(scenario.robot, scenario.initial.state(), scenario.gravity)
    part = limiting_part(scenario.robot, about.M, about.parts, TOO_LONG)
    assert re.match(r"cable 'cable_\d' \(and \d more alike\) limits it by the control of its winch, against", part)


def test_friction_of_pulleys_is_not_that_of_winches():
    """Cables are ideal, so that nothing swings."""
    scenario = load_scenario("cogiro_pulleys", overrides={"robot.cable.exit.friction": 10.0})
    (fault,) = faults(scenario)
    text = str(fault.error)
    assert "at the initial pose damping and friction require short steps; it is stable up to" in text
    assert text.endswith("limits it by the friction of its pulley, against the platform")


UP = {
    "simulation.physics_step": 0.02,
    "simulation.control_step": 0.02,
    "robot.cable.damping": 2.0,
    "trajectory.points[1].position": [0, 0, 2.28],  # 65 mm below the exit of D
}


def test_short_cables_along_the_motion_are_warned_of():
    """The step is stable at the start and at the end, and the run diverges in between."""
    scenario = load_scenario(HANGPRINTER, overrides=UP)
    assert list(faults(scenario)) == []
    _, found = loop_problems(scenario)
    (text,) = (text for path, text in found if path == ("simulation", "physics_step"))
    assert "may diverge: at 1.969 s of the motion" in text
    assert text.endswith("; cable 'D' limits it by its stiffness, against the platform")
    with pytest.raises(Diverged, match=r"t = 2\.\d+ s"):
        simulate(scenario)
    _, found = loop_problems(scenario.with_changes({"trajectory.points[1].position": [0, 0, 0.5]}))
    assert "diverge" not in str(found)


def test_validate_names_the_part():
    done = cdpr_here("validate", HANGPRINTER, "--set", "robot.cables[1].axial_stiffness=1e9", code=2)
    assert done.stderr.strip().endswith("; cable 'B' limits it by its stiffness, against the platform")
