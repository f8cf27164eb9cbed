"""Notebook and terminal displays of robots, scenarios, simulations and runs; docs/first_steps.ipynb, executed."""

from __future__ import annotations

import ast
import json
import re
import sys
from dataclasses import replace
from html import unescape

import nbformat
import numpy as np
import pytest
from conftest import ROOT
from report_cases import CASES, make_run
from study_cases import write_study

import cdpr
from cdpr.analysis.study import load_study
from cdpr.base.errors import PluginError
from cdpr.log.export import column_names
from cdpr.ui.report.plots.pictures import MOST

COURSE = ROOT / "docs" / "first_steps.ipynb"
LONGEST = 160  # letters of what a terminal shows of an object
MOST_BYTES = 700_000  # of what a notebook keeps of a run, however long it was
UPRIGHT = {"rpy": [0, 0, 0]}
HOSTILE = '<script>alert("x")</script>&\''


def framed(html: str) -> str:
    """The page within what a notebook shows."""
    (inside,) = re.findall(r'srcdoc="([^"]*)"', html)
    assert html.count("<iframe") == 1
    return unescape(inside)


def data_of(page: str) -> dict:
    (block,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page)
    return json.loads(block)


@pytest.fixture(scope="module")
def scenario():
    return cdpr.load_scenario("cable_break", overrides={"simulation.duration": 0.1})


def test_a_run_is_a_table_a_scene_and_plots():
    html = make_run()._repr_html_()
    assert "Position error" in html
    page = framed(html)
    shown = data_of(page)
    assert [panel["label"] for panel in shown["figures"]["plots"]] == ["cable tension (N)", "position error (mm)"]
    assert len(shown["scenes"]) == 1
    assert 'id="slider"' in page
    assert 'sandbox="allow-scripts"' in html  # and neither the notebook's origin nor its cookies
    assert set(re.findall(r"var\((--\w+)", page)) <= set(re.findall(r"(--\w+):", page))  # every colour is described


@pytest.mark.parametrize("case", [case for case in CASES if case != "100000 rows"])
def test_any_run_is_shown(case):
    run = CASES[case]()
    html = run._repr_html_()
    assert ("<iframe" in html) == bool(len(run.rows))
    assert not len(run.rows) or data_of(framed(html))["scenes"]


@pytest.mark.slow
def test_a_long_run_stays_small():
    run = make_run(rows=30_000)  # 30 s: as many pictures as there ever are
    html = run._repr_html_()
    assert data_of(framed(html))["scenes"][0]["time"]["n"] >= MOST
    assert len(html) < MOST_BYTES


def test_robot_scenario_and_simulation_show_themselves(scenario):
    html = cdpr.load_robot("caroca")._repr_html_()
    assert "3R3T" in html
    assert data_of(framed(html))["scenes"][0]["time"]["n"] == 1
    shown = data_of(framed(scenario._repr_html_()))
    assert shown["span"] == [0.0, 0.1]
    assert shown["scenes"][0]["time"]["n"] == 101
    simulation = cdpr.Simulation(scenario)
    assert "tension" not in data_of(framed(simulation._repr_html_()))["scenes"][0]  # none is known yet
    simulation.step(50)
    html = simulation._repr_html_()
    assert "0.05 of 0.1 s" in html
    assert "tension" in data_of(framed(html))["scenes"][0]
    assert simulation.time == 0.05  # looking changes nothing
    simulation.close()


def test_names_cannot_break_out():
    run = make_run()
    run = replace(run, header=replace(run.header, scenario=HOSTILE, cables=(HOSTILE, *run.header.cables[1:])))
    robot = replace(cdpr.load_robot("caroca"), name=HOSTILE)
    for html in (run._repr_html_(), robot._repr_html_()):
        assert "<script>alert" not in html  # neither beside the frame
        assert framed(html).count("<script") == 2  # nor in it: data and script


def test_terminals_show_a_line(scenario, tmp_path):
    robot = scenario.robot
    simulation = cdpr.Simulation(scenario)
    run = make_run()
    told = [
        (robot, "<Robot caroca: 8 cables, 3R3T, platform of 150 kg>"),
        (robot.platform, "<Platform of 150 kg>"),
        (robot.cables[0], "<Cable cable_1: 50 to 10000 N>"),
        (scenario, "<Scenario cable_break: caroca on reference, controller computed_torque, solver qp, 0.1 s>"),
        (simulation, "<Simulation of cable_break on reference: 0 of 0.1 s>"),
        (run, "<Run of caroca on reference: 4001 samples, finished>"),
        (run.header, "<Header of caroca on reference: 8 cables, seed 0>"),
    ]
    assert [repr(thing) for thing, _ in told] == [text for _, text in told]
    study = load_study(write_study(tmp_path, "axes: [{key: controller.kp, values: [100, 200]}]"))
    more = (cdpr.admissible(robot, robot.home), simulation.snapshot(), study, cdpr.load_scenario("cable_break").events)
    for thing in more:
        assert len(repr(thing)) < LONGEST
        assert "array(" not in repr(thing)
    simulation.close()


