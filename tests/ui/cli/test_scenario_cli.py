"""`cdpr validate` and `cdpr schema`."""

from __future__ import annotations

import json
import shutil

import pytest
from click.testing import CliRunner
from conftest import ROOT

from cdpr.scenario.json_schema import robot_schema, scenario_schema
from cdpr.ui.cli.schema import command as schema
from cdpr.ui.cli.validate import command as validate

SCENARIOS = ROOT / "scenarios"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    shutil.copytree(SCENARIOS, tmp_path / "scenarios")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(command, *arguments):
    return CliRunner().invoke(command, arguments, catch_exceptions=False)


def break_file(folder, old="mass: 150", new="mass: -5"):
    path = folder / "scenarios" / "robots" / "caroca.yaml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_good_files(folder):
    result = run(validate, "scenarios/caroca.yaml", "scenarios/robots/caroca.yaml")
    assert result.exit_code == 0
    assert result.stdout == (
        "scenarios/caroca.yaml: ok (scenario, 8 cables, 4 s)\nscenarios/robots/caroca.yaml: ok (robot, 8 cables)\n"
    )
    assert result.stderr == ""


def test_unused_keys_are_listed():
    idle = "robot.winch={type: position, drum_radius: 0.05, velocity_gain: 3}"  # a gain without an inertia
    result = run(validate, str(ROOT / "scenarios" / "camera_robot.yaml"), "--set", idle)
    assert result.stdout.splitlines()[1:] == ["  not used by a run: robot.winch.velocity_gain"]


def test_all_files_are_checked_though_one_is_bad(folder):
    break_file(folder)
    result = run(validate, "scenarios/caroca.yaml", "nothing.yaml", "scenarios/winch.yaml")
    assert result.exit_code == 2
    assert result.stdout == "scenarios/winch.yaml: ok (scenario, 8 cables, 4 s)\n"
    mass, missing = result.stderr.splitlines()
    assert mass.startswith("scenarios/robots/caroca.yaml:")
    assert mass.endswith(":9: robot.platform.mass: must be greater than 0 (kg), got -5")
    assert missing.startswith("nothing.yaml: there is no file 'nothing.yaml'")


def test_json(folder):
    break_file(folder)
    result = run(validate, "--json", "scenarios/winch.yaml", "scenarios/robots/thesis.yaml", "scenarios/caroca.yaml")
    assert result.exit_code == 2
    good, robot, bad = json.loads(result.stdout)
    assert good == {
        "file": "scenarios/winch.yaml",
        "ok": True,
        "kind": "scenario",
        "name": "winch",
        "cables": 8,
        "duration": 4.0,
        "unused": [],
        "notes": [],
        "warnings": [],
        "closed_loop": "stable",
    }
    assert (robot["kind"], robot["cables"]) == ("robot", 8)
    assert bad["ok"] is False
    assert bad["problems"] == result.stderr.splitlines()
    (row,) = bad["rows"]
    assert (row["source"], row["key"]) == ("scenarios/robots/caroca.yaml", "robot.platform.mass")
    assert row["text"].startswith("must be greater than 0 (kg)")


def test_set(folder):
    result = run(validate, "--set", "simulation.duration=2", "scenarios/caroca.yaml")
    assert result.stdout == "scenarios/caroca.yaml: ok (scenario, 8 cables, 2 s)\n"
    result = run(validate, "--set", "simulation.duration=abc", "scenarios/caroca.yaml")
    assert result.exit_code == 2
    assert result.stderr == "--set simulation.duration=abc: simulation.duration: expected a number (s), got 'abc'\n"
    result = run(validate, "--set", "platform.mass=-1", "scenarios/robots/caroca.yaml")
    assert result.stderr.startswith("--set platform.mass=-1: platform.mass: must be greater than 0")


def test_poles_that_are_not_computed_are_a_note(folder):
    reason = "800 commands wait in the drives: expected at most 64"
    result = run(validate, "--set", "drives.delay=0.1", "scenarios/caroca.yaml")
    assert result.exit_code == 0
    assert result.stderr == f"scenarios/caroca.yaml: note: poles of the closed loop not computed: {reason}\n"
    result = run(validate, "--strict", "--json", "--set", "drives.delay=0.1", "scenarios/caroca.yaml")
    assert result.exit_code == 0  # no warning
    (row,) = json.loads(result.stdout)
    assert row["closed_loop"] == f"not computed: {reason}"
    assert [note.partition("note: ")[2] for note in row["notes"]] == [
        f"poles of the closed loop not computed: {reason}"
    ]


@pytest.mark.parametrize("name", ["remote_controller", "remote_plant", "winch_fmu"])
def test_parts_without_known_poles_are_no_note(name):
    (row,) = json.loads(run(validate, "--json", str(SCENARIOS / f"{name}.yaml")).stdout)
    assert row["closed_loop"].startswith("not computed: ")
    assert not any("poles" in note for note in row["notes"])


def test_a_missing_plugin_alone_has_its_own_code(folder):
    arguments = ["scenarios/caroca.yaml", "--set", "simulation.backend=bullet_train"]
    assert run(validate, *arguments).exit_code == 3
    assert run(validate, *arguments, "nothing.yaml").exit_code == 2


def test_no_files_is_a_mistake_of_usage():
    assert run(validate).exit_code == 2


def test_schemas():
    by_default = run(schema).stdout
    assert json.loads(by_default) == scenario_schema()
    assert run(schema, "scenario").stdout == by_default
    assert json.loads(run(schema, "robot").stdout) == robot_schema()
    assert run(schema, "world").exit_code == 2
