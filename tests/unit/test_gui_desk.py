"""The desk: opening, editing, undoing, saving, and the scenario that comes of it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from cdpr.errors import CdprError, OutputError, ScenarioError
from cdpr.gui.desk import Desk
from cdpr.scenario import load_scenario
from cdpr.scenario.overrides import typed

SCENARIOS = Path(__file__).parents[2] / "scenarios"


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


def test_an_example_is_saved_as_a_file_of_ones_own(tmp_path: Path) -> None:
    desk = Desk("caroca")
    desk.edit("robot.platform.mass", 140)
    with pytest.raises(OutputError, match="save as"):
        desk.save()
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
