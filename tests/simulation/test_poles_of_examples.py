"""Poles of the example scenarios: verdicts, slow drives, and loops that serve several poses."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT

from cdpr.scenario import load_scenario
from cdpr.simulation import linearised
from cdpr.simulation.build import build
from cdpr.simulation.linearised import linearise
from cdpr.simulation.loop_problems import loop_problems, rest_poses

SCENARIOS = ROOT / "scenarios"


def test_examples_are_stable():
    for name in ("caroca", "planar", "hangprinter"):
        assert loop_problems(load_scenario(SCENARIOS / f"{name}.yaml")) == ("stable", [])


@pytest.mark.parametrize(
    ("estimator", "verdict"), [(None, "stable"), ("ekf", "not computed: the states of the estimator")]
)
@pytest.mark.parametrize(("position_gain", "slow"), [(50.0, True), (5000.0, False)])
def test_slow_drives_are_reported(position_gain: float, slow: bool, estimator: str | None, verdict: str) -> None:
    """Servos with low gains stretch soft cables late; the closed loop is stable and follows with large errors."""
    winch = {"type": "position", "drum_radius": 0.05, "inertia": 0.002, "velocity_gain": 1.0, "integral_gain": 20.0}
    cable = {"model": "elastic", "axial_stiffness": 1e5, "damping": 100.0}
    changes = {"robot.cable": cable, "robot.winch": {**winch, "position_gain": position_gain}}
    if estimator:
        failure = {"type": "sensor_failure", "time": 3.0, "sensor": "encoders"}
        changes |= {
            "estimator.type": estimator,
            "sensors": [{"type": "encoders"}, {"type": "tension"}],
            "events": [failure],
        }
    known, found = loop_problems(load_scenario(ROOT / "scenarios" / "caroca.yaml").with_changes(changes))
    text = dict(found).get(("controller",), "")
    assert known.startswith(verdict)
    assert ("with the true state instead of the estimate" in text) == (slow and estimator is not None)
    assert ("the drives make the closed loop slow: its bandwidth is 0.29 Hz, that of kp and kd 1.6 Hz" in text) == slow


@pytest.mark.parametrize("name", ["caroca", "camera_robot", "sagging"])
def test_a_loop_that_serves_several_poses_has_the_bits_of_new_ones(name, monkeypatch):
    scenario, built = load_scenario(SCENARIOS / f"{name}.yaml"), []
    poses = list(rest_poses(scenario).values())
    monkeypatch.setattr(linearised, "build", lambda held: built.append(held) or build(held))
    with linearised.Linearisation(scenario) as reused:
        for pose in (*poses, poses[0]):
            one, other = reused.at(pose, response=True), linearise(scenario, pose, response=True)
            for key in ("A", "B", "corners", "plant", "scale", "rest"):
                assert np.array_equal(getattr(one, key), getattr(other, key)), key
            assert (one.names, one.notes) == (other.names, other.notes)
    assert len(built) == 1 + 3  # one for all poses, and one for each `linearise`
