"""The desk: opening, editing, undoing, and the scenario that comes of it."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from desk_cases import SCENARIOS, caroca_in

from cdpr.base.errors import CdprError, ScenarioError
from cdpr.scenario import load_scenario
from cdpr.scenario.choices import typed
from cdpr.ui.gui.desk import Editor


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return caroca_in(tmp_path)


def test_an_edit_of_the_robot_goes_into_its_file_and_only_when_saved(folder: Path) -> None:
    desk = Editor(str(folder / "caroca.yaml"))
    robot = folder / "robots/caroca.yaml"
    before = robot.read_text()
    desk.edit("robot.platform.mass", 123.5)
    assert desk.form()["modified"]
    assert desk.scenario().robot.platform.mass == 123.5
    assert robot.read_text() == before
    assert desk.save() == [str(robot)]
    assert robot.read_text() == before.replace("mass: 150 ", "mass: 123.5 ")
    assert not desk.form()["modified"]
    assert load_scenario(folder / "caroca.yaml") == desk.scenario()


def test_a_bad_value_stays_with_its_problem_under_its_field(folder: Path) -> None:
    desk = Editor(str(folder / "caroca.yaml"))
    desk.edit("robot.platform.mass", "25 kg")
    form = desk.form()
    (problem,) = form["problems"]
    assert problem["path"] == "robot.platform.mass"
    assert problem["place"].endswith("robots/caroca.yaml:7")
    assert "write 25, without the unit" in problem["text"]
    with pytest.raises(ScenarioError, match="write 25"):
        desk.scenario()
    desk.edit("robot.platform.mass", 25)
    assert desk.scenario().robot.platform.mass == 25


def test_undo_and_redo_and_revert(folder: Path) -> None:
    desk = Editor(str(folder / "caroca.yaml"))
    first = desk.texts()
    desk.edit("controller.kp", 120)
    desk.edit("robot.platform.mass", 140)
    changed = desk.texts()
    assert desk.form()["undo"] == "robot.platform.mass = 140"
    desk.undo()
    desk.undo()
    assert desk.texts() == first
    with pytest.raises(CdprError, match="nothing more to undo"):
        desk.undo()
    desk.redo()
    desk.redo()
    assert desk.texts() == changed
    desk.revert()
    assert desk.texts() == first
    assert not desk.form()["modified"]
    desk.undo()
    assert desk.texts() == changed


def test_choices_of_the_command_line_are_edits_that_are_not_saved(folder: Path) -> None:
    chosen = {"backend": "mujoco", "solver": None, "controller": "pid"}
    desk = Editor(str(folder / "caroca.yaml"), typed(chosen, ["simulation.duration=2"]))
    scenario = desk.scenario()
    assert scenario.simulation.backend == "mujoco"
    assert scenario.simulation.duration == 2
    assert scenario.controller.type == "pid"
    assert scenario.controller_options.kp == 100  # type: ignore[attr-defined]
    assert desk.form()["modified"]
    assert (folder / "caroca.yaml").read_text() == (SCENARIOS / "caroca.yaml").read_text()


def test_what_cannot_be_written_is_refused_and_all_is_as_before(folder: Path) -> None:
    desk = Editor(str(folder / "caroca.yaml"))
    before = desk.texts()
    for edit in (
        lambda: desk.edit("events[3].time", 1),
        lambda: desk.edit("robot.cables[9].frame", [0, 0, 0]),
        lambda: desk.edit("a b", 1),
        lambda: desk.edit("", 1),
        lambda: desk.edit("solver.type[2]", 1),
        lambda: desk.edit("solver.reference", "[1, "),
        lambda: desk.insert("simulation.duration", 1),
        lambda: desk.open("no_such_thing"),
        lambda: desk.open("gains"),  # a study
        lambda: desk.new("robot", masss=4),
        lambda: desk.new("study"),
        lambda: desk.new("scenario", robot="seven", mass=3),
        lambda: desk.new("robot", cables=float("inf")),
        lambda: desk.new("robot", frame=[1, 2]),
        lambda: desk.new("robot", frame=[1, float("nan"), 2]),
        lambda: desk.open(0),  # type: ignore[arg-type]
        lambda: desk.open("a\0b"),
        lambda: desk.new("robot", file="\ud800"),
        lambda: desk.new("robot", self=1),
        lambda: desk.new("robot", frame=[1e-300, 1, 1]),
        lambda: desk.save_as("\ud800"),
        lambda: desk.save_as(str(folder / ("x" * 300))),
        lambda: desk.edit(7, 1),  # type: ignore[arg-type]
        lambda: desk.edit("name", "\ud800"),
        lambda: desk.edit("name", 10**5000),
        lambda: desk.edit("name", [[[[]]]] * 70000),
        lambda: desk.save_as(""),
        lambda: desk.save_as("a\0b"),
        lambda: desk.save_as(str(folder / "caroca.yaml")),
        lambda: desk.save_as(str(folder / "caroca.yaml/x")),
        lambda: desk.redo(),
    ):
        with pytest.raises(CdprError):
            edit()
        assert desk.texts() == before
    assert sorted(path.name for path in folder.rglob("*")) == ["caroca.yaml", "caroca.yaml", "robots"]
    desk.edit("robot.platform.mass", 140)
    desk.undo()
    desk.remove("events")
    desk.remove("simulation.log")
    assert desk.texts() == before


def test_another_robot_file_can_be_named_and_taken_back(folder: Path) -> None:
    shutil.copy(SCENARIOS / "robots/seven.yaml", folder / "robots")
    desk = Editor(str(folder / "caroca.yaml"))
    desk.edit("robot", "robots/seven.yaml")
    assert desk.scenario().robot.m == 7
    assert desk.form()["files"] == [str(folder / "caroca.yaml"), str(folder / "robots/seven.yaml")]
    desk.edit("robot", "robots/eight.yaml")
    (problem,) = desk.form()["problems"]
    assert problem["path"] == "robot"
    desk.undo()
    desk.undo()
    assert desk.scenario().robot.m == 8


def test_a_cable_comes_and_goes_with_its_limits(folder: Path) -> None:
    desk = Editor(str(folder / "caroca.yaml"))
    desk.edit("robot.tension.min[2]", 60)
    assert desk.scenario().robot.tension_min.tolist() == [50, 50, 60, 50, 50, 50, 50, 50]
    desk.remove("robot.cables[1]")
    assert desk.scenario().robot.tension_min.tolist() == [50, 60, 50, 50, 50, 50, 50]
    desk.insert("robot.cables")
    assert desk.scenario().robot.m == 8


def test_what_was_edited_is_had_again_after_another_file(folder: Path) -> None:
    desk = Editor(str(folder / "caroca.yaml"))
    desk.edit("robot.platform.mass", 140)
    edited = desk.texts()
    desk.save_as(str(folder / "mine.yaml"))
    desk.open("seven")
    desk.edit("robot.platform.mass", 21)
    desk.new("robot")
    assert desk.form()["undo"] == "new robot"
    for _ in range(4):
        desk.undo()
    assert desk.texts() == edited
    assert desk.form()["files"][0] == str(folder / "caroca.yaml")
    assert desk.form()["modified"]
    for _ in range(3):
        desk.redo()
    assert desk.scenario().robot.platform.mass == 21


def test_applied_says_whether_what_runs_is_what_is_shown(folder: Path) -> None:
    desk = Editor(str(folder / "caroca.yaml"))
    assert not desk.form()["applied"]
    desk.apply()
    assert desk.form()["applied"]
    desk.edit("controller.kp", 80)
    assert not desk.form()["applied"]
    desk.undo()
    assert desk.form()["applied"]


def test_a_robot_that_is_named_no_more_hinders_nothing(folder: Path) -> None:
    other = folder / "robots/other.yaml"
    shutil.copy(SCENARIOS / "robots/seven.yaml", other)
    desk = Editor(str(folder / "caroca.yaml"))
    desk.apply()
    desk.edit("robot", "robots/other.yaml")
    desk.undo()
    assert desk.form()["applied"]
    other.unlink()
    desk.edit("controller.kp", 3)
    desk.revert()
    assert desk.form()["applied"]
    (folder / "robots/caroca.yaml").unlink()
    desk.edit("controller.kp", 3)
    with pytest.raises(CdprError, match=r"there is no file .*caroca\.yaml"):
        desk.revert()
    (folder / "robots/caroca.yaml").write_text("")
    with pytest.raises(CdprError, match=r"robots/caroca\.yaml: .*the file is empty"):
        desk.revert()


@pytest.mark.slow
def test_no_engine_and_no_compiler_is_needed_for_the_form() -> None:
    code = (
        "import json, sys; from cdpr.ui.gui.desk import Editor; desk = Editor('caroca'); json.dumps(desk.form());"
        "print([name for name in ('scipy', 'matplotlib', 'mujoco', 'websockets') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(
    ("name", "chosen", "sets"),
    [
        ("caroca", {"backend": "mujoco", "solver": "lp", "controller": "pid"}, []),
        ("caroca", {}, ["robot.cables[0].frame[2]=3.6", "robot.platform.colour=red", "world.gravity[0]=0.1"]),
        ("caroca", {}, ["believed.platform.mass=140", "believed.cables[5].frame[2]=3.6", "solver.infeasible=stop"]),
        ("believed", {}, ["believed.cables[5].frame[2]=3.6", "believed.cables[3].diameter=0.01"]),
        ("believed", {}, ["believed.cables=[{name: cable_2, frame: [-3.5, -2, 3.6]}]", "log.step=0.01"]),
        ("cable_break", {}, ["events[0].cable=7", "events[0].time=1.5", "robot.home.position[2]=1.3"]),
        ("cogiro_pulleys", {}, ["robot.cable.exit.radius=0.06", "backend_options.mujoco.cables=native"]),
        ("winch", {"controller": "cable_length"}, ["robot.cable.axial_stiffness=2e5"]),
        ("waypoints", {}, ["trajectory.points[1].time=3.5", "name=mine"]),
        ("point_mass", {}, ["robot=robots/seven.yaml", "trajectory={type: hold}", "simulation.duration=1"]),
        ("thesis", {}, ["controller.kp=[1, 2, 3, 4, 5, 6]", "initial.orientation={rpy_deg: [0, 0, 5]}"]),
    ],
)
def test_what_is_typed_comes_to_the_same_as_when_it_is_run(
    name: str, chosen: dict[str, str | None], sets: list[str]
) -> None:
    changes = typed(chosen, sets)
    assert Editor(name, changes).scenario() == load_scenario(name, overrides=changes)


def test_a_robot_that_is_wrong_can_be_opened_and_mended(folder: Path) -> None:
    robot = folder / "robots/caroca.yaml"
    robot.write_text(robot.read_text().replace("mass: 150 ", "mass: -1 ").replace("home:", "hom:"))
    desk = Editor(str(robot))
    paths = {each["path"] for each in desk.form()["problems"]}
    assert paths == {"robot.platform.mass", "robot.hom", "initial"}
    desk.edit("robot.platform.mass", 150)
    desk.edit("robot.hom", None)
    desk.edit("initial.position", [0, 0, 1.2])
    assert desk.scenario().robot.platform.mass == 150


def test_a_robot_file_that_is_no_yaml_is_told_at_its_name(folder: Path) -> None:
    robot = folder / "robots/caroca.yaml"
    text = robot.read_text()
    robot.write_text(text.replace("mass: 150", "mass: [150"))
    desk = Editor(str(folder / "caroca.yaml"))
    (problem,) = desk.form()["problems"]
    assert problem["path"] == "robot"
    assert "robots/caroca.yaml:" in problem["place"]
    with pytest.raises(CdprError):
        desk.edit("robot.platform.mass", 140)
    desk.edit("simulation.duration", 3)
    robot.write_text(text)
    desk.revert()
    assert desk.scenario().robot.platform.mass == 150


def test_a_robot_of_the_scenarios_own_is_edited_there(tmp_path: Path) -> None:
    desk = Editor("caroca")
    desk.new("scenario", file=str(tmp_path / "a.yaml"), planar=True)
    desk.edit("robot.cables[1].platform[0]", 0.25)
    desk.edit("robot.frame.colour", "#336699")
    assert desk.save() == [str(tmp_path / "a.yaml")]
    made = load_scenario(tmp_path / "a.yaml").robot
    assert made.cables[1].platform[0] == 0.25
    assert made.frame is not None
    assert made.frame.colour == "#336699"
    assert (tmp_path / "a.yaml").read_text().count("#") > 30  # a comment on every key, still