def test_names_of_a_log_do_not_speak_to_the_terminal():
    run = make_run()
    odd = replace(run, header=replace(run.header, scenario="\x1b[31mred\nline", backend="\u202egnp"), status="\x07")
    for shown in (repr(odd), repr(odd.header)):
        assert shown.isprintable()
        assert r"\x1b[31mred\nline" in shown


def test_impossible_events_of_a_scenario_are_reported():
    """A motion shows if a target can be reached within its limits when it is created, not when the file is read."""
    slow = {"velocity": 1e-3, "acceleration": 1e-3, "jerk": 1e-3}
    events = [{"type": "target", "time": 1.5, "limits": slow, "position": [0, 0, 1.3]}]
    html = cdpr.load_scenario(
        "caroca", overrides={"events": events, "trajectory.to.orientation": UPRIGHT}
    )._repr_html_()
    assert "Cannot be run" in html
    assert "no quintic satisfies these limits, starting at" in html
    assert len(data_of(framed(html))["scenes"]) == 1


def test_rows_for_pandas():
    pandas = pytest.importorskip("pandas")
    run = make_run(rows=50)
    frame = run.to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    assert [frame.index.name, *frame.columns] == column_names(run.header)
    np.testing.assert_array_equal(frame.index, run.time)
    np.testing.assert_array_equal(frame["tension_cable_3_N"], run.tension[:, 2])
    frame.iloc[0, 0] = 7.0  # a copy: the run stays as it is
    assert run.position[0, 0] != 7.0


def test_without_pandas_the_remedy_is_reported(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(PluginError, match=r"pandas, which is not installed: pip install 'cdpr\[data\]'"):
        make_run(rows=5).to_pandas()


def test_the_notebook_contains_no_machine_details():
    text = COURSE.read_text()
    course = nbformat.reads(text, as_version=4)
    nbformat.validate(course)
    assert set(course.metadata) == {"kernelspec", "language_info"}
    assert course.metadata.language_info == {"name": "python"}
    for cell in course.cells:
        assert cell.metadata == {}
        assert cell.cell_type == "markdown" or (cell.outputs == [] and cell.execution_count is None)
    links = [to for cell in course.cells for to in re.findall(r"\]\(([^)#:]+)\)", cell.source)]
    assert links
    assert all((COURSE.parent / to).exists() for to in links)


@pytest.mark.slow
def test_the_course_runs_cell_by_cell(tmp_path, monkeypatch, capsys):
    """As in a notebook: one namespace, and the last value of a cell is displayed."""
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    shown = []
    for cell in nbformat.read(COURSE, as_version=4).cells:
        if cell.cell_type != "code":
            continue
        body = ast.parse(cell.source)
        last = body.body.pop() if isinstance(body.body[-1], ast.Expr) else None
        exec(compile(body, cell.id, "exec"), names)
        if last is None:
            continue
        value = eval(compile(ast.Expression(last.value), cell.id, "eval"), names)
        ways = (getattr(value, name, lambda: None)() for name in ("_repr_html_", "_repr_svg_"))
        picture = next(filter(None, ways), None)
        if picture is not None:
            shown.append(type(value).__name__)
            assert picture.count("<iframe") == 1 or picture.startswith("<svg")
    assert shown == ["Robot", "Scenario", "Run", "Simulation", "Run", "Chart"]
    assert (tmp_path / "push.pdf").read_bytes().startswith(b"%PDF")
    assert "never more than" in capsys.readouterr().out
    assert np.abs(names["pushed"].position_error).max() > 10 * np.abs(names["run"].position_error).max()


@pytest.mark.parametrize(("least", "most", "told"), [(0.012, 0.34, "0.012 to 0.34"), (1.0, 1e300, "1 to 1e+300")])
def test_tensions_of_any_size_are_reported_in_few_digits(least, most, told):
    run = make_run()
    rows = np.array(run.rows)
    rows[:, run.header.layout.columns["tension"]] = np.linspace(least, most, len(run.header.cables))
    assert f"with tensions from {told} N" in replace(run, rows=rows)._repr_html_()
