"""FMUs of robots with steppers: steps and lost steps are those of the loop, to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from fmu.driver import Driver

from cdpr import load_scenario, simulate
from cdpr.fmu.export import Plant, fmu_bytes
from cdpr.fmu.export.control import DESIRED
from cdpr.simulation.exported import control_of

SAME = 1e-11  # m and m/s: round-off of the frame in which an FMU integrates
STEPPER = {"type": "stepper", "drum_radius": 0.05, "steps_per_turn": 200, "microsteps": 16, "stall_torque": 1.5}
ROTOR = {"inertia": 2e-4, "viscous_friction": 0.05}
GEARED = {"gear_ratio": 3.0, "drum_growth": 1e-4, "lines": 2.0, "reeving": 2.0, "efficiency": 0.9, "coulomb_speed": 1.0}
CASES = {
    "stepper": STEPPER,
    "rotor": STEPPER | ROTOR,
    "geared": STEPPER | GEARED | {"speed_max": 30.0, "stall_torque": 1.0},
    "geared rotor": STEPPER | ROTOR | GEARED | {"stall_torque": 1.0},
}
DURATION = 0.3  # s


def scenario(case, **changes):
    fast = {"trajectory.duration": 0.3, "simulation.duration": DURATION, "simulation.physics_step": 0.00025}
    return load_scenario(
        ROOT / "scenarios" / "camera_robot.yaml", overrides={"robot.winch": CASES[case], **fast, **changes}
    )


def write(loaded, folder, control=None, start=None):
    step, state = loaded.simulation.physics_step, loaded.initial.state()
    model = Plant(loaded.robot, loaded.gravity, step, state, True, control, unwound=start)
    path = folder / "model.fmu"
    path.write_bytes(fmu_bytes(model, 3))
    return path


def state_of(run, k):
    return np.concatenate([run[each][k] for each in ("position", "orientation", "velocity", "angular_velocity")])


def same_steps(driver, run, k):
    """Assert that the FMU counts what the loop counts, to the bit."""
    for name in ("counted_length", "lost_steps"):
        assert np.asarray(driver.get(name)).tobytes() == run[name][k].tobytes(), (name, k)


@pytest.mark.parametrize("case", [*CASES])
def test_the_plant_loses_the_steps_of_the_loop(case, tmp_path):
    """The lengths that a run commands, fed into the FMU, give the steps and the motion of that run."""
    loaded = scenario(case)
    run = simulate(loaded, backend="reference")
    assert np.abs(run.lost_steps[-1]).max() > 8.0
    step = loaded.simulation.control_step
    with Driver(write(loaded, tmp_path, start=run.winch_command[0])) as driver:
        for k in range(len(run.rows) - 1):
            driver.set("command", run.winch_command[k])
            driver.step(k * step, step)
            same_steps(driver, run, k + 1)
            assert np.abs(driver.state() - state_of(run, k + 1)).max() < SAME
            assert np.abs(driver.get("unstretched_length") - run.unstretched_length[k + 1]).max() < SAME


@pytest.mark.slow  # compiles
@pytest.mark.parametrize("case", [*CASES])
@pytest.mark.parametrize(
    ("control", "parts"), [("inverse_kinematics", 1), ("computed_torque", 1), ("computed_torque", 2)]
)
def test_the_controller_inside_loses_the_steps_of_the_loop(case, control, parts, tmp_path):
    """With communication steps of a control step, and of a half of it: the drives count once in a control step."""
    loaded = scenario(case, **{"controller.type": control, "simulation.duration": 0.15})
    run = simulate(loaded, backend="reference")
    names = ["position", "orientation", "velocity", "angular_velocity", "acceleration", "angular_acceleration"]
    step, path = loaded.simulation.control_step, write(loaded, tmp_path, control_of(loaded))
    with Driver(path) as driver:
        for k in range(len(run.rows) - 1):
            for (name, *_), column in zip(DESIRED, names, strict=True):
                driver.set(name, run[f"desired_{column}"][k])
            for part in range(parts):
                driver.step((k + part / parts) * step, step / parts)
            assert np.abs(driver.get("command") - run.winch_command[k]).max() < SAME
            same_steps(driver, run, k + 1)
            assert np.abs(driver.state() - state_of(run, k + 1)).max() < SAME
