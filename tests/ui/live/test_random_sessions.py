"""Random sequences of live requests: the saved session repeats the run to the bit, whatever was requested."""

from __future__ import annotations

import os

import numpy as np
import pytest
from conftest import ROOT
from fake_clock import FakeClock

import cdpr
from cdpr.base.errors import SimulationStopped
from cdpr.simulation.requests import Request, Requests
from cdpr.ui.live.drive import drive

SESSIONS = int(os.environ.get("CDPR_TEST_CASES", "40"))  # of each robot, in the slow test
DURATION, REQUESTS = 0.16, 14
ROBOTS = {"caroca": {}, "camera_robot": {}, "hangprinter": {"robot.winch.type": "velocity"}}


class Script:
    """Link that sends each request once its sample is shown, or a later one; in a pause, without waiting."""

    def __init__(self, asked):
        self.requests = Requests(FakeClock(tick=1.0))  # every slice is shown
        self.asked, self.refusals, self.paused = list(asked), [], False

    def begin(self, header):
        pass

    def show(self, row, sample, header):
        if self.asked and (self.paused or sample >= self.asked[0][0]):
            self.requests.put(self.asked.pop(0)[1], replaceable=False)

    def changed(self, parameters):
        self.paused = parameters.get("paused", self.paused)

    def refused(self, text):
        self.refusals.append(text)

    def warned(self, text):
        pass


def random_request(rng, robot, winches):
    """Return a random request, most of them possible."""
    m = robot.m
    body = {"mass": rng.uniform(0.1, 3.0), "center": rng.normal(0.0, 0.05, 3).tolist(), "inertia": [0.0] * 6}
    near = robot.home[:3] + rng.normal(0.0, 0.05, 3)
    cable, brief = int(rng.integers(1, m + 1)), float(rng.uniform(0.005, 0.05))
    rate = [None] * m
    rate[cable - 1] = float(rng.uniform(-0.05, 0.05))
    kinds = {
        "push": {"force": rng.normal(0.0, 5.0, 3).tolist(), "duration": rng.choice([None, brief])},
        "wrench": {"force": rng.normal(0.0, 5.0, 3).tolist(), "moment": [0.0] * 3},
        "attach": body | {"duration": rng.choice([None, brief])},
        "payload": body | {"mass": float(rng.choice([0.0, body["mass"]]))},
        "release": {"id": int(rng.integers(1, 6))},
        "target": {"position": near.tolist(), "duration": brief},
        "cut": {"cable": cable},
        "jam": {"cable": cable},
        "pause": {"paused": bool(rng.random() < 0.3)},
        "step": {"n": int(rng.integers(1, 8))},
        "speed": {"value": float(rng.choice([0.5, 1.0, 1e6]))},
        "limits": {"tension_min": float(rng.uniform(0.1, 2.0))},
        "control": {},
    }
    if winches:
        kinds |= {"jog": {"cable": cable, "rate": rate[cable - 1]}, "hold": {}}
        kinds["winch_command"] = {"names": [], "length": [], "rate": rate, "tension": []}
        rate[:] = [value or 0.0 for value in rate]
    else:
        kinds["tension"] = {"tension": rng.uniform(300.0, 420.0, m).tolist()}
    rare = ("cut", "jam", "control")
    share = np.array([0.3 if name in rare else 1.0 for name in kinds])
    name = str(rng.choice([*kinds], p=share / share.sum()))
    return Request(name, kinds[name])


def ended(run):
    """Return the run of a call, also of one that ends early."""
    try:
        return run()
    except SimulationStopped as stop:
        return stop.run


def session(name, seed, folder):
    """Return the run of a random session, that of its saved scenario, the kinds of its events, and its refusals."""
    rng = np.random.default_rng(seed)
    changes = {**ROBOTS[name], "simulation.duration": DURATION, "simulation.ends_early": True}
    scenario = cdpr.load_scenario(ROOT / "scenarios" / f"{name}.yaml", overrides=changes)
    last = scenario.simulation.steps
    samples = np.sort(rng.integers(0, int(0.9 * last), REQUESTS)).tolist()
    asked = [(sample, random_request(rng, scenario.robot, name != "caroca")) for sample in samples]
    asked.append((0, Request("pause", {"paused": False})))
    link = Script(asked)
    run = ended(lambda: drive(scenario, link, out=str(folder / "run"), speed=1e6, rate=1.0 / 0.004))
    assert link.asked == []
    assert not any("'" in text and "not an allowed request" in text for text in link.refusals)
    again = ended(lambda: cdpr.simulate(folder / "run" / "session.yaml"))
    return run, again, link


def check(name, seed, folder):
    run, again, link = session(name, seed, folder)
    assert list(again.header.layout.fields) == list(run.header.layout.fields)
    assert again.rows.tobytes() == run.rows.tobytes()
    assert [event.kind for event in again.events] == [event.kind for event in run.events]
    return {event.kind for event in run.events}, link


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.usual("caroca")
def test_random_sessions_repeat(name, tmp_path):
    kinds, link = check(name, 3, tmp_path)
    assert len(kinds) >= 3, link.refusals


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_many_random_sessions_repeat(name, tmp_path):
    seen = set()
    for seed in range(10, 10 + SESSIONS):
        kinds, _ = check(name, seed, tmp_path / str(seed))
        seen |= kinds
    expected = {"wrench", "payload", "target", "outside"} | (
        {"cable_break", "cable_jam"} if name == "caroca" else set()
    )
    assert expected <= seen
