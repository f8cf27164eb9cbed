"""The page of a study: what lies along x, what makes lines and panels, and that the page stands alone."""

from __future__ import annotations

import re

import pytest
from study_cases import write_study

from cdpr.report.figures.study_layout import layouts, panels
from cdpr.report.text.study import FIGURES
from cdpr.simulation.cases import Outcome
from cdpr.study import Results, load_study
from cdpr.study.table import make_table

ERROR, TENSION = FIGURES[0], FIGURES[3]

KP = "  - {key: controller.kp, values: [100, 200, 400]}\n"
KD = "  - {key: controller.kd, values: [20, 40]}\n"
ENGINE = "  - {key: simulation.backend, values: [reference, mujoco]}\n"
SOLVER = "  - {key: solver.type, values: [qp, lp]}\n"
DRAWN = """
  - zip:
      - {key: controller.kp, random: {uniform: [1, 2], count: 5}}
      - {key: controller.kd, random: {uniform: [1, 2], count: 5}}
"""


def results(tmp_path, text, status=lambda case: "finished"):
    """A study whose cases came out as their number: nothing is simulated."""
    study = load_study(write_study(tmp_path, text))
    rows = {}
    for number, case in enumerate(study.cases, 1):
        summary = {"position_error_m": {"max": 1e-3 * number, "rms": 0.0}, "tension_N": {"max": 10.0 * number}}
        rows[case.id] = Outcome(case.id, status(case), "", "", summary)
    return Results(study, tmp_path, rows, make_table(study, rows))


def layout(tmp_path, axes):
    (found,) = layouts(results(tmp_path, "axes:\n" + axes).study.blocks[0])
    return found.x, found.line, found.panels


@pytest.mark.parametrize(
    ("axes", "expected"),
    [
        (KP, ("controller.kp", None, ())),
        (ENGINE + KP, ("controller.kp", "simulation.backend", ())),
        (KD + ENGINE + SOLVER + KP, ("controller.kp", "controller.kd", ("simulation.backend", "solver.type"))),
        (ENGINE + SOLVER, ("simulation.backend", "solver.type", ())),
    ],
)
def test_numbers_lie_along_x_and_the_rest_has_a_place(tmp_path, axes, expected):
    assert layout(tmp_path, axes) == expected


def test_random_axes_that_run_together_are_each_shown(tmp_path):
    found = layouts(results(tmp_path, "axes:" + DRAWN).study.blocks[0])
    assert [(one.x, one.scattered) for one in found] == [("controller.kp", True), ("controller.kd", True)]


def test_panels_hold_the_figures_of_their_cases(tmp_path):
    found = results(tmp_path, "axes:\n" + ENGINE + SOLVER + KP)
    drawn = panels(layouts(found.study.blocks[0])[0], found.table.records(), ERROR)
    # The engines are lines; the cases are numbered with kp fastest and mm are drawn.
    assert list(drawn) == ["qp", "lp"]
    first, second = drawn["lp"]
    assert (first.label, first.x, first.values) == ("reference", (100, 200, 400), ((4.0,), (5.0,), (6.0,)))
    assert (second.label, second.values) == ("mujoco", ((10.0,), (11.0,), (12.0,)))


def test_cases_without_figures_are_crosses(tmp_path):
    def status(case):
        return "diverged" if case.labels["controller.kp"] == 200 else "finished"

    found = results(tmp_path, "axes:\n" + KP, status)
    ((curve,),) = panels(layouts(found.study.blocks[0])[0], found.table.records(), ERROR).values()
    assert curve.x == (100, 400)
    assert curve.lost == (200,)


@pytest.mark.parametrize("axes", [KP, ENGINE + SOLVER, KD + ENGINE + SOLVER + KP, DRAWN])
def test_the_page_stands_alone_and_is_the_same_again(tmp_path, axes):
    pytest.importorskip("matplotlib")
    from cdpr.report.pages.study import render

    found = results(tmp_path, "axes:\n" + axes)
    html = render(found)
    assert html == render(found)
    assert html.count("<svg") == 2 * len(layouts(found.study.blocks[0]))  # error and tension; nothing else was given
    assert not re.search(r'(src|href)="(?!#)', html)
    assert all(case.id in html for case in found.study.cases)
    assert "NaN" not in html


def test_names_are_escaped(tmp_path):
    pytest.importorskip("matplotlib")
    from cdpr.report.pages.study import render

    axes = "axes:\n  - name: <b>x</b>\n    points: {'<i>': {controller.kp: 1}, '&': {controller.kp: 2}}\n"
    html = render(results(tmp_path, axes))
    assert "<b>x" not in html
    assert "<i>" not in html
    assert "&lt;i&gt;" in html


def test_lost_cases_make_the_page_red(tmp_path):
    pytest.importorskip("matplotlib")
    from cdpr.report.pages.study import render

    found = results(tmp_path, "axes:\n" + KP, lambda case: "died")
    assert 'class="banner bad"' in render(found)
