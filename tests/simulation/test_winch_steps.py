"""External commands of winches: `step(length=)`, `step(rate=)` and `step(command=)`."""

from __future__ import annotations

import re

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.plugins import Controller

CAMERA = ROOT / "scenarios" / "camera_robot.yaml"
SHORT = {"simulation.duration": 0.1}
TORQUE = {"robot.cables[1].winch": {"type": "torque", "drum_radius": 0.05, "inertia": 0.002}}
VELOCITY = {"robot.winch.type": "velocity"}
IDEAL = {"robot.winch": {"type": "position"}}
CASES = {
    "length": ({}, "length"),
    "ideal length": (IDEAL, "length"),
    "rate": (VELOCITY, "rate"),
    "ideal rate": ({"robot.winch": {"type": "velocity"}}, "rate"),
    "command": (TORQUE, "command"),
}


def commands(kind, k):
    """Commands (4,) of sample k."""
    lengths = 3.2 + 0.001 * np.sin(0.3 * k + np.arange(4.0))
    if kind == "rate":
        return 0.01 * np.cos(0.3 * k + np.arange(4.0))
    if kind == "command":
        lengths[1] = 80.0 + k % 7
    return lengths


def played(output, step):
    """Return a controller that outputs these commands."""

    class Played(Controller):
        def control(self, time, state, desired, out):
            out[:] = commands(self.output, round(time / step))

    Played.output = output
    return Played


def stepped(kind, changes, controller=None):
    with cdpr.Simulation(CAMERA, overrides={**SHORT, **changes}, controller=controller) as sim:
        k = 0
        while not sim.done:
            sim.step(**{kind: commands(kind, k)})
            k += 1
        return sim.run()


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("controller", ["inverse_kinematics", "computed_torque"])
def test_steps_equal_those_of_a_controller_with_this_output(case, controller):
    changes, kind = CASES[case]
    found = stepped(kind, changes, controller)
    step = 0.002  # s, the control step of the scenario
    wanted = cdpr.simulate(CAMERA, overrides={**SHORT, **changes}, controller=played(kind, step))
    last = len(found.rows) - 1  # the last step also completes the last sample
    np.testing.assert_array_equal(found.position, wanted.position)
    np.testing.assert_array_equal(found.cable_tension[:last], wanted.cable_tension[:last])
    np.testing.assert_array_equal(found.winch_command[:last], wanted.winch_command[:last])


@pytest.mark.parametrize("value", [0.0, -1.0, 2e9, 1e300])
@pytest.mark.parametrize("kind", ["length", "command"])
def test_lengths_out_of_range_are_an_error(tmp_path, kind, value):
    wrong = commands("length", 0)
    wrong[2] = value
    with cdpr.Simulation(CAMERA, overrides={**SHORT, **TORQUE} if kind == "command" else SHORT) as sim:
        name = sim.scenario.robot.cables[2].name
        said = rf"^{kind}: cable '{name}': expected more than 0 and at most 1e\+09 m, got {re.escape(f'{value:g}')}$"
        for given in (wrong, wrong.tolist()):
            with pytest.raises(cdpr.CdprError, match=said):
                sim.step(**{kind: given})
        assert sim.samples == 0
        sim.step(**{kind: commands("length", 0)})
        sim.save(tmp_path / "saved.yaml")
    assert len((tmp_path / "saved_outside.csv").read_text().splitlines()) == 2


def test_a_session_of_commands_is_saved_and_repeated(tmp_path):
    saved = tmp_path / "saved.yaml"
    with cdpr.Simulation(CAMERA, overrides=SHORT) as sim:
        sim.step(2, length=commands("length", 0))
        sim.step(3)
        sim.step(3, tension=np.full(4, 45.0))
        here = sim.snapshot()
        sim.step(command=commands("length", 3))
        sim.restore(here)
        sim.step(2, length=commands("length", 4))
        sim.step(2, wrench=[0.0, 0.0, 90.0, 0.0, 0.0, 0.0])
        sim.step(2, command=commands("length", 5))
        sim.save(saved)
        run = sim.run()
    again = cdpr.simulate(saved)
    assert run.rows.tobytes() == again.rows[: len(run.rows)].tobytes()
    lines = saved.with_name("saved_outside.csv").read_text().splitlines()
    assert lines[0].startswith("t,until,quantity,fx")
    assert [line.split(",")[2] for line in lines[1:]] == ["length", "", "length", "", "command"]


@pytest.mark.parametrize(
    ("changes", "given", "text"),
    [
        ({}, {"rate": np.zeros(4)}, r"rate: the winches of this robot take a length: give a wrench"),
        (TORQUE, {"length": np.ones(4)}, r"length: the winches of this robot take a length or a tension"),
        ({}, {"length": np.ones(3)}, r"length"),
        ({}, {"length": [1.0, 2.0, 3.0, np.nan]}, r"length.*finite"),
        ({}, {"length": np.ones(4), "tension": np.ones(4)}, r"step: expected tension or length, not both"),
        ({}, {"length": np.ones(4), "command": np.ones(4)}, r"step: expected length or command, not both"),
    ],
)
def test_wrong_commands_are_rejected(changes, given, text):
    with cdpr.Simulation(CAMERA, overrides={**SHORT, **changes}) as sim:
        sim.step()
        with pytest.raises(cdpr.CdprError, match=text):
            sim.step(**given)


@pytest.mark.parametrize(
    ("quantity", "said"),
    [
        ("angle,,,,,,,1,1,1,1", r"quantity: expected length, rate, command, or nothing"),
        ("length,,,,,,,1,0,1,1", r"expected lengths of more than 0 and at most 1e\+09 m, got 0"),
    ],
)
def test_a_file_with_wrong_quantities_is_rejected(tmp_path, quantity, said):
    names = [cable.name for cable in cdpr.load_robot(ROOT / "scenarios" / "robots" / "camera_robot.yaml").cables]
    (tmp_path / "given.csv").write_text(
        ",".join(["t,until,quantity,fx,fy,fz,mx,my,mz", *names]) + f"\n0.0,0.1,{quantity}\n"
    )
    text = CAMERA.read_text().replace("robots/", f"{ROOT}/scenarios/robots/")
    (tmp_path / "one.yaml").write_text(text + "events: [{type: outside, file: given.csv}]\n")
    with pytest.raises(cdpr.CdprError, match=rf"given\.csv.*2.*{said}"):
        cdpr.load_scenario(tmp_path / "one.yaml")
