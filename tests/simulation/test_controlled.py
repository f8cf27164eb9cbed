"""`controlled`: the cables balance the wrench in some of the robot's directions, the platform moves in all."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT
from plants import installed

import cdpr
from cdpr.base.errors import ScenarioError
from cdpr.mechanics.kinematics import wrench_matrix
from cdpr.scenario import load_scenario
from cdpr.tension import Status
from cdpr.tension.checks import RESIDUAL_TOLERANCE
from cdpr.ui.cli import info, run, tension

CAROCA, PLANAR = ROOT / "scenarios" / "caroca.yaml", ROOT / "scenarios" / "planar.yaml"
FORCES = {"controlled": ["x", "y", "z"], "simulation.duration": 0.5}
# Legs as in the thesis's simulator; the middle of their limits stays what it was, (1 + 6500) / 2 N.
LEGS = {"robot.unilateral": False, "robot.tension.min": -6500, "robot.tension.max": 13001}


def invoke(command, *arguments):
    result = CliRunner().invoke(command, [str(a) for a in arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


def test_all_directions_by_default():
    scenario = load_scenario(PLANAR)
    assert scenario.controlled_robot.dof == scenario.robot.dof == ("x", "z", "ry")
    assert "controlled: [x, z, ry]" in scenario.resolved_yaml()
    assert cdpr.simulate(PLANAR, overrides={"simulation.duration": 0.01}).header.controlled == ()


@pytest.mark.parametrize(
    ("file", "controlled", "what"),
    [
        (PLANAR, ["x", "y", "z"], "controlled: the robot does not move along y; allowed: x, z, ry"),
        (CAROCA, ["z", "x"], "controlled: expected each of x, y, z, rx, ry, rz at most once and in this order"),
        (CAROCA, [], "at least one"),
        (CAROCA, ["x", "x"], "at most once"),
        (CAROCA, ["w"], "controlled[0]: "),
        (CAROCA, "x", "controlled: "),
    ],
)
def test_wrong_directions_are_one_clear_error(file, controlled, what):
    with pytest.raises(ScenarioError) as caught:
        load_scenario(file, overrides={"controlled": controlled})
    assert what in str(caught.value)
    assert len(caught.value.problems) == 1


def test_the_wrench_is_balanced_in_the_controlled_directions_alone():
    found = cdpr.simulate(CAROCA, solver="pseudo_inverse", overrides={**FORCES, **LEGS})
    robot = load_scenario(CAROCA).robot
    for k in (0, 250, 500):
        W = wrench_matrix(robot, np.concatenate([found.position[k], found.orientation[k], np.zeros(6)]))
        np.testing.assert_allclose(found.tension[k], np.linalg.pinv(W[:3]) @ found.wrench[k, :3], rtol=1e-9, atol=1e-9)
        assert np.linalg.norm(W[3:] @ found.tension[k] - found.wrench[k, 3:]) > 1.0  # N m: not requested
    assert found.residual.max() <= RESIDUAL_TOLERANCE * np.linalg.norm(found.wrench[:, :3], axis=1).max()
    assert not found.solver_status.any()


def test_the_platform_keeps_its_freedom():
    """Position is held although nothing holds the attitude."""
    found = cdpr.simulate(CAROCA, overrides=FORCES)
    assert np.linalg.norm(found.position_error, axis=1).max() < 1e-3
    assert np.linalg.norm(found.orientation_error[-1]) > 0.1
    held = cdpr.simulate(CAROCA, overrides={"simulation.duration": 0.5})
    assert np.linalg.norm(held.orientation_error[-1]) < 1e-3


def test_five_cables_too_many_are_beyond_some_solvers():
    found = cdpr.simulate(CAROCA, solver="centroid", overrides={**FORCES, "simulation.duration": 0.01})
    assert set(found.solver_status) == {Status.UNSUPPORTED}


def test_log_and_report_contain_it(tmp_path):
    changes = ["--set", "controlled=[x, y, z]", "--set", "simulation.duration=0.05"]
    invoke(run.command, CAROCA, *changes, "--out", tmp_path / "run")
    assert cdpr.load_run(tmp_path / "run").header.controlled == ("x", "y", "z")
    assert '<th scope="row">Controlled directions</th><td>x, y, z</td>' in (tmp_path / "run/report.html").read_text()
    again = load_scenario(tmp_path / "run" / "scenario.yaml")
    assert again.controlled_robot.dof == ("x", "y", "z")


def test_previews_require_the_same_tensions():
    given = (ROOT / "scenarios" / "thesis.yaml", "--set", "controlled=[x, y, z]", "--json")
    looks = json.loads(invoke(info.command, *given))
    assert looks["robot"]["n"] == 6
    assert looks["motion"]["controlled"] == ["x", "y", "z"]
    assert looks["motion"]["feasible_share"] == 1.0  # of 50 kg; with six directions the start is not feasible
    assert looks["pose"]["static_tension_N"] is None
    assert json.loads(invoke(tension.command, *given, "--pose", "0,0,2"))["redundancy"] == 5


@pytest.mark.parametrize("backend", ["reference", *installed("mujoco", "bullet", "dart")])
def test_legs_that_push_push(backend):
    """With negative tensions of the pseudo-inverse, cables lose the platform and legs hold it."""
    far = {"simulation.duration": 0.5, "robot.tension.min": 0, "trajectory": {"type": "hold"}}
    options = {"solver": "pseudo_inverse", "backend": backend}
    far["initial.position"] = [0, -2, 2]
    cables = cdpr.simulate(CAROCA, overrides=far, **options)
    legs = cdpr.simulate(CAROCA, overrides={**far, **LEGS}, **options)
    assert cables.tension.min() == 0.0
    assert legs.tension.min() < -20.0
    assert not legs.solver_status.any()
    assert np.linalg.norm(legs.position_error, axis=1).max() < 1e-4 < np.linalg.norm(cables.position_error[-1])
