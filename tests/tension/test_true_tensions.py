"""Verdicts on the tensions that cables have, where these are not the commands: limits, slack, and the exit code."""

from __future__ import annotations

import os
import shutil
from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner
from pushed_point import pushed_point

from cdpr import LimitViolation, Simulation, load_run, simulate
from cdpr.base.columns import WINCHED
from cdpr.base.errors import ExitCode
from cdpr.log import run_json
from cdpr.log.layout import Layout
from cdpr.log.limit_violations import beyond
from cdpr.log.repair import repair
from cdpr.log.slack import MOST_EVENTS, Slack
from cdpr.ui.cli import run as run_command
from cdpr.ui.report.pages.tables import cables, ending, summary
from cdpr.ui.report.text.reservations import reservations

RUNS = int(os.environ.get("CDPR_TEST_CASES", "3"))  # random runs

DIGITS = 1e-3  # tables show at least three digits

PUSHED = pushed_point(tension_max=400, duration=1.5, time=0.2)


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    path = tmp_path_factory.mktemp("pushed") / "pushed.yaml"
    path.write_text(PUSHED)
    return path


@pytest.fixture(scope="module")
def pushed(scenario):
    return simulate(scenario)


def test_true_tensions_are_judged(pushed):
    figures, true = pushed.summary(), pushed.cable_tension
    assert pushed.tension.max() <= 400.0 < true.max()  # the commands are innocent
    assert figures["beyond_limits_steps"] == {
        "tension_below_min": (true < 5.0 - 1e-6).any(axis=1).sum(),
        "tension_above_max": (true > 400.0 + 1e-6).any(axis=1).sum(),
    }
    assert figures["slack_samples"] == (true <= 0.0).any(axis=1).sum() > 100
    assert "had cable tensions higher than allowed" in ending(pushed)
    assert "had slack cables" in ending(pushed)
    assert "Samples with slack cables; intervals" in summary(pushed, {})
    assert any(event.text.startswith("cable tensions higher than allowed: cable_") for event in pushed.events)


def test_the_table_of_cables_shows_true_tensions(pushed):
    rows = [row.split("</td>") for row in cables(pushed).split("<tr>")[2:]]
    shown = [[float(cell.rpartition(">")[2]) for cell in row[2:4]] for row in rows]
    true = pushed.cable_tension
    assert np.allclose(shown, np.column_stack([true.min(axis=0), true.max(axis=0)]), DIGITS, DIGITS)
    assert true.max() > pushed.tension.max() * (1.0 + DIGITS), "the commands would not pass"


def test_low_tensions_of_lengths_get_advice(pushed):
    lengths = simulate("hangprinter", overrides={"simulation.duration": 0.02, "controller.pretension": 0.0})
    for run, advised in ((lengths, True), (pushed, False)):
        (text,) = [text for text in reservations(run) if "cable tensions lower than allowed" in text]
        assert text.endswith("raise controller.pretension)") == advised


def plain_intervals(time, slack):
    """Return (cable, from, to) by a plain check of each sample."""
    found = []
    for cable in range(slack.shape[1]):
        edges = [k for k in range(len(slack)) if slack[k, cable] != (k > 0 and slack[k - 1, cable])]
        edges += [len(slack)] * (len(edges) % 2)
        found += [(cable, time[a], time[min(b, len(time) - 1)]) for a, b in list(pairwise(edges))[::2]]
    return sorted(found, key=lambda one: (one[1], one[2], one[0]))


def test_slack_intervals_are_those_of_a_plain_look(pushed):
    found = [
        (pushed.header.cables.index(one["cable"]), one["from_s"], one["to_s"])
        for one in pushed.summary()["slack_intervals"]
    ]
    assert found == plain_intervals(pushed.time, pushed.cable_tension <= 0.0)
    events = [event for event in pushed.events if event.kind == "slack"]
    assert events[0].text.startswith("slack: cable_1, cable_2, cable_3, cable_4 (")


def test_slack_is_the_same_in_pieces_of_any_size():
    rng = np.random.default_rng(3)
    for _ in range(30):
        slack, time = rng.random((60, 3)) < rng.random(), np.arange(60) * 0.01
        pieces = Slack()
        for part in np.split(np.arange(60), np.unique(rng.integers(1, 60, 4))):
            pieces = pieces.added(time[part], slack[part])
        assert pieces == Slack().added(time, slack)
        assert [(one.cable, one.start, one.stop) for one in pieces.intervals()] == plain_intervals(time, slack)
        assert pieces.samples == slack.any(axis=1).sum()
        assert sum(one.samples for one in pieces.intervals()) == slack.sum()


