"""Limits of lengths and winding speeds: counted, reported, and a reason to stop if the scenario requires it."""

from __future__ import annotations

import math
import tracemalloc

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT

from cdpr import Infeasible, LimitViolation, load_run, simulate
from cdpr.base.column import Column
from cdpr.base.errors import ExitCode
from cdpr.log.layout import Layout
from cdpr.log.limit_violations import beyond
from cdpr.mechanics.reach import Reach, plain_columns
from cdpr.native.bind import bind
from cdpr.ui.cli import run as run_command
from cdpr.ui.report.pages.tables import ending

SCENARIO = ROOT / "scenarios" / "caroca.yaml"
SLOW = {"robot.cables[1].speed_max": 0.2, "robot.cables[0].speed_max": 0.5, "simulation.duration": 1.0}

SMALL = 1000  # bytes: numbers, and what calls one another; the smallest array has 112


def reach_of(bounds, m=None):
    m = m or len(bounds[0])
    return Reach(plain_columns(m), bounds, m)


def rows(*columns):
    return np.column_stack(columns)


def test_counts_equal_those_of_a_simple_search():
    rng = np.random.default_rng(0)
    for _ in range(50):
        length, rate = rng.uniform(1.0, 3.0, (40, 3)), rng.normal(size=(40, 3))
        bounds = tuple(
            tuple(None if rng.random() < 0.3 else float(rng.uniform(*ends)) for _ in range(3))
            for ends in ((1.0, 1.5), (2.5, 3.0), (0.5, 2.0))
        )
        reach = reach_of(bounds)
        for part in np.array_split(np.arange(40), rng.integers(1, 6)):
            reach.add(rows(0.1 * part, length[part], rate[part]))
        found = {one.name: one for one in reach.exceeded()}
        low, high, fast = (np.array([np.nan if b is None else b for b in row]) for row in bounds)
        for name, away, value in (
            ("shorter", (low - length) / low, length),
            ("longer", (length - high) / high, length),
            ("faster", (np.abs(rate) - fast) / fast, np.abs(rate)),
        ):
            wrong = away > 0.0
            assert (name in found) == wrong.any()
            if name in found:
                one, at = found[name], np.unravel_index(np.nanargmax(away), away.shape)
                assert one.samples == wrong.any(axis=1).sum()
                assert one.first == np.argmax(wrong.any(axis=1))
                assert set(one.cables) == set(np.flatnonzero(wrong.any(axis=0)))
                assert (one.cables[0], one.worst) == (at[1], value[at])


def test_a_value_is_distinguished_from_its_limit():
    reach = reach_of(((1.0,), (1.8,), (None,)))
    reach.add(rows(np.zeros(2), np.array([[1.80001], [0.9]]), np.zeros((2, 1))))
    assert [one.text(["a"]) for one in reach.exceeded()] == [
        "cables shorter than allowed: a down to 0.9 of 1 m (1 sample)",
        "cables longer than allowed: a up to 1.80001 of 1.8 m (1 sample)",
    ]


def test_a_limit_that_is_just_reached_is_kept():
    reach = reach_of(((0.3,), (1.0,), (0.1 + 0.2,)))
    assert not reach.add(rows(np.zeros(2), np.array([[0.1 + 0.2], [1.0]]), np.array([[0.3], [-0.3]])))
    assert reach.add(rows(np.zeros(1), np.array([[0.5]]), np.array([[-0.31]])))
    assert [one.name for one in reach.exceeded()] == ["faster"]
    assert not reach_of((), 1).add(rows(np.zeros(1), np.array([[math.inf]]), np.array([[0.0]])))


TRUE_MARGIN = Column("true_margin", 0, "N", "")


def drawn(limits):
    """Counter of commands beyond the limits (2, m), and rows of them as in a loop."""
    layout = Layout(limits.shape[1], more=(TRUE_MARGIN,))

    def as_rows(tension):
        found = np.full((len(tension), layout.width), np.nan)
        found[:, layout.columns["time"]] = 0.0
        found[:, layout.columns["tension"]] = tension
        held = np.full(limits.shape[1], np.nan)
        for row, asked in zip(found, tension, strict=True):
            room = row[layout.columns["true_margin"]]
            bind("room_within_limits", limits=limits, tension=asked.copy(), held=held, room=room)()
        return found

    return beyond(layout, (), limits, ()), as_rows


def test_commands_beyond_true_limits_are_those_that_a_plain_look_finds():
    rng = np.random.default_rng(1)
    for _ in range(20):
        limits = np.array([rng.uniform(0.0, 50.0, 3), rng.uniform(100.0, 200.0, 3)])
        tension = rng.uniform(-20.0, 230.0, (40, 3))
        reach, as_rows = drawn(limits)
        for part in np.array_split(tension, rng.integers(1, 6)):
            reach.add(as_rows(part))
        below, above = limits[0] - tension, tension - limits[1]
        for one, away in zip(reach.exceeded(), (below, above), strict=True):
            at = np.unravel_index(np.argmax(away), away.shape)
            assert one.samples == (away > 0.0).any(axis=1).sum()
            assert one.first == np.argmax((away > 0.0).any(axis=1))
            assert (one.cables[0], one.worst, one.limit) == (at[1], tension[at], limits[int(away is above), at[1]])
        assert list(reach.counts()) == ["below_min", "above_max"]


def test_looking_at_a_row_allocates_nothing():
    """As in each step of a run under `limits: stop`."""
    reach, as_rows = drawn(np.array([[1.0, 1.0], [9.0, 9.0]]))
    leaves = reach.leaving(as_rows(np.array([[0.5, 9.5]]))[0])
    assert leaves() == 1
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
        for _ in range(1000):
            leaves()
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak - before < SMALL


