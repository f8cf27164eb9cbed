"""Files written by the editor: unedited content is kept, and files of others are not overwritten."""

from __future__ import annotations

from pathlib import Path

import pytest
from editor_cases import caroca_in

from cdpr.base.errors import OutputError
from cdpr.scenario import load_robot, load_scenario
from cdpr.ui.gui.editor import Editor

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
    return caroca_in(tmp_path)


def test_external_changes_are_not_overwritten(folder: Path) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    editor.edit("simulation.duration", 3)
    (folder / "caroca.yaml").write_text((folder / "caroca.yaml").read_text() + "# mine\n")
    with pytest.raises(OutputError, match="changed by another program"):
        editor.save()
    assert (folder / "caroca.yaml").read_text().endswith("# mine\n")
    form = editor.form()
    assert "changed by another program" in form["unsaved"]
    assert "use Revert to reload it" in form["warnings"][0]["text"]
    editor.revert()
    form = editor.form()
    assert not form["modified"]
    assert not form["warnings"]
    assert editor.texts()[0]["text"].endswith("# mine\n")


def test_protected_files_are_unchanged(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    editor.edit("simulation.duration", 3)
    monkeypatch.setattr("os.access", lambda name, mode: False)  # the user may be root
    with pytest.raises(OutputError, match="may not be written"):
        editor.save()


def test_an_example_is_saved_as_a_file_of_ones_own(tmp_path: Path) -> None:
    editor = Editor("caroca")
    editor.edit("robot.platform.mass", 140)
    with pytest.raises(OutputError, match="save it under another name"):
        editor.save()
    (tmp_path / "robots").write_text("a file where the robot's folder would be")
    with pytest.raises(OutputError, match=r"cannot make the folder .*robots"):
        editor.save_as(str(tmp_path))
    (tmp_path / "robots").unlink()
    assert list(tmp_path.iterdir()) == []
    names = editor.save_as(str(tmp_path))
    assert sorted(names) == [str(tmp_path / "caroca.yaml"), str(tmp_path / "robots/caroca.yaml")]
    assert load_scenario(tmp_path / "caroca.yaml").robot.platform.mass == 140
    with pytest.raises(OutputError, match="already exists"):
        editor.save_as(str(tmp_path))


def test_a_file_keeps_its_line_ends_its_rights_and_its_link(folder: Path) -> None:
    file, link = folder / "caroca.yaml", folder / "link.yaml"
    file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    file.chmod(0o640)
    link.symlink_to("caroca.yaml")
    editor = Editor(str(link))
    before = file.read_bytes()
    editor.edit("simulation.duration", 3)
    editor.edit("log.step", 0.01)
    editor.save()
    expected = before.replace(b"duration: 4.0", b"duration: 3", 1) + b"log: {step: 0.01}\r\n"
    assert file.read_bytes() == expected
    assert link.is_symlink()
    assert file.stat().st_mode & 0o777 == 0o640
    assert {path.name for path in folder.iterdir()} == {"caroca.yaml", "link.yaml", "robots"}


def test_files_saved_elsewhere_keep_their_references(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    (folder / "path.csv").write_text("t,x,y,z\n0,0,0,1.2\n2,0.2,0,1.2\n4,0,0,1.2\n")
    (folder / "robots/box.stl").write_text(STL)
    editor = Editor(str(folder / "caroca.yaml"))
    editor.edit("trajectory", "csv")
    editor.edit("trajectory.file", "path.csv")
    editor.edit("robot.platform.shape", "mesh")
    editor.edit("robot.platform.shape.mesh", "box.stl")
    expected = editor.scenario()
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    names = editor.save_as(str(elsewhere / "deeper" / "mine"))
    assert names == [str(elsewhere / "deeper/mine.yaml"), str(elsewhere / "deeper/robots/caroca.yaml")]
    again = load_scenario(names[0])
    assert again.yaml_in(str(folder)).replace("mine", "caroca") == expected.yaml_in(str(folder))
    assert not editor.form()["modified"]
    assert "mesh" not in (folder / "robots/caroca.yaml").read_text()


def test_a_robot_that_is_as_it_was_is_named_where_it_is(folder: Path) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    editor.edit("simulation.duration", 3)
    (folder / "other").mkdir()
    assert editor.save_as(str(folder / "other")) == [str(folder / "other/caroca.yaml")]
    assert 'robot: "../robots/caroca.yaml"   ' in (folder / "other/caroca.yaml").read_text()
    assert load_scenario(folder / "other/caroca.yaml").simulation.duration == 3


def test_a_changed_robot_is_never_written_over_that_of_others(folder: Path) -> None:
    editor = Editor(str(folder / "caroca.yaml"))
    before = (folder / "robots/caroca.yaml").read_text()
    editor.edit("robot.platform.mass", 140)
    names = editor.save_as(str(folder / "heavier.yaml"))
    assert names == [str(folder / "heavier.yaml"), str(folder / "robots/caroca_2.yaml")]
    assert (folder / "robots/caroca.yaml").read_text() == before
    assert load_scenario(names[0]).robot.platform.mass == 140
    editor.edit("robot.platform.mass", 130)
    assert editor.save() == [names[1]]


def test_new_ones_are_saved_where_nothing_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    editor = Editor("caroca")
    editor.new("robot", file="mine.yaml", frame=[4, 3, 2], mass="25")
    assert editor.form()["modified"]
    assert editor.scenario().robot.platform.mass == 25
    assert list(tmp_path.iterdir()) == []
    editor.edit("trajectory", "circle")
    with pytest.raises(OutputError, match="has no file: save it"):
        editor.save()
    editor.undo()
    assert editor.save() == ["mine.yaml"]
    editor.new("robot", file="mine.yaml")
    with pytest.raises(OutputError, match="already exists"):
        editor.save()
    editor.new("scenario", robot="mine.yaml")
    assert editor.save() == ["scenario.yaml"]
    assert load_scenario("scenario.yaml").robot.platform.mass == 25


def test_a_robot_without_scenario_holds_its_home_pose(folder: Path) -> None:
    editor = Editor(str(folder / "robots/caroca.yaml"))
    scenario = editor.scenario()
    assert scenario.initial.position == (0.0, 0.0, 1.2)
    editor.edit("robot.platform.mass", 140)
    assert editor.scenario().robot.platform.mass == 140
    assert editor.save() == [str(folder / "robots/caroca.yaml")]
    assert sorted(path.name for path in (folder / "robots").iterdir()) == ["caroca.yaml"]


def test_a_robot_alone_is_saved_as_a_robot(folder: Path) -> None:
    editor = Editor("seven")
    editor.edit("robot.platform.mass", 21)
    name = str(folder / "robots" / "mine")
    assert editor.save_as(name) == [f"{name}.yaml"]
    assert editor.form()["file"] == f"{name}.yaml"
    editor.edit("robot.platform.mass", 22)
    assert editor.save() == [f"{name}.yaml"]
    assert load_robot(f"{name}.yaml").platform.mass == 22
    editor.edit("simulation.duration", 3)
    assert sorted(editor.save_as(str(folder / "new/run.yaml"))) == [str(folder / "new/run.yaml")]
    assert load_scenario(folder / "new/run.yaml").robot.platform.mass == 22
    editor.edit("robot.platform.mass", 23)
    assert editor.save() == [str(folder / "new/../robots/mine.yaml")]
