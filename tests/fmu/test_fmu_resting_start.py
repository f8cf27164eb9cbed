"""Exported plants start at the pose of rest with `initial.equilibrium`, and stay there."""

from __future__ import annotations

import numpy as np
import pytest
from command_line import cdpr_here
from fmu.driver import Driver

import cdpr

STEP, STEPS = 0.01, 50
STILL = 1e-11  # m: round-off of cables of some metres
STEPPER = "robot.winch={type: stepper, steps_per_turn: 200, drum_radius: 0.01, stall_torque: 2.0}"


@pytest.mark.parametrize(
    ("name", "changes"),
    [("camera_robot", []), pytest.param("hangprinter", [STEPPER], marks=pytest.mark.slow)],
)
def test_the_plant_rests_with_its_first_commands(name, changes, tmp_path):
    path, given = tmp_path / "rest.fmu", ["initial.equilibrium=true", "trajectory={type: hold}", *changes]
    options = [word for each in given for word in ("--set", each)]
    done = cdpr_here("fmu", "export", f"scenarios/{name}.yaml", *options, "-o", str(path))
    assert done.returncode == 0, done.stderr
    run = cdpr.simulate(name, overrides=[*given, "simulation.duration=0.1"])
    with Driver(path) as driver:
        assert np.abs(driver.state()[:3] - run.position[0]).max() < STILL
        assert np.allclose(driver.get("initial_unstretched_length"), run["unstretched_length"][0], rtol=0.0, atol=STILL)
        begun = driver.state()
        for k in range(STEPS):
            driver.step(k * STEP, STEP)
        assert np.abs(driver.state() - begun).max() < STILL
    given_pose = cdpr.load_scenario(name).initial.position
    assert np.abs(run.position[0] - given_pose).max() > 1e-3
