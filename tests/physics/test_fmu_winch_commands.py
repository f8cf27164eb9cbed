"""FMUs of robots whose winches take lengths or rates: units, start, and the loop of `reference`."""

from __future__ import annotations

import json
import re

import fmpy
import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from fmpy.validation import validate_fmu
from fmu.cases import FMI
from fmu.driver import Driver

from cdpr import load_scenario, simulate
from cdpr.base.errors import CdprError
from cdpr.cables.tables import command_kinds
from cdpr.fmu.export import Actuator, Controller, Plant, fmu_bytes
from cdpr.fmu.export.control import DESIRED
from cdpr.fmu.read.archive import open_archive
from cdpr.fmu.read.mapping import map_signals
from cdpr.simulation.exported import control_of

SAME = 1e-11  # m, m/s, and 1e3 N of tensions: round-off
HANGING = "robot.cables[{}].winch={{type: torque, drum_radius: 0.05, inertia: 0.002}}"
IDEAL = ["robot.winch={type: position, drum_radius: 0.05}"]
VELOCITY = "robot.winch.type=velocity"
SAGGING = ["robot.cable.model=catenary", "robot.cable.linear_density=0.05", "robot.tension.min=10"]
CASES = {
    "servo": ("camera_robot", []),
    "ideal": ("camera_robot", IDEAL),
    "velocity": ("camera_robot", [VELOCITY, "controller.type=computed_torque"]),
    "rates": ("camera_robot", [VELOCITY]),
    "ideal rates": ("camera_robot", ["robot.winch={type: velocity}", "controller.type=computed_torque"]),
    "mixed": ("camera_robot", [HANGING.format(1), "controller.type=computed_torque"]),
    "sagging": ("camera_robot", [*SAGGING, "controller.type=computed_torque"]),
    "sagging ideal": ("camera_robot", [*SAGGING, *IDEAL, "controller.type=computed_torque"]),
}
DURATION = 0.2  # s
RESTING = 1e-6  # m/s^2; a load of 3 kg without its share of the tensions accelerates the platform by 3 m/s^2


def scenario(case, *more):
    name, changes = CASES[case]
    fast = ["trajectory.duration=0.3", f"simulation.duration={DURATION}"]
    return load_scenario(ROOT / "scenarios" / f"{name}.yaml", overrides=[*changes, *fast, *more])


def plant(loaded, control=None, unwound=None):
    step, state = loaded.simulation.physics_step, loaded.initial.state()
    return Plant(loaded.robot, loaded.gravity, step, state, True, control, unwound=unwound)


def write(model, fmi, folder):
    path = folder / f"model{fmi}.fmu"
    path.write_bytes(fmu_bytes(model, fmi))
    return path


def state_of(run, k):
    return np.concatenate([run[each][k] for each in ("position", "orientation", "velocity", "angular_velocity")])


@pytest.mark.parametrize("case", [*CASES])
def test_the_plant_is_that_of_the_loop(case, tmp_path):
    """The commands that a run records, fed into the FMU, give the motion of that run."""
    loaded = scenario(case)
    run = simulate(loaded, backend="reference")
    takes, step = command_kinds(loaded.robot), loaded.simulation.control_step
    # The first length of a run is its start; rates begin at 0 there, and the length that has unwound is recorded.
    path = write(plant(loaded, unwound=run.unstretched_length[0]), 3, tmp_path)
    with Driver(path) as driver:
        for k in range(len(run.rows) - 1):
            driver.set("command", run.winch_command[k])
            if k > 0:
                pulled = np.where(takes == 0, 0.0, driver.get("cable_tension") - run.cable_tension[k])
                assert np.abs(pulled).max() < 1e3 * SAME
            driver.step(k * step, step)
            assert np.abs(driver.state() - state_of(run, k + 1)).max() < SAME
            assert np.abs(driver.get("unstretched_length") - run.unstretched_length[k + 1]).max() < SAME
            assert abs(driver.get("cable_work") - run.cable_work[k + 1]).max() < SAME
    assert np.abs(run.position[-1] - run.position[0]).max() > 0.1


@pytest.mark.slow  # compiles
@pytest.mark.parametrize("case", ["servo", "ideal", "velocity", "rates", "mixed", "sagging ideal"])
def test_the_controller_inside_is_that_of_the_loop(case, tmp_path):
    loaded = scenario(case)
    run = simulate(loaded, backend="reference")
    names = ["position", "orientation", "velocity", "angular_velocity", "acceleration", "angular_acceleration"]
    with Driver(write(plant(loaded, control_of(loaded)), 3, tmp_path)) as driver:
        for k in range(len(run.rows) - 1):
            for (name, *_), column in zip(DESIRED, names, strict=True):
                driver.set(name, run[f"desired_{column}"][k])
            step = loaded.simulation.control_step
            driver.step(k * step, step)
            assert np.abs(driver.get("command") - run.winch_command[k]).max() < 1e3 * SAME
            assert np.abs(driver.state() - state_of(run, k + 1)).max() < SAME


