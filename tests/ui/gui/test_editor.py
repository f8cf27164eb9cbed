"""The editor: opening, editing, undoing, and the scenario that comes of it."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from editor_cases import SCENARIOS, caroca_in

from cdpr.base.errors import CdprError, ScenarioError
from cdpr.scenario import load_scenario
from cdpr.scenario.choices import typed
from cdpr.ui.gui.editor import Editor


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return caroca_in(tmp_path)


def test_an_edit_of_the_robot_goes_into_its_file_and_only_when_saved(folder: Path) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    robot = folder / "robots/caroca.yaml"
    before = robot.read_text()
    editor.edit("robot.platform.mass", 123.5)
    assert editor.form()["modified"]
    assert editor.scenario().robot.platform.mass == 123.5
    assert robot.read_text() == before
    assert editor.save() == [str(robot)]
    assert robot.read_text() == before.replace("mass: 150 ", "mass: 123.5 ")
    assert not editor.form()["modified"]
    assert load_scenario(folder / "caroca.yaml") == editor.scenario()


def test_a_bad_value_stays_with_its_problem_under_its_field(folder: Path) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    editor.edit("robot.platform.mass", "25 kg")
    form = editor.form()
    (problem,) = form["problems"]
    assert problem["path"] == "robot.platform.mass"
    assert problem["place"].endswith("robots/caroca.yaml:7")
    assert "write 25, without the unit" in problem["text"]
    with pytest.raises(ScenarioError, match="write 25"):
        editor.scenario()
    editor.edit("robot.platform.mass", 25)
    assert editor.scenario().robot.platform.mass == 25


def test_undo_and_redo_and_revert(folder: Path) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    first = editor.texts()
    editor.edit("controller.kp", 120)
    editor.edit("robot.platform.mass", 140)
    changed = editor.texts()
    assert editor.form()["undo"] == "robot.platform.mass = 140"
    editor.undo()
    editor.undo()
    assert editor.texts() == first
    with pytest.raises(CdprError, match="no change to undo"):
        editor.undo()
    editor.redo()
    editor.redo()
    assert editor.texts() == changed
    editor.revert()
    assert editor.texts() == first
    assert not editor.form()["modified"]
    editor.undo()
    assert editor.texts() == changed


def test_choices_of_the_command_line_are_edits_that_are_not_saved(folder: Path) -> None:
    chosen = {"backend": "mujoco", "solver": None, "controller": "pid"}
    editor = Editor(str(folder / "caroca.yaml"), typed(chosen, ["simulation.duration=2"]))
    scenario = editor.scenario()
    assert scenario.simulation.backend == "mujoco"
    assert scenario.simulation.duration == 2
    assert scenario.controller.type == "pid"
    assert scenario.controller_options.kp == 100  # type: ignore[attr-defined]
    assert editor.form()["modified"]
    assert (folder / "caroca.yaml").read_text() == (SCENARIOS / "caroca.yaml").read_text()


@pytest.mark.slow
def test_failed_writes_are_rejected_without_effect(folder: Path) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    before = editor.texts()
    for edit in (
        lambda: editor.edit("events[3].time", 1),
        lambda: editor.edit("robot.cables[9].frame", [0, 0, 0]),
        lambda: editor.edit("a b", 1),
        lambda: editor.edit("", 1),
        lambda: editor.edit("solver.type[2]", 1),
        lambda: editor.edit("solver.reference", "[1, "),
        lambda: editor.insert("simulation.duration", 1),
        lambda: editor.open("no_such_thing"),
        lambda: editor.open("gains"),  # a study
        lambda: editor.new("robot", masss=4),
        lambda: editor.new("study"),
        lambda: editor.new("scenario", robot="seven", mass=3),
        lambda: editor.new("robot", cables=float("inf")),
        lambda: editor.new("robot", frame=[1, 2]),
        lambda: editor.new("robot", frame=[1, float("nan"), 2]),
        lambda: editor.open(0),  # type: ignore[arg-type]
        lambda: editor.open("a\0b"),
        lambda: editor.new("robot", file="\ud800"),
        lambda: editor.new("robot", self=1),
        lambda: editor.new("robot", frame=[1e-300, 1, 1]),
        lambda: editor.save_as("\ud800"),
        lambda: editor.save_as(str(folder / ("x" * 300))),
        lambda: editor.edit(7, 1),  # type: ignore[arg-type]
        lambda: editor.edit("name", "\ud800"),
        lambda: editor.edit("name", 10**5000),
        lambda: editor.edit("name", [[[[]]]] * 70000),
        lambda: editor.save_as(""),
        lambda: editor.save_as("a\0b"),
        lambda: editor.save_as(str(folder / "caroca.yaml")),
        lambda: editor.save_as(str(folder / "caroca.yaml/x")),
        lambda: editor.redo(),
    ):
        with pytest.raises(CdprError):
            edit()
        assert editor.texts() == before
    assert sorted(path.name for path in folder.rglob("*")) == ["caroca.yaml", "caroca.yaml", "robots"]
    editor.edit("robot.platform.mass", 140)
    editor.undo()
    editor.remove("events")
    editor.remove("simulation.log")
    assert editor.texts() == before


def test_another_robot_file_can_be_named_and_taken_back(folder: Path) -> None:
    shutil.copy(SCENARIOS / "robots/seven.yaml", folder / "robots")
    editor = Editor(str(folder / "caroca.yaml"))
    editor.edit("robot", "robots/seven.yaml")
    assert editor.scenario().robot.m == 7
    assert editor.form()["files"] == [str(folder / "caroca.yaml"), str(folder / "robots/seven.yaml")]
    editor.edit("robot", "robots/eight.yaml")
    (problem,) = editor.form()["problems"]
    assert problem["path"] == "robot"
    editor.undo()
    editor.undo()
    assert editor.scenario().robot.m == 8


def test_a_cable_comes_and_goes_with_its_limits(folder: Path) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    editor.edit("robot.tension.min[2]", 60)
    assert editor.scenario().robot.tension_min.tolist() == [50, 50, 60, 50, 50, 50, 50, 50]
    editor.remove("robot.cables[1]")
    assert editor.scenario().robot.tension_min.tolist() == [50, 60, 50, 50, 50, 50, 50]
    editor.insert("robot.cables")
    assert editor.scenario().robot.m == 8


def test_edits_survive_opening_another_file(folder: Path) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    editor.edit("robot.platform.mass", 140)
    edited = editor.texts()
    editor.save_as(str(folder / "mine.yaml"))
    editor.open("seven")
    editor.edit("robot.platform.mass", 21)
    editor.new("robot")
    assert editor.form()["undo"] == "new robot"
    for _ in range(4):
        editor.undo()
    assert editor.texts() == edited
    assert editor.form()["files"][0] == str(folder / "caroca.yaml")
    assert editor.form()["modified"]
    for _ in range(3):
        editor.redo()
    assert editor.scenario().robot.platform.mass == 21


def test_applied_state_of_the_form(folder: Path) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    assert not editor.form()["applied"]
    editor.apply()
    assert editor.form()["applied"]
    editor.edit("controller.kp", 80)
    assert not editor.form()["applied"]
    editor.undo()
    assert editor.form()["applied"]


def test_a_robot_that_is_named_no_more_hinders_nothing(folder: Path) -> None:
    other = folder / "robots/other.yaml"
    shutil.copy(SCENARIOS / "robots/seven.yaml", other)
    editor = Editor(str(folder / "caroca.yaml"))
    editor.apply()
    editor.edit("robot", "robots/other.yaml")
    editor.undo()
    assert editor.form()["applied"]
    other.unlink()
    editor.edit("controller.kp", 3)
    editor.revert()
    assert editor.form()["applied"]
    (folder / "robots/caroca.yaml").unlink()
    editor.edit("controller.kp", 3)
    with pytest.raises(CdprError, match=r"there is no file .*caroca\.yaml"):
        editor.revert()
    (folder / "robots/caroca.yaml").write_text("")
    with pytest.raises(CdprError, match=r"robots/caroca\.yaml: .*the file is empty"):
        editor.revert()


@pytest.mark.slow
def test_no_engine_and_no_compiler_is_needed_for_the_form() -> None:
    code = (
        "import json, sys; from cdpr.ui.gui.editor import Editor; editor = Editor('caroca'); json.dumps(editor.form());"
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
def test_typed_commands_equal_the_program(name: str, chosen: dict[str, str | None], sets: list[str]) -> None:
    changes = typed(chosen, sets)
    assert Editor(name, changes).scenario() == load_scenario(name, overrides=changes)


def test_a_robot_that_is_wrong_can_be_opened_and_mended(folder: Path) -> None:
    robot = folder / "robots/caroca.yaml"
    robot.write_text(robot.read_text().replace("mass: 150 ", "mass: -1 ").replace("home:", "hom:"))
    editor = Editor(str(robot))
    paths = {each["path"] for each in editor.form()["problems"]}
    assert paths == {"robot.platform.mass", "robot.hom", "initial"}
    editor.edit("robot.platform.mass", 150)
    editor.edit("robot.hom", None)
    editor.edit("initial.position", [0, 0, 1.2])
    assert editor.scenario().robot.platform.mass == 150


def test_a_robot_file_that_is_no_yaml_is_reported_at_its_name(folder: Path) -> None:
    robot = folder / "robots/caroca.yaml"
    text = robot.read_text()
    robot.write_text(text.replace("mass: 150", "mass: [150"))
    editor = Editor(str(folder / "caroca.yaml"))
    (problem,) = editor.form()["problems"]
    assert problem["path"] == "robot"
    assert "robots/caroca.yaml:" in problem["place"]
    with pytest.raises(CdprError):
        editor.edit("robot.platform.mass", 140)
    editor.edit("simulation.duration", 3)
    robot.write_text(text)
    editor.revert()
    assert editor.scenario().robot.platform.mass == 150


def test_a_robot_of_the_scenarios_own_is_edited_there(tmp_path: Path) -> None:
    editor = Editor("caroca")
    editor.new("scenario", file=str(tmp_path / "a.yaml"), planar=True)
    editor.edit("robot.cables[1].platform[0]", 0.25)
    editor.edit("robot.frame.colour", "#336699")
    assert editor.save() == [str(tmp_path / "a.yaml")]
    made = load_scenario(tmp_path / "a.yaml").robot
    assert made.cables[1].platform[0] == 0.25
    assert made.frame is not None
    assert made.frame.colour == "#336699"
    assert (tmp_path / "a.yaml").read_text().count("#") > 30  # a comment on every key, still


def test_new_sensors_have_names_of_their_own_and_complete_values(folder: Path) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    for kind in ("pose", "twist", "pose", "pose", "markers", None):
        editor.insert("sensors", kind)
    assert [sensor.title for sensor in editor.scenario().sections.sensors] == [
        "pose",
        "twist",
        "pose_2",
        "pose_3",
        "markers",
        "markers_2",
    ]
    for kind in ("sensor_failure", "sensor_occlusion", "sensor_bump"):
        editor.insert("events", kind)
    assert {event.sensor for event in editor.scenario().events} == {"pose"}
    assert not editor.form()["problems"]
