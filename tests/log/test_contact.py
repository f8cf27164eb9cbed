"""The least clearance along the motion that a run made, and the event of cables that come too near."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT

import cdpr
from cdpr.analysis.workspace import measure
from cdpr.analysis.workspace.path import flown
from cdpr.base.errors import ExitCode, ScenarioError
from cdpr.log import recorder as recorder_module
from cdpr.log.run import CLEARANCE
from cdpr.mechanics.clearance import clearance
from cdpr.mechanics.closest import Closest, Level
from cdpr.simulation import pipeline
from cdpr.ui.cli import run as run_command
from cdpr.ui.report.pages.run import render
from cdpr.ui.report.text.reservations import reservations

CAROCA = ROOT / "scenarios" / "caroca.yaml"
THICK = {"robot.cable.diameter": 0.02}
# The end of caroca's move, near which cable_6 and cable_8 pass each other.
PASSING = {**THICK, "initial.position": [1.0, 0.33, 1.47], "trajectory.duration": 0.8, "simulation.duration": 0.4}
LEVEL = 0.05  # m, from which they are away at first


@pytest.fixture(scope="module")
def run():
    return cdpr.simulate(CAROCA, overrides=PASSING)


def looked_at(run, overrides=PASSING):
    """Return clearances of its rows and their pairs, by evaluating all pairs."""
    robot = cdpr.load_scenario(CAROCA, overrides=overrides).robot
    among = clearance(robot)
    values, which = among.at(run.rows[:, 1:8])
    return values, [among.name(n) for n in which.tolist()]


def contact(**keys):
    return {"events": [{"type": "contact", "clearance": LEVEL, **keys}]}


def test_the_summary_reports_minimum_time_and_quantity(run):
    values, names = looked_at(run)
    k = int(np.argmin(values))
    told = run.summary()
    assert [told[key] for key in CLEARANCE] == [values[k], run.time[k], names[k]]
    assert k > 0  # it is not the first one
    assert values[0] > LEVEL > values[k]


def test_no_warning_with_unknown_diameters(run):
    thin = cdpr.simulate(CAROCA, overrides={key: value for key, value in PASSING.items() if key not in THICK})
    assert not set(CLEARANCE) & set(thin.summary())
    np.testing.assert_array_equal(thin.rows, run.rows)


@pytest.mark.parametrize("way", ["in memory", "thinned", "on disk"])
def test_all_samples_count_wherever_their_rows_are(run, tmp_path, monkeypatch, way):
    if way == "on disk":
        monkeypatch.setattr(recorder_module, "IN_MEMORY", 0)
    more = {"log.step": 0.007} if way == "thinned" else {}
    other = cdpr.simulate(CAROCA, overrides={**PASSING, **contact(), **more}, out=tmp_path / "run")
    assert isinstance(other.rows, np.ndarray) == (way != "on disk")
    for each in (other, cdpr.load_run(tmp_path / "run")):
        assert {key: each.summary()[key] for key in CLEARANCE} == {key: run.summary()[key] for key in CLEARANCE}
    written = json.loads((tmp_path / "run" / "run.json").read_text())
    assert written["summary"]["clearance_min_m"] == run.summary()["clearance_min_m"]
    (event,) = other.events
    assert written["events"][0]["text"] == event.text
    assert event == cdpr.simulate(CAROCA, overrides={**PASSING, **contact()}).events[0]


def test_an_event_reports_each_interval(run):
    values, names = looked_at(run)
    under = np.flatnonzero(values <= LEVEL)
    assert len(under) == under[-1] - under[0] + 1  # one span
    found = cdpr.simulate(CAROCA, overrides=PASSING | contact())
    (event,) = found.events
    assert (event.kind, event.time, event.until) == ("contact", run.time[under[0]], run.time[under[-1]])
    assert event.text.startswith(f"{names[under[0]]} come within {LEVEL:g} m: clearance down to {values.min():.4g} m")
    assert event.text.endswith(f"({len(under)} samples)")
    np.testing.assert_array_equal(found.rows, run.rows)  # to look changes nothing
    later = float(run.time[under[0] + 5])
    (event,) = cdpr.simulate(CAROCA, overrides=PASSING | contact(time=later)).events
    assert event.time == later
    assert cdpr.simulate(CAROCA, overrides=PASSING | contact(clearance=1e-4)).events == ()


def step_by_step(path, **options):
    with cdpr.Simulation(path, **options) as simulation:
        while not simulation.done:
            simulation.step()


@pytest.mark.parametrize("way", ["blocks", "python", "steps"])
def test_it_may_stop_the_run(run, monkeypatch, way):
    values, names = looked_at(run)
    first = int(np.argmax(values <= LEVEL))
    if way == "python":
        monkeypatch.setattr(pipeline, "bound", lambda *given: None)
    with pytest.raises(cdpr.CollisionDetected, match=f"of {names[first]}; stopped by the scenario at 0.05 m") as stop:
        (step_by_step if way == "steps" else cdpr.simulate)(CAROCA, overrides=PASSING | contact(then="stop"))
    ended = stop.value.run
    assert (ended.status, stop.value.exit_code) == ("touched", ExitCode.INFEASIBLE)
    np.testing.assert_array_equal(ended.rows, run.rows[: first + 1])
    (event,) = ended.events
    assert (event.kind, event.time, event.until) == ("contact", run.time[first], None)
    assert ended.summary()["infeasible_steps"] == 0
    assert "Stopped: clearance of cables too small" in render(ended)


def test_blocks_stay_whole():
    with pytest.raises(cdpr.CollisionDetected) as stop:
        cdpr.simulate(CAROCA, overrides=PASSING | contact(then="stop"))
    assert stop.value.run.interpreted == ()


def test_a_simulation_goes_back_from_before_it_stopped(run):
    values, _ = looked_at(run)
    first = int(np.argmax(values <= LEVEL))
    with cdpr.Simulation(CAROCA, overrides=PASSING | contact(then="stop")) as simulation:
        simulation.step(first - 1)
        before = simulation.snapshot()
        simulation.step()
        simulation.restore(before)
        with pytest.raises(cdpr.CollisionDetected) as stop:
            simulation.step(10)
    np.testing.assert_array_equal(stop.value.run.rows, run.rows[: first + 1])


def test_a_rollout_ends_its_cases_where_runs_end():
    """Also those that go eight side by side."""
    gains, stops = np.linspace(100.0, 180.0, 9), PASSING | contact(then="stop")
    found = cdpr.rollout(
        CAROCA, 9, vary={"controller.kp": gains}, overrides=stops, every=1, columns=["position", "tension"]
    )
    for i in (0, 3, 8):
        with pytest.raises(cdpr.CollisionDetected) as stop:
            cdpr.simulate(CAROCA, overrides=stops | {"controller.kp": gains[i]})
        run = stop.value.run
        assert (found.status[i], found.outcomes[i].message) == (run.status, run.message)
        expected = np.concatenate([run.position, run.tension], axis=1)
        np.testing.assert_array_equal(found.rows[i, : len(expected)], expected)
        assert np.isnan(found.rows[i, len(expected) :]).all()


def test_a_broken_cable_touches_nothing_any_more(run):
    """Nor does one that breaks in the very sample at which it would."""
    values, names = looked_at(run)
    at = float(run.time[int(np.argmax(values <= LEVEL))])
    lost = {"type": "cable_break", "time": at, "cable": "cable_6", "detected_after": 0.0}
    events = [lost, *contact(then="stop")["events"]]
    assert "cable_6" in names[int(np.argmax(values <= LEVEL))]
    found = cdpr.simulate(CAROCA, overrides=PASSING | {"events": events})
    assert found.status == "finished"
    assert [event.kind for event in found.events] == ["cable_break"]
    assert found.summary()["clearance_min_m"] > LEVEL
    with cdpr.Simulation(CAROCA, overrides=PASSING | contact(then="stop")) as simulation:
        simulation.until(at - 0.002)
        simulation.cut("cable_6")
        simulation.until(0.4)
        assert simulation.run().status == "finished"


def test_obstacles_are_among_what_is_touched():
    where = cdpr.load_scenario(CAROCA, overrides=PASSING).robot.cables[0].frame
    ball = {"name": "lamp", "sphere": 0.3, "position": where.tolist()}
    found = cdpr.simulate(CAROCA, overrides=PASSING | contact(clearance=0.0) | {"world.obstacles": [ball]})
    assert "lamp" in found.summary()["clearance_min_by"]
    assert "touch: clearance down to" in found.events[0].text
    assert f"{found.summary()['clearance_min_by']} touched" in reservations(found)


@pytest.mark.parametrize("given", [{}, {"robot.cables[2].diameter": 0.01}])
def test_it_needs_to_know_how_thick_cables_are(given):
    with pytest.raises(ScenarioError, match=r"events\[0\]: requires the diameters of all cables; missing: 'cable_1'"):
        cdpr.load_scenario(CAROCA, overrides=given | contact())
    each = {f"robot.cables[{i}].diameter": 0.01 for i in range(8)}
    assert cdpr.load_scenario(CAROCA, overrides=each | contact()).events[0].type == "contact"


def test_the_command_line_ends_with_the_code_of_the_scenario(tmp_path):
    words = [str(CAROCA), "--out", str(tmp_path / "run")]
    words += ["--set", f"events=[{{type: contact, clearance: {LEVEL}, then: stop}}]"]
    words += [word for key, value in PASSING.items() for word in ("--set", f"{key}={value}")]
    result = CliRunner().invoke(run_command.command, [*words, "--statics"])
    assert result.exit_code == ExitCode.INFEASIBLE
    run = cdpr.load_run(tmp_path / "run")
    gap, at, by = (run.summary()[key] for key in CLEARANCE)
    assert f"  least clearance     {gap:.4g} m at {at:.6g} s, {by}\n" in result.output
    least = flown(cdpr.load_scenario(CAROCA).robot, run)
    assert list(least) == ["margin"]
    value = least["margin"]["value"]
    assert f"  capacity margin     {value:.4g} N, at rest, at " in result.output
    page = (tmp_path / "run" / "report.html").read_text()
    assert "Smallest clearance (m)" in page
    assert f"{value:.4g} N, at rest, at " in page


def test_margin_and_stiffness_of_a_run_are_those_of_its_rows():
    """Start time of the robot without the broken cable."""
    scenario = ROOT / "scenarios" / "winch.yaml"
    changes = {"simulation.duration": 0.2}
    run, robot = cdpr.simulate(scenario, overrides=changes), cdpr.load_scenario(scenario).robot
    found = flown(robot, run)
    margin = measure(robot, run.rows[:, 1:8]).value
    assert (found["margin"]["value"], found["margin"]["at_s"]) == (margin.min(), run.time[np.argmin(margin)])
    assert found["stiffness"]["value"] > 0.0
    lost = replace(run, header=replace(run.header, broken=((2, 0.1),)))
    fewer = replace(robot, cables=robot.cables[:2] + robot.cables[3:])
    after = run.time >= 0.1
    values = np.concatenate([margin[~after], measure(fewer, run.rows[after, 1:8]).value])
    assert flown(robot, lost)["margin"]["value"] == values.min() < margin.min()


@pytest.mark.parametrize("cut", [1, 7, 40, 1000])
def test_it_does_not_matter_in_what_pieces_rows_come(run, cut):
    robot = cdpr.load_scenario(CAROCA, overrides=PASSING).robot
    time, poses = run.time, run.rows[:, 1:8].copy()
    poses[30] = np.nan  # without a known distance
    values = looked_at(run)[0].copy()
    values[30] = np.inf
    level = float(np.quantile(values, 0.6))
    one = Closest(clearance(robot), levels=[Level(level), Level(level, float(time[250]))])
    one.add(time, poses)
    many = Closest(clearance(robot), levels=one.levels)
    for start in range(0, len(time), cut):
        again = many.copy()  # as where an interrupt cuts it short
        again.add(time[start : start + cut], poses[start : start + cut])
        many.add(time[start : start + cut], poses[start : start + cut])
    assert many.least == one.least
    assert one.least is not None
    assert one.least.clearance == values.min()
    for i in (0, 1):
        assert list(many.spans(i)) == list(one.spans(i)) != []
        under = (values <= level) & (time >= one.levels[i].after)
        assert sum(span.samples for span in one.spans(i)) == under.sum()
    under = np.concatenate([[False], values <= level])
    assert len(one.spans(0)) == np.count_nonzero(under[1:] & ~under[:-1])