@pytest.mark.slow  # compiles
@pytest.mark.parametrize("case", ["servo", "ideal", "velocity", "rates", "mixed"])
def test_the_controller_alone_gives_the_commands_of_the_loop(case, tmp_path):
    loaded = scenario(case)
    run = simulate(loaded, backend="reference")
    names = ["position", "orientation", "velocity", "angular_velocity", "acceleration", "angular_acceleration"]
    with Driver(write(Controller(control_of(loaded)), 3, tmp_path)) as driver:
        for k in range(len(run.rows)):
            for (name, *_), column in zip(DESIRED, names, strict=True):
                driver.set(name, run[f"desired_{column}"][k])
                if column in ("position", "orientation", "velocity", "angular_velocity"):
                    driver.set(name.removeprefix("desired_"), run[column][k])
            if "unstretched_length" in driver.references:
                driver.set("unstretched_length", run.unstretched_length[k])
            step = loaded.simulation.control_step
            driver.step(k * step, step)
            assert np.abs(driver.get("command") - run.winch_command[k]).max() < 1e3 * SAME


@FMI
@pytest.mark.parametrize(
    ("case", "units"), [("servo", ["m"] * 4), ("rates", ["m/s"] * 4), ("mixed", ["m", "N", "m", "m"])]
)
@pytest.mark.usual("*-3")
def test_commands_have_the_units_of_the_winches(case, units, fmi, tmp_path):
    loaded = scenario(case)
    path = write(plant(loaded), fmi, tmp_path)
    assert validate_fmu(str(path)) == []
    about = fmpy.read_model_description(str(path))
    inputs = [each for each in about.modelVariables if each.name.startswith("command")]
    assert {each.causality for each in inputs} == {"input"}
    assert [each.unit for each in inputs] == (units if len(inputs) > 1 else units[:1])
    mapping = map_signals(open_archive(path).description, loaded.robot)
    assert list(mapping.inputs.ports["command"].units) == units
    start = next(each for each in about.modelVariables if each.name.startswith("initial_unstretched"))
    assert (start.causality, start.unit) == ("parameter", "m")
    outputs = {each.name.split("[")[0]: each.unit for each in about.modelVariables if each.causality == "output"}
    assert outputs["unstretched_length"] == "m"
    assert outputs["unstretched_rate"] == "m/s"
    assert outputs["motor_torque"] == "N.m"


def test_an_ideal_drive_reaches_its_length_at_the_end_of_the_communication_step(tmp_path):
    loaded = scenario("ideal")
    with Driver(write(plant(loaded), 3, tmp_path)) as driver:
        length = np.array(driver.get("unstretched_length"))
        for k, step in enumerate((0.01, 0.003, 0.02)):
            at = [0.0, 0.01, 0.013][k]
            length += 0.002
            driver.set("command", length)
            driver.step(at, step)
            np.testing.assert_allclose(driver.get("unstretched_length"), length, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("events", [[], [{"type": "payload", "time": 0, "mass": 3.0}]])
def test_exported_lengths_at_the_start_hold_the_platform_and_its_payload(events, tmp_path):
    out = tmp_path / "robot.fmu"
    cdpr_here("fmu", "export", "camera_robot", "--set", f"events={json.dumps(events)}", "--out", out)
    with Driver(out) as driver:
        assert np.abs(driver.get("acceleration")).max() < RESTING
        driver.step(0.0, 0.001)
        assert np.abs(driver.get("acceleration")).max() < RESTING


@pytest.mark.parametrize("winches", ["--with-winch", "--only-winch"])
def test_too_long_steps_are_rejected_as_for_runs(winches, tmp_path):
    given = "fmu", "export", "winch", winches, "--source-only", "--out", tmp_path / "robot.fmu", "--step"
    errors = cdpr_here(*given, "0.01", code=2).stderr
    assert errors.startswith("--step 0.01 s is too long for these cables and winches, and the FMU would diverge")
    limit = re.search(r"; it is stable up to (0\.0\d+) s; cable '", errors)[1]
    cdpr_here(*given, limit)


def test_winches_alone_take_tensions():
    with pytest.raises(CdprError, match=r"winches that take lengths or rates.*without --only-winch"):
        fmu_bytes(Actuator(scenario("servo").robot, 1e-3), 3)