def test_columns_outside_of_the_rows_are_an_error():
    reach = reach_of(((0.3,), (1.0,), (0.1,)))
    with pytest.raises(ValueError, match="rows: expected the columns of all limits, got 2"):
        reach.add(np.zeros((3, 2)))


@pytest.mark.parametrize("more", [{}, {"log.step": 0.01}])
def test_a_run_counts_and_reports_them(more, tmp_path):
    run = simulate(SCENARIO, overrides=SLOW | more, out=tmp_path / "run")
    whole = simulate(SCENARIO, overrides=SLOW)
    wrong = (np.abs(whole.rate[:, :2]) > [0.5, 0.2]).any(axis=1)
    assert 0 < wrong.sum() < len(wrong)
    assert run.summary()["beyond_limits_steps"] == {"shorter": 0, "longer": 0, "faster": wrong.sum()}
    (event,) = [event for event in run.events if event.kind == "limit"]
    assert event.time == pytest.approx(0.001 * np.argmax(wrong))
    assert event.text.startswith("cables wound faster than allowed: cable_2 up to 0.")
    assert f"but {wrong.sum()} of 1001 samples had cables wound faster than allowed" in ending(run)
    assert load_run(tmp_path / "run").header.bounds == run.header.bounds
    assert "beyond_limits_steps" not in simulate(SCENARIO, overrides={"simulation.duration": 0.01}).summary()


def test_limits_stop_ends_the_run(tmp_path):
    with pytest.raises(
        LimitViolation, match=r"cables wound faster than allowed: cable_2 up to 0.2\d* of 0.2 m/s .*limits: stop"
    ) as stop:
        simulate(SCENARIO, overrides=SLOW | {"limits": "stop"}, out=tmp_path / "run")
    assert isinstance(stop.value, Infeasible)  # a caller that catches it continues to
    assert load_run(tmp_path / "run").status == stop.value.run.status == "beyond_limits"
    assert stop.value.run.summary()["infeasible_steps"] == 0  # each sample had tensions that balance its wrench
    assert "Stopped: limit violation of a cable" in ending(stop.value.run)
    assert stop.value.exit_code == ExitCode.INFEASIBLE
    rate = np.abs(stop.value.run.rate[:, 1])
    assert rate[-1] > 0.2
    assert (rate[:-1] <= 0.2).all()
    run = simulate(SCENARIO, overrides=SLOW | {"limits": "stop", "simulation.duration": 0.1})
    assert run.status == "finished"


def test_the_command_line_ends_with_the_code_of_the_scenario(tmp_path):
    words = [
        str(SCENARIO),
        "--no-report",
        *(word for key, value in SLOW.items() for word in ("--set", f"{key}={value}")),
    ]
    result = CliRunner().invoke(run_command.command, [*words, "--out", str(tmp_path / "warned")])
    assert result.exit_code == ExitCode.OK
    assert "finished, but " in result.output
    result = CliRunner().invoke(
        run_command.command, [*words, "--set", "limits=stop", "--out", str(tmp_path / "stopped")]
    )
    assert result.exit_code == ExitCode.INFEASIBLE
    assert "samples, beyond limits\n" in result.output


BREAK = {
    "events": [{"type": "cable_break", "time": 0.2, "cable": "cable_2", "detected_after": 0.05}],
    "simulation.duration": 0.4,
}


@pytest.mark.parametrize("more", [{}, {"log.step": 0.01}])
def test_a_broken_cable_does_not_hide_the_others(more):
    run, whole = simulate(SCENARIO, overrides=BREAK | more), simulate(SCENARIO, overrides=BREAK)
    intact = np.delete(whole.tension, 1, axis=1)
    figures = run.summary()
    assert whole.tension.min() == 0.0
    assert figures["tension_N"]["min"] == min(intact.min(), whole.tension[:200, 1].min()) >= 50.0
    steps = np.abs(np.diff(intact, axis=0)).max(), np.abs(np.diff(whole.tension[:200, 1])).max()
    assert figures["tension_N"]["largest_step"] == max(steps)
    assert figures["margin_min_N"] == pytest.approx(figures["tension_N"]["min"] - 50.0)


@pytest.mark.parametrize("limits", ["warn", "stop"])
def test_a_broken_cable_has_no_limits_to_leave(limits):
    whole = simulate(SCENARIO, overrides=BREAK)
    most = float(whole.length[:200, 1].max()) + 1e-6
    assert whole.length[200:, 1].max() > most
    limited = {"robot.cables[1].length.max": most, "limits": limits}
    assert simulate(SCENARIO, overrides=BREAK | limited).summary()["beyond_limits_steps"]["longer"] == 0
    late = {**BREAK, "events": [{**BREAK["events"][0], "time": 0.3}]} | limited | {"limits": "warn"}
    assert simulate(SCENARIO, overrides=late).summary()["beyond_limits_steps"]["longer"] > 50


def test_no_answer_and_no_admissible_tensions_are_two_sentences():
    gave_up = simulate(SCENARIO, solver="closed_form", overrides={"simulation.duration": 0.2})
    assert gave_up.summary()["infeasible_steps"] == 0
    missed = gave_up.summary()["unanswered_steps"]
    assert missed > 50
    assert f"at {missed} of 201 samples solver closed_form gave no valid answer" in ending(gave_up)
    none = simulate(SCENARIO, overrides={"simulation.duration": 0.2, "robot.platform.mass": 5000.0})
    assert none.summary()["unanswered_steps"] == 0
    assert f"{none.summary()['infeasible_steps']} of 201 samples had no admissible tensions" in ending(none)
    for run in (gave_up, none):
        assert "come from the fallback" in ending(run)
        assert ending(run).count("the nearest wrench within the limits instead") == 1
