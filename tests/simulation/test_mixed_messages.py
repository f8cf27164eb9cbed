"""Messages about robots with different cables, impossible nominal models, and pulleys in the way."""

from __future__ import annotations

import json

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT

import cdpr
from cdpr.base.errors import Diverged, ScenarioError
from cdpr.simulation.faults import NOT_FINITE, fault_message

PLANAR = str(ROOT / "scenarios" / "planar.yaml")
WINCHES = str(ROOT / "scenarios" / "winch_fmu.yaml")
LEGS = {"believed.unilateral": False, "believed.tension.min": -100}
DRUM = {"drum_radius": 0.05, "inertia": 0.002}
# The first cable's pulley is in the way of the move `INTO`.
IN_THE_WAY = {"robot.cables[0].exit": {"type": "pulley", "radius": 0.4, "axis": [1, 0, 0]}}
INTO = {"initial.position": [0, 0, 1.5], "trajectory.duration": 1.0, "trajectory.to.position": [-1.6, 0, 2.95]}


def test_to_believe_ideal_cables_to_be_legs_would_let_them_push():
    with pytest.raises(ScenarioError, match=r"believed.unilateral: must be the robot's, true: .* they cannot push"):
        cdpr.load_scenario(PLANAR, overrides=LEGS)


@pytest.mark.parametrize("more", [{"robot.unilateral": False}, {"robot.cable.model": "rigid", "robot.winch": DRUM}])
def test_legs_and_drums_take_commands_to_push_as_they_can(more):
    """Legs push, and a drum leaves a cable slack."""
    run = cdpr.simulate(PLANAR, overrides={**LEGS, **more, "simulation.duration": 0.02})
    assert run.tension.min() < 0.0
    if "robot.winch" in more:
        assert run["cable_tension"].min() >= 0.0


def test_a_place_of_the_base_that_is_believed_is_no_shape():
    scenario = cdpr.load_scenario(PLANAR, overrides={"believed.frame.position": [0, 0, 0.1]})
    assert scenario.unused == ()


@pytest.mark.parametrize("common", ["ideal", "elastic"])
def test_an_event_names_the_cable_that_is_not_ideal(common):
    cut = [{"type": "cable_break", "time": 0.01, "cable": 1}]
    own = {f"robot.cables[{i}].model": "rigid" if i == 2 else "ideal" for i in range(8)}
    about = {"actuators": None, **own, "robot.cable.model": common, "events": cut}
    with pytest.raises(ScenarioError, match=r"and robot.cables\[2\].model is rigid: remove it or set that to ideal"):
        cdpr.load_scenario(ROOT / "scenarios" / "winch.yaml", overrides={k: v for k, v in about.items() if v})


def test_actuators_declare_replaced_models_and_inputs():
    assert cdpr.load_scenario(WINCHES).unused == ()
    rigid = cdpr.load_scenario(WINCHES, overrides={"robot.cable.model": "rigid"})
    assert rigid.unused == ("robot.cable.model",)  # the stiffness is used
    mixed = cdpr.load_scenario(WINCHES, overrides={"robot.cables[0].model": "ideal"})
    assert mixed.unused == ("robot.cables[*].model",)


def test_a_run_into_a_pulley_is_reported():
    with pytest.raises(Diverged, match=r"a cable has no length: of 'cable_1' its anchor .* lies within its pulley"):
        cdpr.simulate(PLANAR, backend="mujoco", overrides={**IN_THE_WAY, **INTO})


@pytest.mark.parametrize("period", [0.001, 0.05])
def test_the_same_if_an_intermediate_stage_violates_first(period):
    into = (
        r"^t = 0.7\d+ s: the state is not finite; a cable has no length along the motion of the platform: of 'cable_1' "
    )
    with pytest.raises(
        Diverged, match=into + r"its anchor .* lies within its pulley \(the sample before: position \[-1.3"
    ):
        cdpr.simulate(PLANAR, overrides={**IN_THE_WAY, **INTO, "simulation.control_step": period})


def test_a_state_that_is_not_finite_names_no_cable_that_is_not_in_the_way():
    robot = cdpr.load_robot(ROOT / "scenarios" / "robots" / "cogiro_pulleys.yaml")
    before = np.concatenate([robot.home, [0.1, 0, 0, 0, 0, 0.1]])
    text = fault_message(NOT_FINITE, robot, None, np.full(13, np.nan), before, 0.001)
    assert text.startswith("the state is not finite (the sample before: position [0, 0, ")


def test_a_motion_into_a_pulley_is_reported_before_the_run():
    done = cdpr_here(
        "info", PLANAR, *(f"--set={key}={json.dumps(value)}" for key, value in (IN_THE_WAY | INTO).items()), code=2
    )
    assert "cable 'cable_1' has no length at" in done.stderr
    assert "lies within its pulley" in done.stderr


def test_a_link_to_nothing_is_reported_as_one(tmp_path):
    (tmp_path / "s.yaml").symlink_to("nowhere.yaml")
    with pytest.raises(ScenarioError, match=r"s.yaml' is a link to 'nowhere.yaml', which does not exist"):
        cdpr.load_scenario(tmp_path / "s.yaml")