def test_chatter_is_counted_in_few_lines():
    slack = np.tile([[True], [False]], (400, 1))
    found = Slack().added(np.arange(800.0), slack)
    events = found.events(["a"])
    assert len(events) == MOST_EVENTS + 1
    assert events[-1].text == f"{400 - MOST_EVENTS} further intervals with slack cables"


def test_limits_stop_ends_the_run(scenario, pushed):
    with pytest.raises(LimitViolation, match=r"cable tensions lower than allowed: cable_1 down to .* of 5 N") as stop:
        simulate(scenario, overrides={"limits": "stop"})
    run = stop.value.run
    outside = (pushed.cable_tension < 5.0 - 1e-6).any(axis=1)
    assert len(run.rows) == np.argmax(outside) + 1
    np.testing.assert_array_equal(run.rows, pushed.rows[: len(run.rows)])
    assert stop.value.exit_code == ExitCode.INFEASIBLE == 4
    assert run.header.limit_changes == ()


def test_the_command_line_reports_and_stops(scenario, tmp_path):
    words = [str(scenario), "--no-report", "--set", "simulation.duration=0.8"]
    warned = CliRunner().invoke(run_command.command, [*words, "--out", str(tmp_path / "warned")])
    assert warned.exit_code == ExitCode.OK
    assert "WARNING             cable tensions lower than allowed: cable_" in warned.output
    assert " samples, 4 cables\n" in warned.output
    assert load_run(tmp_path / "warned").summary()["slack_samples"] > 0
    stopped = CliRunner().invoke(
        run_command.command, [*words, "--set", "limits=stop", "--out", str(tmp_path / "stopped")]
    )
    assert stopped.exit_code == 4


def test_limits_that_events_change_hold_from_then_on(scenario):
    """Also those that come from outside, and none after the power is cut."""
    raised = [{"type": "limits", "time": 0.05, "max": 20}, {"type": "emergency_stop", "time": 0.1, "category": 0}]
    overrides = {"events": raised, "simulation.duration": 0.2, "robot.tension.max": 300.0}
    run = simulate(scenario, overrides=overrides)
    high = np.where(run.time < 0.05 - 1e-9, 300.0, 20.0)
    low = np.where(run.time < 0.1 - 1e-9, 5.0, -np.inf)
    true = run.cable_tension
    below, above = (true < low[:, None] - 1e-6).any(axis=1), (true > high[:, None] + 1e-6).any(axis=1)
    counts = {"tension_below_min": below.sum(), "tension_above_max": above.sum()}
    assert run.summary()["beyond_limits_steps"] == counts
    assert above.sum() > 0
    assert true[-1].max() < 5.0
    assert [time for time, *_ in run.header.limit_changes] == [0.05, 0.1]
    with Simulation(scenario, overrides={"events": [], "simulation.duration": 0.2}) as sim:
        sim.until(0.05)
        sim.limits(max=30)
        live = sim.run()
    assert live.header.limit_changes[0][0] == pytest.approx(0.05)


def changed_live(scenario, out, killed=None):
    """Return a run that live commands change; `killed` becomes a copy of its folder from before its end."""
    with Simulation(scenario, overrides={"events": [], "simulation.duration": 0.15}, out=out) as sim:
        sim.until(0.03)
        sim.limits(max=20)
        sim.until(0.06)
        sim.stop(0)
        if killed is not None:
            shutil.copytree(out, killed)
        return sim.run()


def test_limits_that_change_live_hold_in_the_log_too(scenario, tmp_path):
    live = changed_live(scenario, tmp_path / "run")
    loaded = load_run(tmp_path / "run")
    assert loaded.header.limit_changes == live.header.limit_changes
    assert live.summary()["beyond_limits_steps"]["tension_above_max"] > 0
    assert loaded.summary()["beyond_limits_steps"] == live.summary()["beyond_limits_steps"]


def test_a_killed_run_is_repaired_with_what_changed_live(scenario, tmp_path):
    live = changed_live(scenario, tmp_path / "run", killed=tmp_path / "killed")
    assert run_json.read(tmp_path / "killed")["status"] == "running"
    repair(tmp_path / "killed")
    killed = load_run(tmp_path / "killed")
    assert killed.status == "interrupted"
    assert killed.header.limit_changes == live.header.limit_changes != ()


