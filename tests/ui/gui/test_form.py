"""Form: a field for every key, with value, unit and problem."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT

from cdpr.base.errors import CdprError
from cdpr.plugins.registry import registry
from cdpr.scenario import examples
from cdpr.scenario.events import EVENTS
from cdpr.scenario.motions import MOTIONS
from cdpr.scenario.robot_schema import CableSection, RobotSection
from cdpr.scenario.schema import ScenarioSection
from cdpr.sensing import SENSORS
from cdpr.ui.gui.editor import Editor
from cdpr.ui.gui.editor.fields import every

SCENARIOS = ROOT / "scenarios"


def fields(editor: Editor) -> dict[str, dict[str, Any]]:
    return {each["path"]: each for tab in editor.form()["tabs"] for each in every(tab["fields"])}


def values(choices: list[dict[str, Any]]) -> list[str]:
    return [each["value"] for each in choices]


@pytest.fixture(scope="module")
def caroca() -> Editor:
    """Return a editor that no test changes."""
    return Editor("caroca")


def test_all_keys_of_the_thesis_window_have_fields(caroca: Editor) -> None:
    found = fields(caroca)
    assert [tab["label"] for tab in caroca.form()["tabs"]] == ["Robot", "Motion", "Control", "Events", "Simulation"]
    assert {
        "robot.platform.mass": "number",
        "robot.platform.inertia": "vector",
        "robot.platform.shape": "section",
        "robot.platform.shape.box": "vector",
        "robot.platform.colour": "colour",
        "robot.home.position": "vector",
        "robot.home.orientation": "section",
        "robot.cables": "table",
        "robot.cable.diameter": "number",
        "robot.cable.linear_density": "number",
        "robot.frame.lower": "vector",
        "robot.frame.upper": "vector",
        "robot.frame.shape": "choice",
        "robot.frame.colour": "colour",
        "robot.tension.min": "vector",
        "robot.tension.max": "vector",
        "controller.kp": "vector",
        "controller.kd": "vector",
    }.items() <= {path: field["kind"] for path, field in found.items()}.items()
    mass = found["robot.platform.mass"]
    assert (mass["value"], mass["unit"], mass["given"], mass["optional"]) == (150, "kg", True, False)
    assert (mass["least"], mass["least_open"]) == (0, True)
    assert mass["help"] == "mass of the platform"
    kp = found["controller.kp"]
    assert (kp["value"], kp["size"], kp["single"]) == (100, 6, True)
    assert found["simulation.seed"]["kind"] == "integer"
    assert found["robot.dof"]["kind"] == "set"


def test_every_key_of_the_schema_has_its_field(caroca: Editor) -> None:
    found = fields(caroca)
    assert set(ScenarioSection.model_fields) - {"robot"} <= set(found)
    assert {f"robot.{key}" for key in RobotSection.model_fields} <= set(found)
    columns = {column["key"].partition(".")[0] for column in found["robot.cables"]["columns"]}
    assert columns == set(CableSection.model_fields)


def test_cables_are_a_table(caroca: Editor) -> None:
    table = fields(caroca)["robot.cables"]
    columns = {column["key"]: column for column in table["columns"]}
    assert columns["frame"]["unit"] == "m"
    assert (columns["frame"]["kind"], columns["frame"]["size"], columns["frame"]["shown"]) == ("vector", 3, True)
    assert not columns["winch.drum_radius"]["shown"]
    assert values(columns["exit.type"]["choices"]) == ["point", "pulley"]
    assert len(table["rows"]) == 8
    row = table["rows"][2]
    assert (row["path"], row["name"]) == ("robot.cables[2]", "cable_3")
    assert row["cells"]["frame"] == {"value": [3.5, -2.0, 3.5], "given": True}
    assert row["cells"]["tension.max"] == {"value": 10000.0, "given": False}


def test_omitted_keys_show_their_effective_values() -> None:
    found = fields(Editor("seven"))
    assert found["initial.position"]["value"] == [0.0, 0.0, 1.5]
    assert not found["initial.position"]["given"]
    assert found["simulation.physics_step"]["value"] == 0.001
    assert found["trajectory"]["value"] == "hold"


def test_plugins_are_choices_and_bring_their_options(caroca: Editor) -> None:
    found = fields(caroca)
    for path, role in (("controller", "controller"), ("solver", "solver"), ("simulation.backend", "backend")):
        assert values(found[path]["choices"]) == registry().names(role)  # type: ignore[arg-type]
        for each in found[path]["choices"]:
            entry = registry().get(role, each["value"])  # type: ignore[arg-type]
            assert each["missing"] == (entry.remedy if entry.missing else None)
    assert values(found["backend_options.mujoco.integrator"]["choices"]) == ["euler", "rk4"]


def test_missing_parts_are_reported_with_their_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    import cdpr.plugins.registry as module

    monkeypatch.setattr(module, "_found", lambda name: name != "mujoco")
    backend = {each["value"]: each for each in fields(Editor("caroca"))["simulation.backend"]["choices"]}
    assert backend["mujoco"]["missing"] == "pip install 'cdpr[mujoco]'"
    assert backend["reference"]["missing"] is None


def test_every_type_of_event_and_motion_loads_as_it_begins() -> None:
    """Except those that need a file, which have a hint in their field."""
    editor = Editor("caroca")
    editor.edit("robot.cable.diameter", 0.01)
    editor.insert("sensors", "tension")
    for event in EVENTS.values():
        editor.insert("events", event.kind())
        form = editor.form()
        assert [each["path"] for each in form["problems"]] == [f"events[0].{key}" for key in event.files]
        editor.undo()
    files = {name: motion.files for name, motion in MOTIONS.items()}
    for name in values(fields(editor)["trajectory"]["choices"]):
        editor.edit("trajectory", name)
        paths = [each["path"] for each in editor.form()["problems"]]
        assert paths == [f"trajectory.{key}" for key in files[name]]
    assert fields(editor)["trajectory"]["value"] == name


def test_every_type_of_sensor_loads_as_it_begins() -> None:
    """Except cameras, whose place and markers have no usual values."""
    editor = Editor("caroca")
    for sensor in SENSORS.values():
        editor.insert("sensors", sensor.kind())
        missing = [f"sensors[0].{key}" for key, field in sensor.model_fields.items() if field.is_required()]
        others = ["sensors[0]"] if sensor.used in ("pose", "twist") else []  # one needs the other
        assert {each["path"] for each in editor.form()["problems"]} <= {*missing, *others}
        editor.undo()


def test_another_form_keeps_what_it_takes() -> None:
    editor = Editor("caroca")
    editor.edit("trajectory.type", "pick_and_place")
    found = fields(editor)
    assert found["trajectory.to.position"]["value"] == [1.5, 0.5, 1.6]
    assert "# s, then hold" in editor.texts()[0]["text"]
    editor.edit("trajectory.to.orientation", "quaternion")
    assert fields(editor)["trajectory.to.orientation.quaternion"]["value"] == [0.988771078, 0.0, 0.0, 0.149438132]
    editor.edit("controller", "pid")
    assert fields(editor)["controller.kp"]["value"] == 100
    editor.edit("robot.platform.shape", "sphere")
    assert fields(editor)["robot.platform.shape.sphere"]["value"] == 0.45
    editor.edit("robot.cables[0].exit.type", "pulley")
    assert editor.scenario().robot.cables[0].exit is not None
    with pytest.raises(CdprError, match="did you mean 'circle'"):
        editor.edit("trajectory", "cirle")


def test_problems_are_under_the_field_of_their_value() -> None:
    editor = Editor("caroca")
    for path, value in (
        ("robot.platform.mass", "heavy"),
        ("robot.cables[3].frame[1]", "left"),
        ("trajectory.to.orientation.rpy", [0, 0]),
        ("controller.kp", -1),
        ("world", "moon"),
    ):
        editor.edit(path, value)
    form = editor.form()
    assert {each["path"]: each["key"] for each in form["problems"]} == {
        "robot.platform.mass": "robot.platform.mass",
        "robot.cables[3].frame": "robot.cables[3].frame[1]",
        "trajectory.to.orientation.rpy": "trajectory.to.orientation.rpy",
        "controller.kp": "controller.kp",
        "world": "world",
    }
    found = fields(editor)
    assert found["robot.platform.mass"]["value"] == "heavy"
    assert (found["world"]["kind"], found["world"]["value"]) == ("yaml", "moon")
    editor.edit("world", "{gravity: [0, 0, -1.62]}")
    assert fields(editor)["world.gravity"]["value"] == [0, 0, -1.62]


def test_an_unknown_key_has_a_field_and_can_be_removed() -> None:
    editor = Editor("caroca")
    editor.edit("robot.platform.weight", 5)
    (problem,) = editor.form()["problems"]
    assert problem["path"] == "robot.platform.weight"
    assert fields(editor)["robot.platform.weight"]["value"] == "5"
    editor.edit("robot.platform.weight", None)
    assert not editor.form()["problems"]


def test_suspicious_values_are_warnings() -> None:
    editor = Editor("caroca")
    editor.edit("world.gravity[2]", 9.81)
    editor.edit("robot.cable.linear_density", 0.05)
    form = editor.form()
    assert not form["problems"]
    assert {"world.gravity", "robot.cable.linear_density"} <= {each["path"] for each in form["warnings"]}


def test_believed_cables_are_those_of_the_robot() -> None:
    editor = Editor("believed")
    rows = fields(editor)["believed.cables"]["rows"]
    assert [row["cells"]["frame"]["given"] for row in rows] == [True, *[False] * 4, True, False, False]
    editor.edit("believed.cables[2].frame[2]", 3.6)
    editor.edit("believed.cables[5].platform", [0.6, 0.3, 0.21])
    editor.edit("believed.platform.inertia[0]", 7)
    believed = editor.scenario().nominal
    assert believed is not None
    assert believed.cables[2].frame.tolist() == [3.5, -2.0, 3.6]
    assert believed.cables[5].frame.tolist() == [-3.5, 2.02, 3.5]
    assert believed.cables[5].platform.tolist() == [0.6, 0.3, 0.21]
    assert believed.platform.inertia[0, 0] == 7
    assert "  - {name: cable_3, frame: [3.5, -2.0, 3.6]}\n" in editor.texts()[0]["text"]
    editor.edit("believed.cables[0].frame", None)
    assert not fields(editor)["believed.cables"]["rows"][0]["cells"]["frame"]["given"]


def test_edits_keep_the_spelling_nominal(tmp_path: Path) -> None:
    text = Editor("believed").texts()[0]["text"].replace("believed:  ", "nominal:  ")
    robot = Path(examples.resolve("caroca", "robot")).read_text()
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "caroca.yaml").write_text(robot)
    (tmp_path / "own.yaml").write_text(text)
    editor = Editor(str(tmp_path / "own.yaml"))
    for key, value in (("believed.cables[5].frame", None), ("nominal.platform.mass", 130), ("believed.dof", None)):
        editor.edit(key, value)
    editor.edit("believed.cables[2].frame[2]", 3.6)
    written = editor.texts()[0]["text"]
    assert not editor.form()["problems"]
    assert "believed:" not in written
    assert "cable_6" not in written
    assert "  - {name: cable_3, frame: [3.5, -2.0, 3.6]}\n" in written
    nominal = editor.scenario().nominal
    assert nominal is not None
    assert nominal.platform.mass == 130


@pytest.mark.parametrize("name", ["believed", "cable_break", "cogiro_pulleys", "winch_fmu", "waypoints", "spherical"])
def test_every_field_takes_back_what_it_shows(name: str) -> None:
    """And the file stays as it was, to the letter."""
    editor = Editor(name)
    form = editor.form()
    assert not form["problems"]
    json.dumps(form, allow_nan=False)
    found = [each for tab in form["tabs"] for each in every(tab["fields"])]
    assert len({each["path"] for each in found}) == len(found)
    before = editor.texts()
    for each in found:
        if each["given"] and each["kind"] not in ("section", "list", "table"):
            editor.edit(each["path"], each["value"])
            assert editor.texts() == before, each["path"]


def test_invalid_nominal_values_of_a_cable_are_shown() -> None:
    editor = Editor("believed")
    editor.edit("believed.cables", [3, *({"diameter": 0.01} for _ in range(7))])
    first, second = fields(editor)["believed.cables"]["rows"][:2]
    assert first["odd"] == "3"
    assert second["cells"]["diameter"]["value"] == 0.01
    assert any(problem["key"] == "believed.cables[0]" for problem in editor.form()["problems"])
