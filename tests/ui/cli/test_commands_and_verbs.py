"""Commands and verbs of the Python interface: the same options and the same results."""

from __future__ import annotations

import importlib
import inspect
import json
import re

import click
import pytest
from command_line import cdpr_here
from conftest import ROOT

import cdpr
from cdpr.analysis.distribution.solvers import compare_solvers
from cdpr.analysis.workspace import box
from cdpr.analysis.workspace.kinds import KINDS
from cdpr.analysis.workspace.question import Question
from cdpr.ui.cli.workspace_kind import command_of

VERBS = {"size": "size", "tension": "distribute", "design": "design", "study": "study", "compare": "compare"}
ROW = re.compile(r"^\| (all|`cdpr (\w+)`) \| ((?:`--[\w-]+`(?:, )?)+) \| (.*) \|$", re.MULTILINE)


def documented():
    """Return the Python route of each option in the table of docs/python.md, by command and option."""
    text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    return {
        (command or "", option): route
        for _, command, options, route in ROW.findall(text)
        for option in re.findall(r"--[\w-]+", options)
    }


def options_of(command):
    return [each.opts[0] for each in command.params if isinstance(each, click.Option)]


def commands():
    """Return each command with its verb."""
    found = [(name, importlib.import_module(f"cdpr.ui.cli.{name}").command, VERBS[name]) for name in VERBS]
    return found + [("workspace", command_of(kind, "text"), "workspace") for kind in KINDS]


@pytest.mark.parametrize(("name", "command", "verb"), commands(), ids=lambda value: getattr(value, "name", ""))
def test_each_option_has_an_argument_or_a_documented_route(name, command, verb):
    known, arguments = documented(), set(inspect.signature(getattr(cdpr, verb)).parameters)
    if verb == "workspace":
        arguments |= set(Question.__dataclass_fields__)
    for option in options_of(command):
        route = known.get((name, option)) or known.get(("", option))
        if route is None:
            assert option[2:].replace("-", "_") in arguments, f"cdpr {name} {option}"
        elif (argument := re.match(r"`(\w+)=", route)) and option != "--set":
            assert argument[1] in arguments, route


def test_the_table_has_no_other_options():
    all_options = {(name, option) for name, command, _ in commands() for option in options_of(command)}
    all_options |= {("", option) for _, option in all_options}
    assert set(documented()) <= all_options
    assert len(documented()) > 20


@pytest.mark.slow  # imports the drawings
def test_names_in_the_table_exist():
    for route in documented().values():
        for name in re.findall(r"`(cdpr\.[\w.]+)", route):
            module, _, attribute = name.rpartition(".")
            owner = cdpr.plugins.registry if module == "cdpr.plugins.registry" else importlib.import_module(module)
            assert hasattr(owner, attribute), name


def of_command(*words, code=0, cwd="."):
    return json.loads(cdpr_here(*words, "--json", code=code, cwd=cwd).stdout)


def plain(value):
    return json.loads(json.dumps(value))


SHORT = ("--set", "simulation.duration=0.02")
BRIEF = {"simulation.duration": 0.02}


def test_size():
    wrenches = ("--wrench-box", "50,50,50,5,5,5", "--lower", "-1,-1,1", "--upper", "1,1,2", "--cells", "2,1,1")
    calls = []
    verb = cdpr.size(
        "planar",
        safety=4.0,
        broken=True,
        required=box([50, 0, 50, 0, 5, 0]),
        lower=[-1, -1, 1],
        upper=[1, 1, 2],
        cells=[2, 1, 1],
        overrides=BRIEF,
        progress=lambda done, total: calls.append((done, total)),
    )
    wrenches = ("--wrench-box", "50,0,50,0,5,0", *wrenches[2:])
    assert of_command("size", "planar", "--safety", 4, "--broken", *wrenches, *SHORT) == plain(verb.to_dict())
    assert [part[0] for part in verb.parts][:2] == ["planar", "workspace"]
    assert calls[0] == (1, 2)
    assert calls[-1] == (len(verb.parts), len(verb.parts)) == (10, 10)


