"""One page of every kind that cdpr writes, as users get them: builders by name, each writes into a folder."""

from __future__ import annotations

import re
from functools import partial
from html import unescape

import pytest
from command_line import cdpr_here
from conftest import ROOT
from design_cases import BOX, ONE, TWO, design_of
from pushed_point import pushed_point
from report_cases import CASES
from study_cases import write_study

import cdpr
from cdpr.analysis.design import run_design
from cdpr.analysis.study import load_study, run_study
from cdpr.analysis.workspace import region, workspace
from cdpr.ui.report.pages.design import write_design
from cdpr.ui.report.pages.run import write_report
from cdpr.ui.report.pages.study import write_study as write_study_page
from cdpr.ui.report.pages.workspace import render_workspace

ROBOTS = ROOT / "scenarios" / "robots"
BRIEF = "simulation.duration=0.2"

ONE_AXIS = "keep: all\naxes:\n  - {key: controller.kp, values: [50, 100, 200]}\n"
TWO_AXES = (
    "keep: all\naxes:\n  - {key: solver.type, values: [qp, lp]}\n  - {key: controller.kp, values: [50, 100, 200]}\n"
)
THREE_AXES = TWO_AXES + "  - {key: controller.kd, values: [10, 20]}\n"
FOUR_AXES = THREE_AXES + "  - {key: simulation.control_step, values: [0.001, 0.002]}\n"
SLACK = pushed_point(tension_max=4000, duration=0.5, time=0.1)
VIEWPORT = '<meta name="viewport" content="width=device-width, initial-scale=1">'


def run_of(name, folder, **overrides):
    path = folder / "report.html"
    write_report(cdpr.simulate(name, overrides={"simulation.duration": 0.5, **overrides}), path)
    return path


def slack_run(folder):
    (folder / "slack.yaml").write_text(SLACK)
    return run_of(folder / "slack.yaml", folder)


def odd_run(case, folder):
    path = folder / "report.html"
    write_report(CASES[case](), path)
    return path


def comparison(options, folder):
    cdpr_here("compare", "caroca", "--set", BRIEF, "--out", folder / "out", *options)
    return folder / "out" / "compare.html"


def comparison_of_runs(options, folder):
    for name, more in (("one", ()), ("other", options)):
        cdpr_here("run", "caroca", "--set", BRIEF, "--out", folder / name, *more)
    cdpr_here("view", folder / "one", folder / "other", "--no-open", "--out", folder / "page.html", "--force")
    return folder / "page.html"


def look(what, folder):
    cdpr_here("view", what, "--no-open", "--out", folder / "page.html", "--force")
    return folder / "page.html"


def study(axes, folder):
    results = run_study(load_study(write_study(folder, axes)), folder / "out")
    write_study_page(results, folder / "study.html")
    return folder / "study.html"


def design(goals, folder):
    write_design(run_design(design_of(folder, BOX + goals), folder / "out"), folder / "report.html")
    return folder / "report.html"


def sizing(options, folder):
    cdpr_here("size", "caroca", *options, "--out", folder / "size.html")
    return folder / "size.html"


def bench(folder):
    options = ("--poses", "10", "--adversaries", "0", "--out", folder / "out")
    cdpr_here("bench", "solvers", "caroca", "planar", *options)
    return folder / "out" / "bench.html"


def space(kind, robot, folder, **options):
    loaded = cdpr.load_robot(ROBOTS / f"{robot}.yaml")
    found = workspace(loaded, kind, region(loaded, cells=8), **options)
    (folder / "w.html").write_text(render_workspace(found, loaded))
    return folder / "w.html"


def asked_space(kind, robot, options, folder):
    cdpr_here("workspace", kind, ROBOTS / f"{robot}.yaml", "--cells", "8", *options, "--out", folder / "w.npz")
    cdpr_here("workspace", "plot", folder / "w.npz", "--out", folder / "w.html")
    return folder / "w.html"


def cell_of_notebook(what, folder):
    """The page within the frame that a notebook shows."""
    (document,) = re.findall(r'srcdoc="([^"]*)"', what()._repr_html_())
    (folder / "cell.html").write_text(f"{unescape(document)}{VIEWPORT}")
    return folder / "cell.html"


