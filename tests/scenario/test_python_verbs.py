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
    for name, file in {"../../x": "_.._x.xml", "/tmp/x": "_tmp_x.xml", "b" * 300: f"{'b' * 64}.xml"}.items():
        assert str(cdpr.export(built(name=name), "mjcf")) == file
    for name in ("\0", "a\ud800", "\x1b"):
        assert "XML cannot contain the character" in message(lambda name=name: cdpr.export(built(name=name), "urdf"))
    assert len(list(tmp_path.rglob("*"))) == 5
