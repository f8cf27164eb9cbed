"""Runs whose solver gives no valid answer: their end, and the messages if the fallback is used."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner
from conftest import ROOT

from cdpr import Infeasible, SolverFailed, load_run, simulate
from cdpr.base.errors import ExitCode
from cdpr.log.run import Event
from cdpr.tension.policy import FALLBACK
from cdpr.tension.status import Status
from cdpr.ui.cli import run as run_command
from cdpr.ui.report.pages.tables import ending
from cdpr.ui.report.text.reservations import fallback

SCENARIO = ROOT / "scenarios" / "caroca.yaml"
HELD = FALLBACK["hold_tension"]


def test_a_solver_without_an_answer_stops_a_run_that_is_not_infeasible(tmp_path):
    asked = {"simulation.duration": 0.2, "solver.infeasible": "stop"}
    with pytest.raises(SolverFailed, match=r"solver 'closed_form' gave no valid answer: .*policy stop") as stop:
        simulate(SCENARIO, solver="closed_form", overrides=asked, out=tmp_path / "run")
    assert isinstance(stop.value, Infeasible)  # a caller that catches it continues to
    assert stop.value.exit_code == ExitCode.INFEASIBLE
    assert load_run(tmp_path / "run").status == stop.value.run.status == "unanswered"
    assert "Stopped: no valid answer of the solver" in ending(stop.value.run)
    with pytest.raises(Infeasible, match="no tensions within the limits balance") as none:
        simulate(SCENARIO, overrides=asked | {"robot.platform.mass": 5000.0})
    assert none.value.run.status == "infeasible"


@pytest.mark.parametrize(
    ("policy", "told"),
    [("best_effort", "the nearest wrench within the limits"), ("hold_tension", "the previous tensions were held")],
)
def test_a_run_of_the_fallback_alone_warns(policy, told, tmp_path):
    heavy = ["simulation.duration=0.02", "robot.platform.mass=5000", f"solver.infeasible={policy}"]
    words = [str(SCENARIO), "--no-report", *(word for change in heavy for word in ("--set", change))]
    result = CliRunner().invoke(run_command.command, [*words, "--out", str(tmp_path / "run")])
    assert result.exit_code == ExitCode.OK
    assert f"WARNING             the tensions at all 21 samples come from the fallback: {told} instead" in result.output
    result = CliRunner().invoke(run_command.command, [*words, "--json", "--out", str(tmp_path / "json")])
    assert json.loads(result.stdout)["reservations"][-1].startswith("the tensions at all 21")


def test_few_samples_of_the_fallback_are_no_warning():
    run = simulate(SCENARIO, overrides={"simulation.duration": 0.02})
    rows = run.rows.copy()
    status = run.header.layout.columns["status"]
    for bad, warns in ((2, []), (3, ["the tensions at 3 of 21 samples come from the fallback: " + HELD])):
        rows[-bad:, status] = Status.NOT_FOUND
        assert (
            list(fallback(replace(run, rows=rows, events=(Event(0.0, "not_found", f"gave up; {HELD} (1)"),)))) == warns
        )
