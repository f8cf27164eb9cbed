"""Page of a study: x axis, lines, panels, and self-contained content."""

from __future__ import annotations

import re
import shutil
import sys
from dataclasses import replace

import numpy as np
import pytest
from report_cases import diverged_run, make_run
from study_cases import write_study

from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.study import Results, load_study, run_study
from cdpr.analysis.study.table import make_table
from cdpr.ui.report.figures.study import ALONE_WIDE, TICKS, WIDTH, Scale, multiples
from cdpr.ui.report.figures.study_layout import MOST_PLACES, layouts, panels, thinned
from cdpr.ui.report.pages.study import render
from cdpr.ui.report.pages.study_cases import MOST, choose, player
from cdpr.ui.report.plots.cases import BEYOND, overlay
from cdpr.ui.report.plots.panel import LEAST_SHARE
from cdpr.ui.report.style import LEAST_ERROR
from cdpr.ui.report.text.study import FIGURES, LEAST_FORCE

ERROR, TENSION = FIGURES[0], FIGURES[3]

KP = "  - {key: controller.kp, values: [100, 200, 400]}\n"
KD = "  - {key: controller.kd, values: [20, 40]}\n"
ENGINE = "  - {key: simulation.backend, values: [reference, mujoco]}\n"
SOLVER = "  - {key: solver.type, values: [qp, lp]}\n"
MOST_BYTES = 1_500_000  # of a page
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
def test_the_page_is_self_contained_and_reproducible(tmp_path, axes):
    found = results(tmp_path, "axes:\n" + axes)
    html = render(found)
    assert html == render(found)
    assert html.count("<svg xmlns") == 2 * len(
        layouts(found.study.blocks[0])
    )  # error and tension; nothing else was given
    assert not re.search(r'(src|href)="(?!#)', html)
    assert all(case.id in html for case in found.study.cases)
    assert "NaN" not in html


TWO = "  - {key: controller.kp, values: [100, 200]}\n"


@pytest.mark.parametrize(
    ("what", "values", "least"),  # in the unit of the figure
    [
        (TENSION, (610.0, 610.0 + 3e-13), 610.0 * LEAST_SHARE),
        (TENSION, (1e-12, 4e-11), LEAST_FORCE),  # whose ratio would make a logarithmic scale
        (ERROR, (2e-13, 3e-13), LEAST_ERROR),
        (ERROR, (0.0, 5e-16), LEAST_ERROR),
    ],
)
def test_round_off_is_not_zoomed_into(what, values, least):
    assert np.subtract(*reversed(axis_of(what, values))) >= least * (1.0 - 1e-9)


def test_differences_fill_their_axis():
    for what, values in ((TENSION, (610.0, 610.5)), (ERROR, (1e-3, 2e-3)), (TENSION, (1.0, 100.0))):
        low, high = axis_of(what, values)
        shown, whole = (np.log(values), np.log([low, high])) if values[1] > 30.0 * values[0] else (values, [low, high])
        assert np.ptp(shown) > 0.8 * np.ptp(whole)


def axis_of(what, values):
    """The range of the axis on which two cases have these values of a figure."""
    scale = Scale.of(values, what.least)
    return tuple(10.0**end for end in scale.span) if scale.logarithmic else scale.span


@pytest.mark.parametrize(
    ("values", "ticks"),
    [
        ((100.0, 3200.0), ["100", "200", "500", "1000", "2000"]),
        ((1e-9, 1e3), ["1e-09", "1e-06", "0.001", "1", "1000"]),
        ((0.0, 1.0), ["0", "0.2", "0.4", "0.6", "0.8", "1"]),
        ((-1e-6, 1e-6), ["-1e-06", "-5e-07", "0", "5e-07", "1e-06"]),
        ((5.0, 5.0), ["4.8", "4.9", "5", "5.1", "5.2"]),
    ],
)
def test_ticks_are_round_and_within(values, ticks):
    scale = Scale.of(values)
    found = scale.ticks(TICKS)
    assert list(found.values()) == ticks
    assert all(scale.low <= place <= scale.high for place in found)
    assert all(scale.at(float(name)) == pytest.approx(place, abs=1e-12) for place, name in found.items())


def test_figures_are_as_wide_as_their_cards(tmp_path):
    for axes in (KP, ENGINE + SOLVER, KD + ENGINE + SOLVER + KP):
        found = results(tmp_path, "axes:\n" + axes)
        figure = multiples(layouts(found.study.blocks[0])[0], found.table.records(), ERROR)
        width = WIDTH if layouts(found.study.blocks[0])[0].panels else ALONE_WIDE
        assert f'width="{72 * width:g}"' in figure.markup("label")


def test_names_that_are_turned_have_room_above_what_x_is(tmp_path):
    names = ["a rather long name", "another long name", "one more"]
    points = ", ".join(f"{name}: {{controller.kp: {i}}}" for i, name in enumerate(names, 1))
    found = results(tmp_path, f"axes:\n  - {{name: gains, points: {{{points}}}}}\n")
    drawn = multiples(layouts(found.study.blocks[0])[0], found.table.records(), ERROR).markup("label")
    turned = [float(y) for y in re.findall(r'y="([\d.]+)"[^>]*rotate', drawn)]
    (below,) = re.findall(r'y="([\d.]+)"[^>]*>gains<', drawn)
    assert len(turned) == len(names)
    assert float(below) > max(turned) + 30.0  # pt