def test_ideal_cables_are_judged_by_their_commands(scenario):
    ideal = {"robot.cable.model": "ideal", "simulation.duration": 0.3}
    figures = simulate(scenario, overrides=ideal).summary()
    assert "beyond_limits_steps" not in figures
    assert (figures["slack_samples"], figures["slack_intervals"]) == (0, [])
    cut = {"events": [{"type": "emergency_stop", "time": 0.1, "category": 0}]}
    figures = simulate(scenario, overrides=ideal | cut).summary()
    assert figures["slack_samples"] == 201
    assert {one["cable"] for one in figures["slack_intervals"]} == {f"cable_{i}" for i in range(1, 5)}


def test_a_row_is_judged_alike_in_the_loop_and_afterwards():
    """`leaving` checks one live sample in the compiled loop, `add` at all afterwards."""
    rng = np.random.default_rng(4)
    layout, limits = Layout(3, WINCHED), np.array([[5.0, 5.0, 0.0], [90.0, 90.0, 90.0]])
    changes = [(0.2, (10.0, None, 1.0), (80.0, 100.0, 90.0)), (0.3, (5.0, 5.0, 5.0), (70.0, 70.0, 70.0))]
    row = np.zeros(layout.width)
    reach = beyond(layout, (), limits, [(1, 0.25)], changes)
    leaving, found = reach.leaving(row), []
    for _ in range(300):
        row[layout.columns["time"]] = rng.choice([0.1, 0.2, 0.25, 0.3])
        row[layout.columns["cable_tension"]] = rng.uniform(-1.0, 110.0, 3)
        alone = beyond(layout, (), limits, [(1, 0.25)], changes)
        time, tension = float(row[0]), row[layout.columns["cable_tension"]]
        low, high = limits if time < 0.2 else np.array([[10, -np.inf, 1], [80, 100, 90.0]])
        low, high = (low, high) if time < 0.3 else (np.full(3, 5.0), np.full(3, 70.0))
        sound = np.array([True, time < 0.25, True])
        wrong = bool((((tension < low) | (tension > high)) & sound).any())
        found.append(wrong)
        assert bool(leaving()) == alone.add(row[None]) == wrong
    assert 0 < sum(found) < 300


def test_random_runs_are_judged_as_a_plain_look_judges_them(scenario):
    rng = np.random.default_rng(5)
    told = 0
    for _ in range(RUNS):
        model = str(rng.choice(["elastic", "rigid"]))
        low, high = float(rng.uniform(0, 20)), float(rng.uniform(60, 300))
        push = {"type": "wrench", "time": 0.05, "duration": 0.05, "force": rng.uniform(-600, 900, 3).tolist()}
        overrides = {
            "robot.cable.model": model,
            "robot.tension.min": low,
            "robot.tension.max": high,
            "events": [push],
            "simulation.duration": 0.25,
        }
        run = simulate(scenario, overrides=overrides)
        true, figures = run.cable_tension, run.summary()
        counts = [(true < low - 1e-6).any(axis=1).sum(), (true > high + 1e-6).any(axis=1).sum()]
        assert list(figures["beyond_limits_steps"].values()) == counts
        assert figures["slack_samples"] == (true <= 1e-6).any(axis=1).sum()
        told += sum(counts) > 0
    assert told


ANCHOR = """
robot:
  name: pass
  dof: [x, y, z]
  platform: {mass: 5}
  tension: {min: 0, max: 300}
  home: {position: [0, 0, 1.0]}
  cables:
  - {frame: [-2, -2, 3], platform: [0, 0, 0]}
  - {frame: [2, -2, 3], platform: [0, 0, 0]}
  - {frame: [0, 2, 3], platform: [0, 0, 0]}
  - {frame: [0.5, 0, 1.0], platform: [0, 0, 0]}
simulation: {backend: reference, duration: 3, control_step: 0.001}
trajectory: {type: quintic, duration: 2, to: {position: [1, 0, 1.0]}}
"""


def test_a_cable_that_passes_its_anchor_leaves_no_energy_balance(tmp_path):
    (tmp_path / "s.yaml").write_text(ANCHOR)
    run = simulate(tmp_path / "s.yaml")
    assert run.summary()["through_anchor_s"] == pytest.approx(1.0, abs=0.01)
    assert not run.summary()["energy_J"]["balanced"]
    assert "passes its anchor" in ending(run)
