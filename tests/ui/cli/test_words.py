"""Messages of the command line about suspicious input, or input in the form of other countries and programs."""

from __future__ import annotations

import json
import math
import re
import shutil
from dataclasses import replace

import click
import pytest
from click.testing import CliRunner
from command_line import cdpr_here
from conftest import ROOT

from cdpr.base.errors import ScenarioError
from cdpr.mechanics.restraint import few_cables
from cdpr.scenario import load_robot, load_scenario
from cdpr.scenario.plausible.angles import in_degrees
from cdpr.ui.cli import cli
from cdpr.ui.cli.numbers import AnyReal, AnyWhole, Real, Whole

SCENARIOS = ROOT / "scenarios"
CAROCA = SCENARIOS / "caroca.yaml"
PLANAR = SCENARIOS / "planar.yaml"

OUTS = {
    "run": (CAROCA,),
    "compare": (CAROCA,),
    "study": (SCENARIOS / "studies",),
    "info": (CAROCA,),
    "tension": (CAROCA,),
    "export": ("runs", "--to", "csv"),
    "baseline save": (CAROCA,),
    "bench solvers": (),
    "fmu export": (CAROCA,),
}


def notes(changes, path=CAROCA):
    return [f"warning: {row}" for row in load_scenario(path, overrides=changes).warnings]


@pytest.mark.parametrize("command", OUTS)
def test_an_empty_name_of_results_is_refused(command, tmp_path):
    done = cdpr_here(*command.split(), *OUTS[command], "--out", "", cwd=tmp_path, code=2)
    assert done.stderr.count("expected a name, got an empty one") == 1
    assert "--out" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("value", ["1,5", "-1,5", "1,5e3"])
def test_a_decimal_comma_is_reported_with_the_correct_form(value):
    meant = value.replace(",", ".")
    with pytest.raises(
        ScenarioError, match=rf"mass: expected a number \(kg\), got '{value}'; write {meant}, with a point"
    ):
        load_scenario(CAROCA, overrides=[f"robot.platform.mass={value}"])
    for other in ("robot.platform.mass=a,5", f"robot.platform.center_of_mass={value}"):
        with pytest.raises(ScenarioError, match=r"expected .*, got '[^']*'$"):
            load_scenario(CAROCA, overrides=[other])


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("initial.orientation", {"rpy": [0, 0, 90]}),
        ("initial.orientation", {"euler": {"angles": [-90, 0, 0], "order": "XYZ"}}),
        ("trajectory.to.orientation", {"rpy": [0, 45, 0]}),
        ("robot.home", {"position": [0, 0, 1], "orientation": {"rpy": [180, 0, 0]}}),
        ("events", [{"type": "sine", "time": 0, "force": [1, 0, 0], "frequency": 1, "phase": 90}]),
    ],
)
def test_degrees_are_reported(key, value):
    note, *_ = notes({key: value})  # so turned, cables may touch besides
    assert note.startswith("warning: ")
    assert key in note
    assert re.search(
        r"-?\d+ rad is more than a whole turn; angles are in radians: -?\d+ degrees are -?\d\.\d+ rad", note
    )


@pytest.mark.parametrize(
    "changes",
    [
        {"initial.orientation": {"rpy": [0, -6.28319, 6.283185307179586]}},
        {"initial.orientation": {"quaternion": [1, 0, 0, 0]}},
        {"trajectory": {"type": "circle", "center": [0, 0, 1.2], "duration": 4, "turns": 40.0}},
        {"initial.angular_velocity": [0, 0, 20.0]},
    ],
)
def test_several_turns_are_not_reported(changes):
    if "trajectory" in changes:
        changes = changes | {"initial.position": [0.3, 0, 1.2]}
    assert notes(changes) == []


def test_a_copy_that_is_right_is_not_warned_of():
    wrong = load_scenario(CAROCA, overrides={"initial.orientation": {"rpy": [0, 0, 90]}})
    assert len(wrong.warnings) == len(wrong.with_changes({"simulation.seed": 1}).warnings) == 1
    assert wrong.with_changes({"initial.orientation.rpy": [0, 0, math.pi]}).warnings == ()


def test_commands_print_degrees(tmp_path):
    robot = tmp_path / "robot.yaml"
    text = (SCENARIOS / "robots" / "caroca.yaml").read_text()
    robot.write_text(
        re.sub(r"(?m)^home:.*\n", "", text) + "\nhome: {position: [0, 0, 1], orientation: {rpy: [0, 0, 90]}}\n"
    )
    line = len(robot.read_text().splitlines())
    for command in ("validate", "info"):
        said = cdpr_here(command, robot).stderr
        assert re.search(rf"warning: \S*robot.yaml:{line}:\d+: home.orientation.rpy: 90 rad is more than a whole", said)
    assert "warning: --pose: 30 rad is more" in cdpr_here("info", robot, "--pose", "0,0,1,0,0,30").stderr
    assert in_degrees([0.0, math.nan, "x"]) == ""  # other checks report these


