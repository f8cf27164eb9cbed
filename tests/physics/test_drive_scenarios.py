"""Example scenarios of robots whose drives hold lengths: figures that their comments state."""

from __future__ import annotations

import numpy as np
import pytest

import cdpr


def test_the_camera_robot_hangs_low():
    """Statics of four unloaded lines, 2 kN stiff: 143 mm (cdpr.equilibrium is tested apart)."""
    low = cdpr.simulate("camera_robot").position_error[-1]
    high = cdpr.simulate("camera_robot", overrides={"controller.flex_compensation": True}).position_error[-1]
    assert np.linalg.norm(low) == pytest.approx(0.143, abs=1e-3)
    assert np.linalg.norm(high) < 1e-4


def test_the_carriage_of_the_plotter_tilts():
    run = cdpr.simulate("plotter")
    error = np.linalg.norm(run.position_error, axis=1)
    assert error[-1] < 1e-4  # in the middle it hangs upright
    assert 0.008 < error.max() < 0.013
    corner = np.argmin(np.abs(run.time - 7.3))  # at rest at (0.2, 0.8)
    lengths = cdpr.mechanics.kinematics.lengths(
        cdpr.load_robot("v_plotter"), np.array([0.2, 0, 0.8, 1, 0, 0, 0, *[0] * 6])
    )
    rest = cdpr.equilibrium("v_plotter", lengths=lengths / (1 + 5 / 3e4), start=[0.2, 0, 0.8, 1, 0, 0, 0])
    np.testing.assert_allclose(run.position[corner], rest.pose[:3], atol=5e-4)  # it swings by this


@pytest.mark.slow
def test_the_hall_robot_lags_and_arrives():
    run = cdpr.simulate("hall")
    error = np.linalg.norm(run.position_error, axis=1)
    speed = np.linalg.norm(run.velocity, axis=1)
    half = np.argmin(np.abs(run.time - 8.0))
    assert error[half] == pytest.approx(speed[half] / 15, rel=0.05)
    assert error[-1] < 2e-3
    bare = cdpr.simulate("hall", overrides={"controller.flex_compensation": False})
    assert np.linalg.norm(bare.position_error[-1]) == pytest.approx(6e-3, abs=5e-4)


def test_the_fibre_camera_sinks_by_the_creep_of_its_ropes():
    """Statics at the end, with the compliance of the creep after 120 s, for the lengths of new ropes."""
    run = cdpr.simulate("creep")
    new = cdpr.load_scenario("creep").robot
    wanted = cdpr.compensated_lengths(new, new.home)
    crept = (0.2 + 0.1 * (1.0 - np.exp(-120.0 / 40.0))) / 0.3
    old = cdpr.load_scenario("creep", overrides={"robot.cable.creep_progress": crept}).robot
    found = cdpr.equilibrium(old, lengths=wanted.lengths)
    np.testing.assert_allclose(run.position[-1], found.pose[:3], atol=2e-5)
    assert run.position_error[-1, 2] == pytest.approx(3.73e-3, abs=5e-5)
