"""The robots and scenarios of the repository, and robots of every number of cables and degrees of freedom."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from plants import installed

from cdpr import load_scenario, simulate
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import lengths, make_state, wrench_matrix
from cdpr.model import rotations
from cdpr.scenario import load_robot

pytestmark = pytest.mark.core

ROBOTS = sorted((ROOT / "scenarios" / "robots").glob("*.yaml"))
NAMES = ("cogiro", "ipanema_1", "planar", "point_mass", "planar_point_mass", "carriage", "spherical")


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
@pytest.mark.parametrize("name", NAMES)
def test_each_follows_its_trajectory_within_its_limits(name, backend):
    summary = simulate(ROOT / "scenarios" / f"{name}.yaml", backend=backend, overrides={"events": []}).summary()
    assert summary["status"] == "finished"
    assert summary["infeasible_steps"] == 0
    assert summary["position_error_m"]["max"] < 1e-3
    assert summary["orientation_error_rad"]["max"] < 1e-3


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_each_robot_has_a_comment_and_a_home(path):
    assert path.read_text().startswith("# ")
    assert "umbers: " in path.read_text() or "our own" in path.read_text()
    assert load_robot(path).home is not None


def test_patterns():
    patterns = {path.stem: (load_robot(path).pattern, load_robot(path).m) for path in ROBOTS}
    assert patterns["cogiro"] == patterns["ipanema_1"] == ("3R3T", 8)
    assert patterns["planar"] == ("1R2T", 4)
    assert patterns["point_mass"] == ("3T", 3)
    assert patterns["planar_point_mass"] == ("2T", 3)
    assert patterns["carriage"] == ("1T", 2)
    assert patterns["spherical"] == ("3R", 4)


def test_cogiro_counts_anchors_from_the_origin_and_gravity_from_the_centre_of_mass():
    robot = load_robot(ROOT / "scenarios" / "robots" / "cogiro.yaml")
    state = make_state([1.0, -0.5, 2.0], rotations.from_rpy(0.1, -0.2, 0.3))
    R = rotations.matrix(state[3:7])
    first = np.array([-7.1775, -5.4361, 5.3911]) - state[:3] - R @ [0.5032, -0.4928, 0.0]
    assert lengths(robot, state)[0] == pytest.approx(np.linalg.norm(first), rel=1e-14)
    weight = 91.058 * 9.81
    moment = np.cross(R @ [-0.034, -0.013, 0.264], [0.0, 0.0, weight])
    np.testing.assert_allclose(
        required_wrench(robot, state, [0.0, 0.0, -9.81]), [0.0, 0.0, weight, *moment], rtol=1e-13, atol=1e-12
    )
    assert np.linalg.matrix_rank(wrench_matrix(robot, state)) == 6
    assert robot.platform.inertia[0, 2] == 3.012  # a tensor entry, not a product of inertia with a minus sign


# Cables of a platform of 2 kg that moves along x and z: too few, as many, one more and two more than directions.
PLANE = {1: "[0, 0, 2]", 2: "[-1, 0, 2]", 3: "[1, 0, 2]", 4: "[-1, 0, -1]", 5: "[1, 0, -1]"}
COUNTS = {"m < n": (1,), "m = n": (2, 3), "m = n + 1": (1, 4, 5), "m > n + 1": (2, 3, 4, 5)}


def plane(cables):
    rows = "\n".join(f"  - {{frame: {PLANE[i]}, platform: [0, 0, 0]}}" for i in cables)
    return f"""
robot:
  dof: [x, z]
  platform: {{mass: 2}}
  tension: {{min: 1, max: 200}}
  cables:
{rows}
simulation: {{duration: 0.5}}
initial: {{position: [0, 0, 0.5]}}
trajectory: {{type: quintic, duration: 0.4, to: {{position: [0.05, 0, 0.6]}}}}
"""


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
@pytest.mark.parametrize("case", COUNTS)
def test_every_number_of_cables_runs(case, backend):
    run = simulate(load_scenario("plane.yaml", text=plane(COUNTS[case])), backend=backend)
    assert run.status == "finished"
    if case == "m < n":  # one cable cannot pull sideways: the run continues with best effort, and reports it
        assert run.summary()["infeasible_steps"] > 100
        assert any("no tensions within the limits" in event.text for event in run.events)
        assert np.abs(run.position[:, 0]).max() < 0.01
    else:
        assert run.summary()["infeasible_steps"] == 0
        assert np.abs(run.position_error).max() < 5e-4


HANGING = """
robot:
  platform: {mass: 20, inertia: [1, 1, 1, 0, 0, 0]}
  tension: {min: 1, max: 500}
  cables:
  - {frame: [-2, -2, 3], platform: [-0.3, -0.3, 0.1]}
  - {frame: [2, -2, 3], platform: [0.3, -0.3, 0.1]}
  - {frame: [2, 2, 3], platform: [0.3, 0.3, 0.1]}
  - {frame: [-2, 2, 3], platform: [-0.3, 0.3, 0.1]}
simulation: {duration: 2}
initial: {position: [0, 0, 1]}
trajectory: {type: quintic, duration: 1.5, to: {position: [0.3, 0.2, 1.2]}}
"""


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
def test_a_free_platform_on_four_cables_swings_and_is_still_led(backend):
    run = simulate(load_scenario("hanging.yaml", text=HANGING), backend=backend)
    assert run.status == "finished"
    assert run.summary()["infeasible_steps"] > 1000
    assert np.abs(run.position_error).max() < 0.02
    assert np.abs(run.orientation_error).max() < 0.3
