"""The desk: opening, editing, undoing, saving, and the scenario that comes of it."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from cdpr.errors import CdprError, OutputError, ScenarioError
from cdpr.gui.desk import Desk
from cdpr.scenario import load_robot, load_scenario
from cdpr.scenario.overrides import typed

SCENARIOS = Path(__file__).parents[2] / "scenarios"

STL = """solid box
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 1
endloop
endfacet
endsolid box
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with a scenario and its robot."""
    (tmp_path / "robots").mkdir()
    shutil.copy(SCENARIOS / "caroca.yaml", tmp_path)
    shutil.copy(SCENARIOS / "robots/caroca.yaml", tmp_path / "robots")
    return tmp_path


def test_an_edit_of_the_robot_goes_into_its_file_and_only_when_saved(folder: Path) -> None:
    desk = Desk(str(folder / "caroca.yaml"))
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
    desk = Desk(str(folder / "caroca.yaml"))
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
    desk = Desk(str(folder / "caroca.yaml"))
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
    desk = Desk(str(folder / "caroca.yaml"), typed(chosen, ["simulation.duration=2"]))
    scenario = desk.scenario()
    assert scenario.simulation.backend == "mujoco"
    assert scenario.simulation.duration == 2
    assert scenario.controller.type == "pid"
    assert scenario.controller_options.kp == 100  # type: ignore[attr-defined]
    assert desk.form()["modified"]
    assert (folder / "caroca.yaml").read_text() == (SCENARIOS / "caroca.yaml").read_text()


def test_what_others_changed_is_not_written_over(folder: Path) -> None:
    desk = Desk(str(folder / "caroca.yaml"))
    desk.edit("simulation.duration", 3)
    (folder / "caroca.yaml").write_text((folder / "caroca.yaml").read_text() + "# mine\n")
    with pytest.raises(OutputError, match="changed by another program"):
        desk.save()
    assert (folder / "caroca.yaml").read_text().endswith("# mine\n")
    form = desk.form()
    assert "changed by another program" in form["unsaved"]
    assert "Revert reads it anew" in form["warnings"][0]["text"]
    desk.revert()
    form = desk.form()
    assert not form["modified"]
    assert not form["warnings"]
    assert desk.texts()[0]["text"].endswith("# mine\n")


def test_what_may_not_be_written_stays(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    desk = Desk(str(folder / "caroca.yaml"))
    desk.edit("simulation.duration", 3)
    monkeypatch.setattr("os.access", lambda name, mode: False)  # whoever tests may be root
    with pytest.raises(OutputError, match="may not be written"):
        desk.save()


def test_an_example_is_saved_as_a_file_of_ones_own(tmp_path: Path) -> None:
    desk = Desk("caroca")
    desk.edit("robot.platform.mass", 140)
    with pytest.raises(OutputError, match="save as"):
        desk.save()
    (tmp_path / "robots").write_text("a file where the robot's folder would be")
    with pytest.raises(OutputError, match=r"cannot make the folder .*robots"):
        desk.save_as(str(tmp_path))
    (tmp_path / "robots").unlink()
    assert list(tmp_path.iterdir()) == []
    names = desk.save_as(str(tmp_path))
    assert sorted(names) == [str(tmp_path / "caroca.yaml"), str(tmp_path / "robots/caroca.yaml")]
    assert load_scenario(tmp_path / "caroca.yaml").robot.platform.mass == 140
    with pytest.raises(OutputError, match="is there already"):
        desk.save_as(str(tmp_path))


def test_a_robot_alone_stands_in_a_scenario_at_its_home(folder: Path) -> None:
    desk = Desk(str(folder / "robots/caroca.yaml"))
    scenario = desk.scenario()
    assert scenario.initial.position == (0.0, 0.0, 1.2)
    desk.edit("robot.platform.mass", 140)
    assert desk.scenario().robot.platform.mass == 140
    assert desk.save() == [str(folder / "robots/caroca.yaml")]
    assert sorted(path.name for path in (folder / "robots").iterdir()) == ["caroca.yaml"]


def test_a_file_keeps_its_line_ends_its_rights_and_its_link(folder: Path) -> None:
    file, link = folder / "caroca.yaml", folder / "link.yaml"
    file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    file.chmod(0o640)
    link.symlink_to("caroca.yaml")
    desk = Desk(str(link))
    before = file.read_bytes()
    desk.edit("simulation.duration", 3)
    desk.edit("log.step", 0.01)
    desk.save()
    expected = before.replace(b"duration: 4.0", b"duration: 3", 1) + b"log: {step: 0.01}\r\n"
    assert file.read_bytes() == expected
    assert link.is_symlink()
    assert file.stat().st_mode & 0o777 == 0o640
    assert {path.name for path in folder.iterdir()} == {"caroca.yaml", "link.yaml", "robots"}


def test_saved_elsewhere_all_names_lead_to_the_same_files(
    folder: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    (folder / "path.csv").write_text("t,x,y,z\n0,0,0,1.2\n2,0.2,0,1.2\n4,0,0,1.2\n")
    (folder / "robots/box.stl").write_text(STL)
    desk = Desk(str(folder / "caroca.yaml"))
    desk.edit("trajectory", "csv")
    desk.edit("trajectory.file", "path.csv")
    desk.edit("robot.platform.shape", "mesh")
    desk.edit("robot.platform.shape.mesh", "box.stl")
    expected = desk.scenario()
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    names = desk.save_as(str(elsewhere / "deeper" / "mine"))
    assert names == [str(elsewhere / "deeper/mine.yaml"), str(elsewhere / "deeper/robots/caroca.yaml")]
    again = load_scenario(names[0])
    assert again.yaml_in(str(folder)).replace("mine", "caroca") == expected.yaml_in(str(folder))
    assert not desk.form()["modified"]
    assert "mesh" not in (folder / "robots/caroca.yaml").read_text()


def test_a_robot_that_is_as_it_was_is_named_where_it_is(folder: Path) -> None:
    desk = Desk(str(folder / "caroca.yaml"))
    desk.edit("simulation.duration", 3)
    (folder / "other").mkdir()
    assert desk.save_as(str(folder / "other")) == [str(folder / "other/caroca.yaml")]
    assert 'robot: "../robots/caroca.yaml"   ' in (folder / "other/caroca.yaml").read_text()
    assert load_scenario(folder / "other/caroca.yaml").simulation.duration == 3


def test_a_changed_robot_is_never_written_over_that_of_others(folder: Path) -> None:
    desk = Desk(str(folder / "caroca.yaml"))
    before = (folder / "robots/caroca.yaml").read_text()
    desk.edit("robot.platform.mass", 140)
    names = desk.save_as(str(folder / "heavier.yaml"))
    assert names == [str(folder / "heavier.yaml"), str(folder / "robots/caroca_2.yaml")]
    assert (folder / "robots/caroca.yaml").read_text() == before
    assert load_scenario(names[0]).robot.platform.mass == 140
    desk.edit("robot.platform.mass", 130)
    assert desk.save() == [names[1]]


def test_what_cannot_be_written_is_refused_and_all_is_as_before(folder: Path) -> None:
    desk = Desk(str(folder / "caroca.yaml"))
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


def test_new_ones_are_saved_where_nothing_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    desk = Desk("caroca")
    desk.new("robot", file="mine.yaml", frame=[4, 3, 2], mass="25")
    assert desk.form()["modified"]
    assert desk.scenario().robot.platform.mass == 25
    assert list(tmp_path.iterdir()) == []
    desk.edit("trajectory", "circle")
    with pytest.raises(OutputError, match="has no file: save it as one"):
        desk.save()
    desk.undo()
    assert desk.save() == ["mine.yaml"]
    desk.new("robot", file="mine.yaml")
    with pytest.raises(OutputError, match="is there already"):
        desk.save()
    desk.new("scenario", robot="mine.yaml")
    assert desk.save() == ["scenario.yaml"]
    assert load_scenario("scenario.yaml").robot.platform.mass == 25


def test_another_robot_file_can_be_named_and_taken_back(folder: Path) -> None:
    shutil.copy(SCENARIOS / "robots/seven.yaml", folder / "robots")
    desk = Desk(str(folder / "caroca.yaml"))
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
    desk = Desk(str(folder / "caroca.yaml"))
    desk.edit("robot.tension.min[2]", 60)
    assert desk.scenario().robot.tension_min.tolist() == [50, 50, 60, 50, 50, 50, 50, 50]
    desk.remove("robot.cables[1]")
    assert desk.scenario().robot.tension_min.tolist() == [50, 60, 50, 50, 50, 50, 50]
    desk.insert("robot.cables")
    assert desk.scenario().robot.m == 8


def test_what_was_edited_is_had_again_after_another_file(folder: Path) -> None:
    desk = Desk(str(folder / "caroca.yaml"))
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
    desk = Desk(str(folder / "caroca.yaml"))
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
    desk = Desk(str(folder / "caroca.yaml"))
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


def test_no_engine_and_no_compiler_is_needed_for_the_form() -> None:
    code = (
        "import json, sys; from cdpr.gui.desk import Desk; desk = Desk('caroca'); json.dumps(desk.form());"
        "print([name for name in ('numba', 'scipy', 'matplotlib', 'mujoco', 'websockets') if name in sys.modules])"
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
    assert Desk(name, changes).scenario() == load_scenario(name, overrides=changes)


def test_a_robot_alone_is_saved_as_a_robot(folder: Path) -> None:
    desk = Desk("seven")
    desk.edit("robot.platform.mass", 21)
    name = str(folder / "robots" / "mine")
    assert desk.save_as(name) == [f"{name}.yaml"]
    assert desk.form()["file"] == f"{name}.yaml"
    desk.edit("robot.platform.mass", 22)
    assert desk.save() == [f"{name}.yaml"]
    assert load_robot(f"{name}.yaml").platform.mass == 22
    desk.edit("simulation.duration", 3)
    assert sorted(desk.save_as(str(folder / "new/run.yaml"))) == [str(folder / "new/run.yaml")]
    assert load_scenario(folder / "new/run.yaml").robot.platform.mass == 22
    desk.edit("robot.platform.mass", 23)
    assert desk.save() == [str(folder / "new/../robots/mine.yaml")]


def test_a_robot_that_is_wrong_can_be_opened_and_mended(folder: Path) -> None:
    robot = folder / "robots/caroca.yaml"
    robot.write_text(robot.read_text().replace("mass: 150 ", "mass: -1 ").replace("home:", "hom:"))
    desk = Desk(str(robot))
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
    desk = Desk(str(folder / "caroca.yaml"))
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
    desk = Desk("caroca")
    desk.new("scenario", file=str(tmp_path / "a.yaml"), planar=True)
    desk.edit("robot.cables[1].platform[0]", 0.25)
    desk.edit("robot.frame.colour", "#336699")
    assert desk.save() == [str(tmp_path / "a.yaml")]
    made = load_scenario(tmp_path / "a.yaml").robot
    assert made.cables[1].platform[0] == 0.25
    assert made.frame is not None
    assert made.frame.colour == "#336699"
    assert (tmp_path / "a.yaml").read_text().count("#") > 30  # a comment on every key, still
