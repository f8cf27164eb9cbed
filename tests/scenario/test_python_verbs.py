"""Verbs of the Python interface with wrong arguments: names of files, objects in the wrong place, unusable names."""

from __future__ import annotations

import pytest

import cdpr

pytestmark = pytest.mark.core

LONG = "a" * 5000


def built(**changes):
    return cdpr.load_robot("caroca").replace(**changes)


def scenario():
    return cdpr.Scenario(robot=built(), simulation={"duration": 0.02})


def message(make):
    with pytest.raises(cdpr.CdprError) as caught:
        make()
    return str(caught.value)


@pytest.mark.parametrize("name", ["a\0", "a\ud800", 3, None, b"a", LONG])
@pytest.mark.parametrize("verb", ["mjcf", "native", "ros2", "csv", "view", "robot", "scenario", "simulate"])
def test_wrong_names_of_files_to_write(verb, name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if name is None and verb in ("mjcf", "native", "ros2", "csv", "view", "simulate"):
        return  # the default
    run = cdpr.simulate(scenario()) if verb == "csv" else None

    def with_ending(ending):
        return f"{name}{ending}" if isinstance(name, str) else name

    calls = {
        "mjcf": lambda: cdpr.export(built(), "mjcf", name),
        "native": lambda: cdpr.export(scenario(), "native", name),
        "ros2": lambda: cdpr.export(scenario(), "ros2", name),
        "csv": lambda: cdpr.export(run, "csv", name),
        "view": lambda: cdpr.view(built(), with_ending(".html")),
        "robot": lambda: built().save(with_ending(".yaml")),
        "scenario": lambda: scenario().save(with_ending(".yaml")),
        "simulate": lambda: cdpr.simulate(scenario(), out=name),
    }
    text = message(calls[verb])
    assert ("File name too long" if name == LONG else "expected the name of a ") in text
    assert not list(tmp_path.iterdir())


WRONG = {
    "[0]: expected the folder of a finished run, or its log, got a Scenario": [
        lambda: cdpr.compare([scenario(), scenario()]),
        lambda: cdpr.view([scenario(), scenario()], "x.html"),
    ],
    "[1]: expected the folder of a finished run, or its log, got null": [lambda: cdpr.compare(["a", None])],
    "[0]: expected the folder of a finished run, or its log, got 'a\\x00'": [lambda: cdpr.compare(["a\0", "b"])],
    "expected a file, an example's name, a dict or a Scenario, got a bytes": [lambda: cdpr.compare(b"ab")],
    "compare(backends=): expected a list of names, got 3": [lambda: cdpr.compare("caroca", backends=3)],
    "compare(solvers=): expected a list of names, got 'qp'": [lambda: cdpr.compare("caroca", solvers="qp")],
    "safety: expected a number from 1 on, got 'a'": [lambda: cdpr.size("caroca", safety="a")],
    "expected a file, an example's name or a dict, got a Scenario; cdpr.study({": [
        lambda: cdpr.study(scenario(), "out"),
    ],
    "expected a file, an example's name or a dict, got a Robot; cdpr.design({": [lambda: cdpr.design(built(), "out")],
    "expected a file, an example's name, a dict or a Robot, got a Scenario; use scenario.robot": [
        lambda: cdpr.load_robot(scenario())
    ],
    "cables: required but not given": [lambda: cdpr.distribute({}, [0, 0, 0]), lambda: cdpr.workspace({}, "static")],
    "aaaaaaaa": [lambda: cdpr.export(LONG, "csv", "v.csv"), lambda: cdpr.load_run(LONG)],
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_arguments(text):
    for call in WRONG[text]:
        assert message(call).startswith(text)


def test_names_of_robots_are_no_paths(tmp_path, monkeypatch):
    (tmp_path / "deep" / "down").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "deep" / "down")
    for name in ("../../x", "/tmp/x", "b" * 300, "\0", "a\ud800", "\x1b"):
        assert "name: expected a " in message(lambda name=name: cdpr.export(built(name=name), "mjcf"))
    assert len(list(tmp_path.rglob("*"))) == 2


def test_parts_that_an_export_omits_are_warned_about(tmp_path):
    with pytest.warns(UserWarning, match="left out: events: not exported \\(cable_break at 1 s\\)"):
        cdpr.export("cable_break", "urdf", tmp_path / "a.urdf")


def test_options_that_do_not_apply_to_runs_are_rejected(tmp_path):
    run = cdpr.simulate("caroca", overrides={"simulation.duration": 0.01})
    with pytest.raises(cdpr.CdprError, match=r"^size\(overrides=\): applies to scenarios"):
        cdpr.size(run, overrides={"robot.platform.mass": 99.0})
    for options in ({"refine": True}, {"jobs": 2}, {"timeout": 1.0}, {"backends": []}):
        with pytest.raises(cdpr.CdprError, match=r"^compare\(\w+=\): applies to a scenario"):
            cdpr.compare([tmp_path, tmp_path], **options)


def test_a_block_with_a_file_of_the_name_of_a_given_scenario_reads_the_file(tmp_path):
    heavy = cdpr.load_scenario("planar", overrides={"robot.platform.mass": 77.0, "simulation.duration": 0.01})
    blocks = [{"name": "a"}, {"name": "b", "scenario": "planar"}]
    plan = cdpr.analysis.study.load_study({"scenario": heavy, "blocks": blocks, "name": "two"})
    assert [grid.scenario.robot.platform.mass for grid in plan.blocks] == [
        77.0,
        cdpr.load_robot("planar").platform.mass,
    ]
