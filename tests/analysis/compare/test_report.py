"""The page and the text of comparisons that went wrong."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from compare_cases import ENGINES, Here, load

import cdpr
from cdpr.analysis.compare.comparison import compare
from cdpr.analysis.compare.engines import field
from cdpr.analysis.compare.job import summarise
from cdpr.analysis.compare.refinement import Measured
from cdpr.analysis.compare.runs import RunResult
from cdpr.ui.report.pages.compare import render
from cdpr.ui.report.text.compare import lines

FACTS = {
    "scenario": "a <b>",
    "robot": "caroca",
    "duration_s": 0.1,
    "control_step_s": 1e-3,
    "physics_step_s": 1e-3,
    "judge": {"backend": "reference", "order": 4},
    "absent": {"dart": "not installed: pip install 'cdpr[dart]'"},
}


def result(ends, orders=()):
    """A comparison in which the only engine ended like that."""

    class Ending(Here):
        def _one(self, wanted):
            return ends if wanted.backend == ENGINES[0] else super()._one(wanted)

    scenario = load("caroca", {"simulation.duration": 0.1})
    chosen = field(scenario, ENGINES[:1])
    return summarise(FACTS, compare(Ending(scenario), chosen, ["qp"], named=True), {"qp": orders})


@pytest.fixture(scope="module")
def diverged():
    run = cdpr.simulate(load("caroca", {"simulation.duration": 0.1}), backend=ENGINES[0])
    rows = run.rows[:60].copy()
    rows[50:, 1] = 1e200
    rows[55:, 1] = np.nan
    return dataclasses.replace(run, rows=rows, status="diverged", message="the state is not finite")


def test_a_run_that_diverged(diverged):
    found = result(RunResult(diverged, "diverged", "the state is not finite"))
    html, text = render(found), "\n".join(lines(found.figures))
    assert found.figures["agrees"] is False
    assert "the run ended as diverged at 0.059 s, reference finished" in " ".join(text.split())
    assert "not finite" in text
    assert html.index("The engines disagree") < html.index("ended as diverged") < html.index("<svg")
    assert "a &lt;b&gt;" in html


def test_a_process_that_died():
    found = result(RunResult(None, "died", "the process of this case was ended by SIGSEGV\nFatal Python error"))
    html, text = render(found), list(lines(found.figures))
    assert found.figures["agrees"] is False
    assert any("FAILED: died: the process of this case was ended by SIGSEGV" in line for line in text)
    assert "SIGSEGV" in html[: html.index("</header>")]
    assert "<svg" not in html  # nothing to draw
    assert text[-1] == "dart: not run: not installed: pip install 'cdpr[dart]'"


def test_a_wrong_order(diverged):
    """It is reported, but is not a failure: the runs agree."""
    sound = cdpr.simulate(load("caroca", {"simulation.duration": 0.1}), backend=ENGINES[0])
    wrong = Measured(
        ENGINES[0], 1, "unlike", "order 0.42 instead of 1", 0.42, 1e-3, (1e-3, 5e-4, 2.5e-4), (4e-5, 3e-5, 2e-5), 1e-9
    )
    found = result(RunResult(sound, "finished", ""), [wrong])
    assert found.figures["groups"][0]["engines"][0]["outcome"] == "agrees"
    assert found.figures["agrees"] is True
    html = render(found)
    assert f"{ENGINES[0]}: unlike: order 0.42 instead of 1" in html[html.index("</header>") :]
    said = list(lines(found.figures))
    assert any("0.420 of 1  unlike" in line for line in said)
    assert "the error of the reference is at most about 1e-09 m" in " ".join(" ".join(said).split())


@pytest.mark.parametrize(
    ("outcome", "reason", "agrees"),
    [("failed", "the truth died: SIGSEGV", False), ("too far", 4 * "0.17 m from the truth, ", True)],
)
def test_an_order_that_could_not_be_measured(outcome, reason, agrees):
    """The text and the top of the page of a failed run contain its reason."""
    sound = cdpr.simulate(load("caroca", {"simulation.duration": 0.1}), backend=ENGINES[0])
    found = result(RunResult(sound, "finished", ""), [Measured(ENGINES[0], 1, outcome, reason)])
    assert found.figures["agrees"] is agrees
    html, text = render(found), list(lines(found.figures))
    assert (f"{outcome}: {reason}".strip() in html[: html.index("</header>")]) is not agrees
    assert f"{outcome}: {reason}".strip() in html
    assert f"measured order of {ENGINES[0]}: {outcome}: {reason}".strip() in " ".join(" ".join(text).split())
    assert max(map(len, text)) <= 80
