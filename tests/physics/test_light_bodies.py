"""Bodies of any mass and inertia: engines move them as the reference does, or reject them."""

from __future__ import annotations

import dataclasses
import os

import numpy as np
import pytest
from plants import installed, plant
from spread import spread

import cdpr
from cdpr.base.errors import CdprError, ExitCode

ENGINES = installed("mujoco", "bullet", "dart")
CASES = int(os.environ.get("CDPR_LIGHT_BODIES", "8"))  # random bodies of each robot
SAME = 2e-6  # share of the largest rate after three steps; at a radius of gyration of 1e-5 m engines lose ten digits
STEPS = 3


def moved(robot, start, loads, engine, **options):
    """The rates (6,) after some steps from a start at rest."""
    backend = plant(engine, robot, **options)
    backend.reset(start)
    backend.external[:] = loads
    backend.step(STEPS)
    rates = backend.state[7:] - start[7:]
    backend.close()
    return rates


@spread("engine, name", ENGINES, ["caroca", "planar", "point_mass", "spherical"])
def test_engines_move_a_body_or_reject_it(engine, name):
    scenario = cdpr.load_scenario(name)
    start, platform = scenario.initial.state(), scenario.robot.platform
    rng = np.random.default_rng(32)
    told: list[CdprError] = []
    for _ in range(CASES):
        mass = 10 ** rng.uniform(-18, 12)
        scale = 10 ** rng.uniform(-20, 12) if rng.random() < 0.5 else mass
        inertia = platform.inertia / np.trace(platform.inertia) * scale
        robot = dataclasses.replace(scenario.robot, platform=dataclasses.replace(platform, mass=mass, inertia=inertia))
        loads = np.concatenate([mass * np.array([1.0, 0.5, 10.1]), scale * np.array([0.3, 0.2, 0.1])])
        judge = moved(robot, start, loads, "reference", scheme="semi_implicit_euler")
        try:
            rates = moved(robot, start, loads, engine)
        except CdprError as error:
            told.append(error)
            continue
        if np.isnan(rates).any():
            continue  # which ends a run as diverged
        for part in (slice(0, 3), slice(3, 6)):
            assert np.abs(rates - judge)[part].max() <= SAME * np.abs(judge[part]).max(), (mass, scale)
    assert all(error.exit_code == ExitCode.BAD_INPUT and "robot.platform." in str(error) for error in told)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("mass", "inertia"), [(1e-16, 1e-16), (1e-30, 1e-30), (1e30, 1e30), (100.0, 1e-20), (100.0, 1e20)]
)
def test_extreme_bodies_never_finish_unmoved(engine, mass, inertia):
    overrides = {
        "robot.platform.mass": mass,
        "robot.platform.inertia": [inertia] * 3 + [0] * 3,
        "simulation.duration": 0.02,
    }
    with pytest.raises(CdprError) as told:
        cdpr.simulate("caroca", backend=engine, overrides=overrides)
    assert told.value.exit_code in (ExitCode.BAD_INPUT, ExitCode.DIVERGED)


@pytest.mark.parametrize("cables", ["native", "ups"])
def test_other_cables_of_mujoco_reject_light_bodies(cables):
    if "mujoco" not in ENGINES:
        pytest.skip("needs mujoco")
    scenario = cdpr.load_scenario("caroca")
    platform = dataclasses.replace(scenario.robot.platform, mass=1e-16)
    with pytest.raises(CdprError, match="MuJoCo does not move a body correctly below 1e-15 kg"):
        plant("mujoco", dataclasses.replace(scenario.robot, platform=platform), cables=cables)