def tensions(folder):
    cdpr_here("tension", "caroca", "--solver", "all", "--out", folder)
    (folder / "page.html").write_text(f"<!DOCTYPE html>{VIEWPORT}<img src='tension.svg' style='max-width: 100%'>")
    return folder / "page.html"


KINDS = {
    "run": partial(run_of, "caroca"),
    "run planar": partial(run_of, "planar"),
    "run point mass": partial(run_of, "point_mass"),
    "run spherical": partial(run_of, "spherical"),
    "run winches": partial(run_of, "winch"),
    "run pulleys": partial(run_of, "cogiro_pulleys"),
    "run with an event": partial(run_of, "cable_break", **{"simulation.duration": 1.2}),
    "run slack": slack_run,
    "run with wrenches": partial(run_of, "external_wrench"),
    **{f"run {case}": partial(odd_run, case) for case in CASES},
    "compare 2 engines": partial(comparison, ("--backends", "reference,mujoco")),
    "compare 4 engines": partial(comparison, ("--backends", "reference,mujoco,bullet,dart")),
    "compare 2 solvers": partial(comparison, ("--backends", "reference,mujoco", "--solvers", "qp,lp")),
    "compare orders": partial(comparison, ("--backends", "reference,mujoco", "--refine")),
    "runs of 2 engines": partial(comparison_of_runs, ("--backend", "mujoco")),
    "runs of 2 solvers": partial(comparison_of_runs, ("--solver", "lp")),
    "robot": partial(look, ROBOTS / "cogiro.yaml"),
    "robot planar": partial(look, ROBOTS / "planar.yaml"),
    "robot twelve": partial(look, ROBOTS / "twelve.yaml"),
    "motion": partial(look, "caroca"),
    "study 1 axis": partial(study, ONE_AXIS),
    "study 2 axes": partial(study, TWO_AXES),
    "study 3 axes": partial(study, THREE_AXES),
    "study 4 axes": partial(study, FOUR_AXES),
    "design 1 goal": partial(design, ONE),
    "design 2 goals": partial(design, TWO),
    "sizing": partial(sizing, ()),
    "sizing broken": partial(sizing, ("--broken", "--wrench-box", "10,10,10,1,1,1", "--cells", "3")),
    "bench": bench,
    "workspace static": partial(space, "static", "caroca"),
    "workspace payload": partial(space, "payload", "caroca"),
    "workspace closure": partial(space, "closure", "crossed"),
    "workspace dexterity": partial(space, "dexterity", "planar"),
    "workspace stable": partial(space, "stable", "caroca"),
    "workspace stiffness": partial(asked_space, "stiffness", "caroca_winches", ()),
    "workspace frequency": partial(asked_space, "frequency", "caroca_winches", ()),
    "workspace ifcow": partial(asked_space, "ifcow", "crossed", ("--set", "cable.diameter=0.01")),
    "workspace dynamic": partial(asked_space, "dynamic", "cogiro", ("--acceleration-box", "1,1,1,0,0,0")),
    "workspace wrench-feasible": partial(asked_space, "wrench-feasible", "caroca", ("--wrench-box", "50,50,50,5,5,5")),
    "workspace certify": partial(asked_space, "static", "planar", ("--method", "certify")),
    "workspace hull": partial(asked_space, "static", "cogiro", ("--method", "hull", "--rays", "100")),
    "workspace turns": partial(asked_space, "static", "caroca", ("--method", "turns")),
    "notebook run": partial(cell_of_notebook, lambda: cdpr.simulate("caroca", overrides={"simulation.duration": 0.5})),
    "notebook robot": partial(cell_of_notebook, lambda: cdpr.load_robot(ROBOTS / "cogiro.yaml")),
    "notebook scenario": partial(cell_of_notebook, lambda: cdpr.load_scenario("caroca")),
    "tension": tensions,
}

# One of each kind; the others are slow.
FEW = ("run", "run infeasible", "compare 4 engines", "runs of 2 solvers", "robot planar", "motion", "study 2 axes",
       "design 2 goals", "sizing", "workspace static")  # fmt: skip

PARAMETERS = [pytest.param(name, id=name, marks=() if name in FEW else pytest.mark.slow) for name in KINDS]
