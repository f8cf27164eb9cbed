"""Winches that take lengths or rates at the end of a connection: their commands and readings, without a process."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.cables.tables import command_kinds
from cdpr_backends import reference_schemes
from cdpr_backends import remote as plants
from cdpr_controllers import remote as controllers

CAMERA = ROOT / "scenarios" / "camera_robot.yaml"
SHORT = {"simulation.duration": 0.2, "trajectory.duration": 0.3}
REMOTE = {"simulation.backend": "remote", "backend_options.remote.address": "127.0.0.1:9"}
TORQUE = {"robot.cables[1].winch": {"type": "torque", "drum_radius": 0.05, "inertia": 0.002}}
CASES = {
    "servos": {},
    "ideal drives": {"robot.winch": {"type": "position"}, "controller": {"type": "computed_torque"}},
    "rates": {"robot.winch.type": "velocity", "controller": {"type": "computed_torque"}},
    "mixed": {**TORQUE, "controller": {"type": "computed_torque"}},
}
SAME = 1e-9  # m: round-off of rates from lengths


class FakeRobot:
    """Plant at the end of a connection: the backend `reference`, at rest in `lengths` until its first step."""

    def __init__(self, robot, gravity, step, lengths):
        self.backend = reference_schemes.make(robot, gravity, step, None)
        self.robot, self.lengths, self.step = robot, lengths, step
        self.rated = np.array([each == 2 for each in command_kinds(robot)])
        self.ideal = self.backend.winches.state.size == 2 * robot.m and "position" in {
            cable.winch.type for cable in robot.cables
        }
        self.frames, self.called = [], "peer 'fake'"

    def request(self, frame):
        m, backend = self.robot.m, self.backend
        self.frames.append(frame.copy())
        given = frame[2 : 2 + m]
        tension, unwound = np.zeros(m), np.zeros(m)
        if frame[0] == plants.START:
            backend.reset(frame[-13:])
            backend.command[:] = self.lengths
        elif self.ideal:
            backend.command[:] = (given - self._unwound()) / frame[1]
        else:
            backend.command[:] = given
        if frame[0] == plants.STEP:
            backend.step(round(frame[1] / self.step))
        backend.read_tension(tension)
        unwound[:] = self._unwound()
        return np.concatenate([backend.state, tension, unwound])

    def _unwound(self):
        unwound, rest = np.zeros(self.robot.m), np.zeros((2, self.robot.m))
        for do in self.backend.winch_readings(unwound, *rest):
            do()
        return unwound

    def send(self, frame):
        self.frames.append(frame.copy())

    def close(self):
        pass


@pytest.mark.parametrize("case", CASES)
def test_a_plant_takes_what_its_winches_take(case, monkeypatch):
    here = cdpr.simulate(CAMERA, overrides={**SHORT, **CASES[case]})
    scenario = cdpr.load_scenario(CAMERA, overrides={**SHORT, **CASES[case], **REMOTE})
    lengths = np.where(command_kinds(scenario.robot) == 0, here.cable_tension[0], here.unstretched_length[0])
    made, greetings = [], []

    def fake(options, program, greeting, sends, takes):
        greetings.append(greeting | {"sends": sends, "takes": takes})
        made.append(FakeRobot(scenario.robot, scenario.gravity, scenario.simulation.physics_step, lengths))
        return made[-1]

    monkeypatch.setattr(plants, "Peer", fake)
    there = cdpr.simulate(scenario)
    m = scenario.robot.m
    kinds = {"servos": "length", "ideal drives": "length", "rates": "rate", "mixed": "length"}
    expected = [kinds[case]] * m
    if case == "mixed":
        expected[1] = "tension"
    assert greetings[0]["commands"] == expected
    assert greetings[0]["takes"] == 13 + 2 * m
    assert np.abs(there.position - here.position).max() < SAME
    assert np.abs(there.unstretched_length - here.unstretched_length).max() < SAME
    sent = np.array([frame[2 : 2 + m] for frame in made[-1].frames if frame[0] == plants.STEP])
    wanted = here.winch_command[: len(sent)]
    assert np.abs(sent - wanted).max() < 1e-6  # N, m or m/s
    stops = [frame for frame in made[-1].frames if frame[0] == plants.STOP]
    assert (stops[-1][2 : 2 + m] == 0.0).all()


def test_a_controller_answers_in_the_units_of_the_winches(monkeypatch):
    changes = {**SHORT, **TORQUE}
    here = cdpr.simulate(CAMERA, overrides=changes)
    count = iter(range(len(here.rows) + 10))

    class Answers:
        skipped, called = 0, "peer 'fake'"

        def request(self, frame):
            return here.winch_command[min(next(count), len(here.rows) - 1)]

        def close(self):
            pass

    greetings = []
    monkeypatch.setattr(controllers, "Peer", lambda *given: greetings.append(given[2]) or Answers())
    remote = {"controller": {"type": "remote", "address": "127.0.0.1:9", "output": "winch"}}
    there = cdpr.simulate(CAMERA, overrides={**changes, **remote})
    assert greetings[0]["output"] == "winch"
    assert greetings[0]["commands"] == ["length", "tension", "length", "length"]
    np.testing.assert_array_equal(there.position, here.position)


def test_a_plant_with_cables_that_sag_is_rejected():
    heavy = {"robot.cable.model": "catenary", "robot.cable.linear_density": 0.05, "robot.tension.min": 10}
    scenario = cdpr.load_scenario(CAMERA, overrides={**SHORT, **heavy, **REMOTE})
    with pytest.raises(cdpr.CdprError):
        cdpr.simulate(scenario)
