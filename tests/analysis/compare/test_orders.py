"""Orders of engines by `cdpr compare --refine`, without worker processes."""

from __future__ import annotations

import pytest
from compare_cases import ENGINES, SCHEME, Here, load

import cdpr
from cdpr.analysis.compare.comparison import compare
from cdpr.analysis.compare.engines import field
from cdpr.analysis.compare.job import summarise
from cdpr.analysis.compare.refinement import refine
from cdpr.analysis.compare.runs import RunResult


def test_orders():
    scenario = load("rotated_start", {"simulation.duration": 0.6})
    chosen = field(scenario, [ENGINES[0]])
    found = {measured.backend: measured for measured in refine(Here(scenario), chosen, "qp")}
    first, judge = found[ENGINES[0]], found["reference"]
    assert first.order == pytest.approx(1.0, abs=0.1)
    assert first.steps == pytest.approx([1e-3, 5e-4, 2.5e-4])
    assert judge.order == pytest.approx(4.0, abs=0.3)
    assert judge.control_step > 1e-3  # at 1 ms its errors are round-off
    assert all(each.outcome == "as declared" and each.errors[-1] > 1e-14 for each in found.values())
    assert first.truth_error < 0.01 * first.errors[-1]


def test_round_off_is_reported_where_there_is_nothing_else():
    """A loop of so few periods cannot be closed less often."""
    scenario = load("rotated_start", {"simulation.duration": 0.05})
    found = {each.backend: each for each in refine(Here(scenario), field(scenario, [ENGINES[0]]), "qp")}
    assert found["reference"].outcome == "at round-off"
    assert found["reference"].order is None
    assert not found["reference"].failed


def test_the_truth_is_of_the_highest_order_that_the_judge_has():
    """Though the scenario has it run a first-order scheme, whose error would count as everybody's."""
    scenario = load("rotated_start", {"simulation.duration": 0.3, SCHEME: "semi_implicit_euler"})
    chosen = field(scenario, [ENGINES[0]])
    assert (chosen.judge.name, chosen.judge.order) == ("reference", 1)
    for measured in refine(Here(scenario), chosen, "qp"):
        assert (measured.outcome, measured.order) == ("as declared", pytest.approx(1.0, abs=0.03))


def test_a_step_too_long_is_not_taken_for_round_off():
    """The engine is 0.2 m from the truth, and otherwise so good that no other check finds it."""
    long = {"simulation.control_step": 0.1, "simulation.physics_step": 0.1, "trajectory.duration": 1.0}
    scenario = load("caroca", {**long, "controller.kp": 1.0, "controller.kd": 2.0})
    found = {each.backend: each for each in refine(Here(scenario), field(scenario, [ENGINES[0]]), "qp")}
    assert found[ENGINES[0]].outcome == "too far"
    assert "m from the truth with a step of 100 ms" in found[ENGINES[0]].reason
    assert not found[ENGINES[0]].failed  # the engine does what its step allows


class Losing(Here):
    """Some runs fail."""

    def lost(self, wanted):
        return wanted.backend == "reference" and wanted.divide >= 16

    def _one(self, wanted):
        return RunResult(None, "failed", "boom\nmore", begun=False) if self.lost(wanted) else super()._one(wanted)


def test_a_lost_truth_is_not_taken_for_round_off():
    scenario = load("caroca", {"simulation.duration": 0.05})
    found = refine(Losing(scenario), field(scenario, [ENGINES[0]]), "qp")
    assert [(each.backend, each.outcome, each.reason) for each in found] == [
        ("reference", "failed", "the truth failed: boom"),
        (ENGINES[0], "failed", "the truth failed: boom"),
    ]


def test_orders_are_measured_of_engines_that_ran(monkeypatch):
    """The comparison reports an engine that rejects the scenario, and continues."""
    monkeypatch.setattr(Losing, "lost", lambda self, wanted: wanted.backend == ENGINES[0])
    scenario = load("caroca", {"simulation.duration": 0.05})
    assert [each.backend for each in refine(Losing(scenario), field(scenario, [ENGINES[0]]), "qp")] == ["reference"]
    monkeypatch.setattr(Losing, "lost", lambda self, wanted: wanted.backend == "reference")
    assert refine(Losing(scenario), field(scenario, [ENGINES[0]]), "qp") == []


@pytest.mark.usefixtures("traps_plugin")
def test_refinement_names_what_nothing_explains():
    traps = {"backend_options.traps": {"trap": "damping", "engine": "reference"}, "simulation.duration": 0.5}
    scenario = load("rotated_start", traps)
    found = {each.backend: each for each in refine(Here(scenario), field(scenario, ["traps"]), "qp")}
    assert found["traps"].outcome == "unlike"
    assert "check the declared order" in found["traps"].reason


SLACK = """
name: slack
robot:
  dof: [x, z]
  platform: {mass: 10}
  tension: {min: 0, max: 400}
  home: {position: [0, 0, 0]}
  cable: {model: elastic, axial_stiffness: 2.0e4, damping: 20}
  winch: {drum_radius: 0.04, inertia: 0.001}
  cables:
  - {frame: [-2, 0, 2], platform: [0, 0, 0]}
  - {frame: [2, 0, 2], platform: [0, 0, 0]}
  - {frame: [0, 0, -2], platform: [0, 0, 0]}
simulation: {duration: 0.5, control_step: 0.002, physics_step: 0.001}
trajectory: {type: quintic, duration: 0.4, to: {position: [0.1, 0, 0.05]}}
controller: {type: computed_torque, kp: 60, kd: 14}
"""


def test_a_cable_that_goes_slack_explains_a_lower_order():
    """Sound engines agree, and the judge is not rejected for its order."""
    scenario = cdpr.load_scenario("slack.yaml", text=SLACK)
    runs, chosen = Here(scenario), field(scenario, [ENGINES[0]])
    (group,) = compare(runs, chosen, ["qp"], named=True)
    orders = refine(runs, chosen, "qp")
    found = {each.backend: each for each in orders}
    assert found["reference"].outcome == "kinks"
    assert "instead of 4: cable 'cable_3'" in found["reference"].reason
    assert found[ENGINES[0]].outcome == "as declared"
    assert summarise({"scenario": "slack"}, [group], {"qp": orders}).figures["agrees"] is True