HELD = [
    (PLANAR, {"force": [0, 5, 0]}, "acts along y only"),
    (PLANAR, {"moment": [1, 0, 2]}, "acts along rx, rz only"),
    (PLANAR, {"force": [0, 5, 1]}, None),
    (PLANAR, {"moment": [1, 1, 2]}, None),
    (PLANAR, {"force": [0, 0, 0]}, None),
    (SCENARIOS / "spherical.yaml", {"force": [0, 0, 9]}, "acts along z only"),
    (CAROCA, {"force": [0, 5, 0]}, None),
]


@pytest.mark.parametrize(("path", "load_", "told"), HELD)
def test_a_wrench_that_the_guide_takes_is_reported(path, load_, told):
    found = notes({"events": [{"type": "wrench", "time": 0.0, **load_}]}, path)
    assert len(found) == (told is not None)
    if told:
        assert found[0].startswith("warning: ")
        assert f"events[0]: {told}, where the guide holds the platform: it has no effect" in found[0]


def test_the_guide_takes_it_indeed():
    from cdpr import simulate

    base = {"simulation.duration": 0.05}
    plain = simulate(PLANAR, overrides=base)
    pushed = simulate(PLANAR, overrides=base | {"events": [{"type": "wrench", "time": 0.0, "force": [0, 500, 0]}]})
    assert plain.position.tobytes() == pushed.position.tobytes()


def test_robots_with_few_cables_are_reported():
    robot = load_robot(SCENARIOS / "robots" / "planar.yaml")
    assert few_cables(robot) == ""
    three, two = (replace(robot, cables=robot.cables[:m]) for m in (3, 2))
    assert few_cables(three).startswith("3 cables for 3 degrees of freedom: cables only pull, so to hold any wrench")
    assert few_cables(two).startswith("2 cables for 3 degrees of freedom: at any pose some motion meets no resistance")
    assert few_cables(replace(three, unilateral=False)) == ""
    assert few_cables(replace(two, unilateral=False)).startswith("2 legs for 3")
    name = SCENARIOS / "robots" / "point_mass.yaml"
    done = cdpr_here("validate", name, "--json")
    assert json.loads(done.stdout)[0]["notes"] == done.stderr.splitlines()
    assert "note: 3 cables for 3 degrees of freedom" in done.stderr
    assert "3 cables for 3 degrees of freedom: cables only pull" in cdpr_here("info", name).stdout


def test_a_mistake_in_a_robot_file_is_reported_once(tmp_path):
    (tmp_path / "robots").mkdir()
    for name in ("caroca.yaml", "robots/caroca.yaml"):
        shutil.copy(SCENARIOS / name, tmp_path / name)
    text = (tmp_path / "caroca.yaml").read_text()
    (tmp_path / "other.yaml").write_text(text.replace("robots/caroca.yaml", "robots/../robots/caroca.yaml"))
    assert "robots/../" in (tmp_path / "other.yaml").read_text()
    robot = tmp_path / "robots" / "caroca.yaml"
    robot.write_text(re.sub(r"mass: \d+", "mass: -1", robot.read_text()))
    files = ("caroca.yaml", "robots/caroca.yaml", "other.yaml")
    said = cdpr_here("validate", *files, cwd=tmp_path, code=2).stderr.splitlines()
    assert sum("mass: must be greater than 0" in line for line in said) == 1
    assert said[1:] == [f"{name}: 1 problem, reported above" for name in files[1:]]
    rows = json.loads(cdpr_here("validate", *files, "--json", cwd=tmp_path, code=2).stdout)
    assert [len(row["problems"]) for row in rows] == [1, 1, 1]  # each file has its own


def test_an_inertia_without_value_is_reported_once():
    with pytest.raises(ScenarioError) as caught:
        load_scenario(CAROCA, overrides={"robot.platform.inertia": None})
    (line,) = caught.value.problems
    assert "no value is given" in line


def test_file_names_after_set_start_at_the_scenario(tmp_path):
    assert cdpr_here("validate", CAROCA, "--set", "robot=robots/nine.yaml", cwd=tmp_path).stdout.count("9 cables")
    for command in ("run", "validate", "compare"):
        assert "are relative to the folder of the file" in " ".join(cdpr_here(command, "--help").stdout.split())


@pytest.mark.parametrize(
    "typed",
    [
        ("new", "robot", "-", "--frame", "4_0,3,2"),
        ("new", "robot", "-", "--platform", "٤,3,2"),
        ("new", "robot", "-", "--mass", "1_0"),
        ("new", "robot", "-", "--cables", "0_8"),
        ("info", str(CAROCA), "--pose", "0,0,1_0"),
    ],
)
def test_a_number_that_only_python_would_read_is_refused(typed):
    done = CliRunner().invoke(cli, typed)
    assert done.exit_code == 2
    assert repr(typed[-1]) in done.output


def options(command):
    for each in command.params:
        yield each.type
    for name in command.list_commands(None) if isinstance(command, click.Group) else ():
        yield from options(command.get_command(None, name))


def test_all_options_read_numbers_so():
    ranges = [kind for kind in options(cli) if isinstance(kind, click.types.IntParamType | click.types.FloatParamType)]
    assert len(ranges) > 8
    assert {type(kind) for kind in ranges} <= {AnyReal, AnyWhole, Real, Whole}
