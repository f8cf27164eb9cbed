"""Unknown keys, and keys at the wrong place: reported with a suggestion."""

from __future__ import annotations

import pytest
from conftest import ROOT
from scenario_cases import (
    BASE,
    changed,
    line_of,
    problem,
    problems,
)

from cdpr.base.errors import ScenarioError
from cdpr.config import describe
from cdpr.scenario import load_scenario

pytestmark = pytest.mark.core


@pytest.mark.parametrize(
    ("old", "new", "key", "what"),
    [
        (
            "mass:",
            "mas:",
            "robot.platform.mas",
            "unknown key 'mas': did you mean 'mass'? allowed: mass, inertia, center_of",
        ),
        (
            "seed:",
            "sead:",
            "simulation.sead",
            "did you mean 'seed'? allowed: backend, duration, control_step",
        ),
        ("speed_max:", "speed:", "robot.cables[0].speed", "did you mean 'speed_max'? allowed: name, frame"),
        (
            "infeasible:",
            "infeasable:",
            "solver.infeasable",
            "did you mean 'infeasible'? allowed: type, infeasible",
        ),
        ("kp:", "kpp:", "controller.kpp", "did you mean 'kp'? allowed: type, kp, kd, limit"),
        ("integrator:", "integ:", "backend_options.tuned.integ", "allowed: integrator, tolerance, label"),
        (
            "    acceleration: [0, 0, 0.5]",
            "    jerk: [0, 0, 0.5]",
            "trajectory.from.jerk",
            "allowed: position, orientation",
        ),
        ("  start: 0.5", "  points: []", "trajectory.points", "allowed: type, tool, start, duration, from, to"),
    ],
)
def test_unknown_keys(old, new, key, what):
    text = changed(BASE, old, new)
    lines = [line for line in problems(text) if "unknown key" in line]
    assert len(lines) == 1
    assert what in lines[0]
    assert f": {key}: " in lines[0]
    bare = new.strip()
    assert lines[0].startswith(f"a.yaml:{line_of(text, bare)}:")


@pytest.mark.parametrize(
    ("path", "data", "told"),
    [
        ("gravity", [0, 0, -9.81], "did you mean world.gravity, written world: {gravity: ...}? allowed: name,"),
        (
            "home.rpy_deg",
            [0, 0, 3],
            "did you mean orientation.rpy_deg, written orientation: {rpy_deg: ...}? all",
        ),
        ("duration", 3, "did you mean simulation.duration or trajectory.duration? allowed: name,"),
        ("kp", 3, "'kp': did you mean controller.kp, written controller: {kp: ...}? allowed: name,"),
        ("simulation.kp", 3, "'kp': did you mean controller.kp? allowed: backend,"),
        ("simulation.mass", 3, "'mass': did you mean robot.platform.mass or believed.platform.mass? allowed: backend,"),
        ("gains.kp", 3, "'gains': did you mean controller.kp? allowed: name,"),
        ("controller.gravity", 3, "'gravity': did you mean world.gravity? allowed: type, kp, kd"),
        ("trajectory.Start", 1, "did you mean 'start'? allowed: "),
        ("trajectory.dur", 1, "did you mean 'duration'? allowed: "),
    ],
)
def test_a_key_at_the_wrong_place_is_reported_with_its_place(path, data, told):
    path = path.replace("home", "robot.home")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(ROOT / "scenarios" / "caroca.yaml", overrides={path: data})
    assert told in str(caught.value)


def test_a_key_that_the_selected_plugin_lacks_is_not_suggested():
    """Only options of the selected solver are suggested: `classic` has no tolerance, and `highs` has one."""
    file = ROOT / "scenarios" / "caroca.yaml"
    for solver, places in (("classic", "trajectory.tolerance"), ("highs", "trajectory.tolerance or solver.tolerance")):
        with pytest.raises(ScenarioError, match=rf"did you mean {places}\?"):
            load_scenario(file, solver=solver, overrides={"controller.tolerance": 1.0})


def test_a_type_without_mapping_is_reported_with_the_correct_form():
    with pytest.raises(
        ScenarioError, match=r"solver: expected a mapping \(type, infeasible\), got 'qp'; write {type: qp}"
    ):
        load_scenario(ROOT / "scenarios" / "caroca.yaml", overrides={"solver": "qp"})


def test_unknown_keys_are_reported_also_for_plugins_without_options():
    text = changed(BASE, "{type: simple, ", "{type: simple, speed: 3, ")
    line = line_of(text, "speed: 3")
    column = text.splitlines()[line - 1].index("speed") + 1
    assert problem(text) == (f"a.yaml:{line}:{column}: solver.speed: unknown key 'speed': allowed: type, infeasible")


def test_sections_are_searched_once_for_many_unknown_keys(monkeypatch):
    searched = []
    levels = describe._levels
    monkeypatch.setattr(describe, "_levels", lambda *nodes: searched.append(nodes) or levels(*nodes))
    unknown = {"robot": {f"unknown{k}": k for k in range(30)}, **{f"unknown{k}": k for k in range(30)}}
    with pytest.raises(ScenarioError):
        load_scenario(unknown)
    assert len(searched) <= 2  # the file, unless an earlier test has searched it, and its robot