def test_a_figure_of_very_many_cases_stays_small_and_keeps_its_peak(tmp_path):
    layout = layouts(load_study(write_study(tmp_path, "axes:" + DRAWN)).blocks[0])[0]
    records = [
        {"controller.kp": 1 + i / 20_000, "status": "finished", ERROR.column: 1e-2 if i == 9_999 else 1e-3}
        for i in range(20_000)
    ]
    (curve,) = panels(layout, records, ERROR)[""]
    assert len(thinned(curve).x) <= MOST_PLACES < len(curve.x)
    assert max(max(values) for values in thinned(curve).values) == 10.0
    assert len(multiples(layout, records, ERROR).markup("label")) < 100_000


def test_a_page_of_very_many_figures_stays_small(tmp_path, monkeypatch):
    monkeypatch.setattr("cdpr.ui.report.pages.study.MOST_FIGURES", 3)
    block = "  - name: part_{0}\n    changes: {{controller.kd: {0}}}\n    axes:\n    "
    blocks = "".join(block.format(i) + KP for i in (1, 2))
    found = results(tmp_path, "blocks:\n" + blocks)
    html = render(found)
    assert html.count("<svg xmlns") == 3
    assert "1 more figures are left out" in html
    assert len(html) < MOST_BYTES


def kept_study(tmp_path, text):
    """A study that kept its runs."""
    return run_study(load_study(write_study(tmp_path, "keep: all\naxes:\n" + text)), tmp_path / "out")


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    return kept_study(tmp_path_factory.mktemp("few"), KP)


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    return kept_study(tmp_path_factory.mktemp("many"), KD + KP)


@pytest.mark.slow
def test_few_cases_play_all(few):
    shown, told = choose(few)
    assert [each.case for each in shown] == list(few.study.cases)
    assert told == []
    data, _ = player(shown)
    assert [scene["label"] for scene in data["scenes"]] == ["1: kp 100", "2: kp 200", "3: kp 400"]
    assert data["span"] == [0.0, 0.1]
    labels = [panel["label"] for panel in data["figures"]["cases"]]
    assert labels == ["position error (mm)", "orient. error (mrad)", "largest tension (N)", "smallest tension (N)"]
    assert all(len(panel["series"]) == 3 for panel in data["figures"]["cases"])


def test_of_many_the_extreme_ones_play(many):
    shown, _ = choose(many)
    errors = {case.id: many.rows[case.id].summary["position_error_m"]["max"] for case in many.study.cases}
    assert len({each.case.id for each in shown}) == MOST < len(errors)
    assert shown[0].case.id == max(errors, key=errors.get)
    assert shown[0].why == "greatest of all: largest position error (mm)"
    assert shown[1].case.id == min(errors, key=errors.get)


def test_the_page_plays_and_folds_its_tables(many):
    html = render(many)
    assert html.index('id="block1figure1_1"') < html.index('id="viewer"') < html.index('id="table"')
    assert "<summary>Cases with playback</summary>" in html
    assert len(html) < MOST_BYTES
    assert html == render(many)


@pytest.mark.parametrize("damage", ["gone", "empty", "cut", "died"])
def test_a_case_without_an_intact_log_is_reported(few, tmp_path, damage):
    folder = tmp_path / "copy"
    shutil.copytree(few.folder, folder)
    lost, *others = few.study.cases
    log = folder / "runs" / lost.id / "log.mcap"
    rows = dict(few.rows)
    if damage == "gone":
        log.unlink()
    elif damage == "empty":
        log.write_bytes(b"")
    elif damage == "cut":
        log.write_bytes(log.read_bytes()[:-2000])
    else:
        rows[lost.id] = replace(rows[lost.id], status="died")
    shown, (told,) = choose(replace(few, folder=folder, rows=rows))
    expected = {
        "gone": "1 of 3 cases have no log.",
        "empty": f"Case {lost.id} cannot be shown: ",
        "cut": f"Case {lost.id}",
        "died": "1 with a log failed, crashed or hung: see the table.",
    }
    assert told.startswith(expected[damage])
    assert [each.case.id for each in shown][-2:] == [case.id for case in others]


def test_a_study_that_kept_no_log_is_reported(tmp_path):
    found = results(tmp_path, "axes:\n" + KP)
    shown, told = choose(found)
    assert shown == []
    assert told == ["No case has a log: the study keeps logs of no case (its key `keep`)."]
    html = render(found)
    assert told[0] in html
    assert 'id="viewer"' not in html


def test_a_run_that_diverges_flattens_no_other():
    calm, wild = make_run(rows=200), diverged_run()
    drawn = overlay({"calm": calm, "wild": wild})[0].curves[1].points.values
    before = wild.position_error[: 3 * len(wild.rows) // 4]
    reached, most = np.nanmax(drawn), 1e3 * np.linalg.norm(before, axis=1).max()
    assert reached <= BEYOND * most
    assert np.nanmax(1e3 * np.linalg.norm(wild.position_error, axis=1)) > BEYOND * most


def test_without_matplotlib_the_page_has_its_figures(few, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "cdpr.ui.report.figures.canvas", raising=False)
    html = render(few)
    assert 'id="block1figure1_1"' in html
    assert all(case.id in html for case in few.study.cases)


def test_names_are_escaped(tmp_path):
    axes = "axes:\n  - name: <b>x</b>\n    points: {'<i>': {controller.kp: 1}, '&': {controller.kp: 2}}\n"
    html = render(results(tmp_path, axes))
    assert "<b>x" not in html
    assert "<i>" not in html
    assert "&lt;i&gt;" in html


def test_lost_cases_make_the_page_red(tmp_path):
    found = results(tmp_path, "axes:\n" + KP, lambda case: "died")
    assert 'class="banner bad"' in render(found)