def test_wrong_wrenches_of_size():
    for given, text in (
        ({"cells": 3}, "size(region=, lower=, upper=, cells=): only with required=, the wrenches"),
        ({"required": [1, 2]}, "size(required=): expected a cdpr.analysis.workspace.Required, got a list"),
        ({"required": box([1] * 6), "region": 3}, "size(region=): expected a cdpr.analysis.workspace.Region, got 3"),
    ):
        with pytest.raises(cdpr.CdprError) as caught:
            cdpr.size("planar", overrides=BRIEF, **given)
        assert text in str(caught.value)


def untimed(figures):
    for answer in figures["solvers"]:
        del answer["time_us"]
    return figures


SOLVERS = ["qp", "lp", "centroid", "pseudo_inverse"]


def test_tension():
    changes = {"solver": {"type": "qp", "about": "middle"}}
    scenario = cdpr.load_scenario("caroca", overrides=changes)
    command = of_command(
        "tension", "caroca", "--solver", ",".join(SOLVERS), "--set", "solver={type: qp, about: middle}"
    )
    assert untimed(command) == untimed(compare_solvers(scenario, solvers=SOLVERS))
    for answer in command["solvers"]:
        found = cdpr.distribute(scenario, scenario.initial.state()[:7], solver=answer["solver"])
        assert answer["admissible"] == bool(found.feasible)
        if answer["admissible"]:
            assert found.tension == pytest.approx(answer["tension_N"], rel=1e-12)


def test_distribute_uses_the_options_of_the_scenarios_solver_unless_others_are_given():
    scenario = cdpr.load_scenario("caroca", overrides={"solver": {"type": "qp", "about": "middle"}})
    robot, pose = scenario.robot, scenario.initial.state()[:7]
    own, middle = cdpr.distribute(scenario, pose), cdpr.distribute(robot, pose, options={"about": "middle"})
    assert own.tension.tolist() == middle.tension.tolist()
    assert cdpr.distribute(scenario, pose, options={}).tension.tolist() == cdpr.distribute(robot, pose).tension.tolist()
    assert own.tension.tolist() != cdpr.distribute(robot, pose).tension.tolist()


@pytest.mark.parametrize("kind", ["static", "ifcow"])
def test_workspace(kind):
    more = () if kind == "static" else ("--cable-diameter", "0.01")
    file = ROOT / "scenarios" / "caroca.yaml"
    verb = cdpr.workspace(file, kind, cells=4, **({"diameter": 0.01} if more else {}))
    assert of_command("workspace", kind, file, "--cells", 4, *more) == plain(verb.summary())


def test_design(tmp_path):
    command = of_command("design", "design_box", "--evaluations", 1, "--no-report", "--out", tmp_path / "a")
    verb = cdpr.design("design_box", tmp_path / "b", evaluations=1)
    assert command.pop("folder") == str(tmp_path / "a")
    assert command == plain(verb.to_dict())


STUDY = "{scenario: planar, axes: [{key: controller.kp, values: [50]}]}"


@pytest.mark.slow
def test_study(tmp_path):
    (tmp_path / "study.yaml").write_text(STUDY, encoding="utf-8")
    words = ("study", tmp_path / "study.yaml", "--no-report", "--jobs", 1, *SHORT, "--out")
    command = of_command(*words, tmp_path / "a")
    verb = cdpr.study(tmp_path / "study.yaml", tmp_path / "b", overrides=BRIEF)
    assert command["cases"] == plain(verb.table.records())
    assert command["counts"] == verb.counts


@pytest.mark.slow
def test_compare():
    words = ("compare", "remote_plant", *SHORT, "--backends", "remote", "--jobs", 1)
    verb = cdpr.compare("remote_plant", overrides=BRIEF, backends=["remote"], jobs=1)
    command, figures = of_command(*words, code=7), plain(verb.figures)
    assert {key: command[key] for key in command if key != "groups"} == {
        key: figures[key] for key in figures if key != "groups"
    }
