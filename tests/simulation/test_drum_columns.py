"""Columns of drums, by the geometry of the cables; they exist only for winches with the radius of a drum."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.mechanics.kinematics import lengths, make_state

SHORT = {"simulation.duration": 0.05}
ROUNDING = 1e-9  # rad and rad/s, of sums of a few lengths
RADIUS = 0.05  # m


def home_lengths(robot):
    """Lengths (m,) at the home pose of the file."""
    return lengths(robot, make_state(np.array(robot.home[:3])))


@pytest.mark.parametrize("backend", ["reference", pytest.param("fmu", marks=pytest.mark.slow)])
def test_drums_of_cables_that_do_not_stretch(backend):
    file = str(ROOT / "scenarios" / "robots" / "caroca_winches.yaml")
    rigid = {"robot": file, "robot.cable.model": "rigid", "simulation.backend": backend}
    scenario = cdpr.load_scenario("caroca", overrides={**SHORT, **rigid})
    run, radius = cdpr.simulate(scenario), scenario.robot.cables[0].winch.drum_radius
    np.testing.assert_allclose(run.drum_angle, (home_lengths(scenario.robot) - run.length) / radius, atol=ROUNDING)
    np.testing.assert_allclose(run.drum_speed, -run.rate / radius, atol=ROUNDING)
    assert np.ptp(run.drum_angle) > 1e-3
    np.testing.assert_allclose(run["motor_power"], run["motor_torque"] * run.drum_speed, rtol=ROUNDING)


def test_drives_without_a_drum_have_no_columns_of_drums():
    run = cdpr.simulate("camera_robot", overrides={**SHORT, "robot.winch": {"type": "position"}})
    assert not run.header.layout.has("motors")
    assert "winch_command" in run.header.layout.columns


@pytest.mark.parametrize("backend", ["reference", pytest.param("fmu", marks=pytest.mark.slow)])
def test_only_cables_with_a_drum_have_numbers_in_these_columns(backend):
    one = {"robot.winch": {"type": "position"}, "robot.cables[1].winch": {"type": "position", "drum_radius": RADIUS}}
    scenario = cdpr.load_scenario("camera_robot", overrides={**SHORT, **one, "simulation.backend": backend})
    run, home = cdpr.simulate(scenario), home_lengths(scenario.robot)[1]
    np.testing.assert_allclose(run.drum_angle[:, 1], (home - run["unstretched_length"][:, 1]) / RADIUS, atol=ROUNDING)
    np.testing.assert_allclose(run.drum_speed[:, 1], -run["unstretched_rate"][:, 1] / RADIUS, atol=ROUNDING)
    assert np.abs(run.drum_speed[1:, 1]).max() > 1e-3
    for name in ("drum_angle", "drum_speed"):
        assert np.isnan(run[name][:, [0, 2, 3]]).all()
    assert np.isnan(run["motor_torque"]).all()
