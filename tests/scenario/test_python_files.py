"""Sections and files of scenarios built in Python: sections keep their options, and files their places."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

import cdpr
from cdpr.analysis.design import load_design
from cdpr.scenario import examples

pytestmark = pytest.mark.core

FRAME = np.repeat([[-2.0, -1.5, 3.0], [2.0, -1.5, 3.0], [-2.0, 1.5, 3.0], [2.0, 1.5, 3.0]], 2, axis=0)
POINTS = np.array([[3, -2, -1], [-3, 2, 1], [-3, -2, 1], [3, 2, -1], [-3, -2, -1], [3, 2, 1], [3, -2, 1], [-3, 2, -1]])
SHORT = {"duration": 0.02}


def built(**changes):
    return cdpr.Robot.from_points(
        FRAME, 0.1 * POINTS, mass=12.0, home=[0.0, 0.0, 1.2], tension_min=1.0, tension_max=800.0
    ).replace(**changes)


def scenario(**changes):
    return cdpr.Scenario(**{"robot": built(), "simulation": SHORT} | changes)


def message(make):
    with pytest.raises(cdpr.CdprError) as caught:
        make()
    return str(caught.value)


@pytest.mark.parametrize("name", [each.name for each in examples.examples() if each.kind == "scenario"])
def test_a_section_in_its_own_place_changes_nothing(name):
    one = cdpr.load_scenario(name)
    sections = {key: section for key, section in one.sections if section is not None}
    for key, section in sections.items():
        other = one.replace(**{key: section})
        assert (key, other.resolved_yaml()) == (key, one.resolved_yaml())
        assert (other.unused, other.notes) == (one.unused, ())
    assert one.replace(**sections) == one


def test_sections_keep_the_options_of_their_plugins():
    one = scenario(
        controller={"type": "computed_torque", "kp": 77.0},
        solver={"type": "p_norm", "p": 4, "infeasible": "stop"},
        backend_options={"reference": {"scheme": "semi_implicit_euler"}},
    )
    names = ("controller", "solver")
    other = scenario(**{name: getattr(one, name) for name in names}, backend_options=one.sections.backend_options)
    assert other == one
    assert other.controller_options.kp == 77.0
    assert other.solver_options.p == 4
    assert other.replace(controller=scenario().controller).controller_options.kp != 77.0
    assert cdpr.load_scenario({"robot": built(), "simulation": SHORT, "controller": one.controller}).controller == (
        one.controller
    )
    assert one.with_changes({"controller": one.controller}) == one


def test_options_given_with_another_plugin_are_kept():
    one = scenario(controller={"type": "computed_torque", "kp": 77.0})
    other = one.replace(controller={"type": "pid", "kp": 55.0})
    assert other.controller_options.kp == 55.0
    assert not other.unused


TETRAHEDRON = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
MOTION = "t,x,y,z\n0,0,0,1.2\n0.01,0,0,1.2\n0.02,0,0,1.2\n"


@pytest.fixture
def folders(tmp_path, monkeypatch):
    """Folders `one`, which is the working folder, and `two`, with files of the same names but other content."""
    for i, name in enumerate(("one", "two"), start=1):
        (tmp_path / name).mkdir()
        (tmp_path / name / "mesh.obj").write_text(TETRAHEDRON.format(0.1 * i))
        (tmp_path / name / "p.csv").write_text(MOTION)
        (tmp_path / name / "rob.yaml").write_text(yaml.safe_dump(_with_mesh("mesh.obj")))
        scenario(name=name).save(tmp_path / name / "scenario.yaml")
    monkeypatch.chdir(tmp_path / "one")
    return tmp_path


def _with_mesh(file):
    data = built().to_dict()
    data["platform"]["shape"] = {"mesh": file}
    return data


def test_a_mesh_stays_with_its_robot(folders):
    robot = cdpr.load_robot("rob.yaml")
    assert robot.platform.shape.file == str(folders / "one" / "mesh.obj")
    other = cdpr.load_scenario(folders / "two" / "scenario.yaml")
    scenarios = [
        other.replace(robot=robot),
        other.with_changes({"robot": robot}),
        cdpr.load_scenario(folders / "two" / "scenario.yaml", overrides={"robot": robot}),
        cdpr.Scenario(robot=robot, simulation=SHORT),
        cdpr.Scenario(robot=robot.to_dict(), simulation=SHORT),
    ]
    assert {each.robot.platform.shape.file for each in scenarios} == {robot.platform.shape.file}
    scenarios[0].save(folders / "three" / "saved.yaml")
    assert cdpr.load_scenario(folders / "three" / "saved.yaml").robot == robot
    assert "/" + "one/mesh.obj" in (folders / "three" / "saved.yaml").read_text()
    assert str(folders) not in (folders / "three" / "saved.yaml").read_text()
    assert cdpr.load_robot(robot.to_dict()) == robot
    robot.save(folders / "three" / "robot.yaml")
    assert cdpr.load_robot(folders / "three" / "robot.yaml") == robot


def test_files_of_a_scenario_do_not_depend_on_the_working_folder_later(folders, monkeypatch):
    obstacle = {"mesh": "mesh.obj", "position": [0.0, 5.0, 0.0]}
    one = scenario(
        robot="rob.yaml", trajectory=cdpr.motions.Csv(file="p.csv"), world={"obstacles": [obstacle]}, name="mine"
    )
    rows = cdpr.simulate(one.replace()).rows
    monkeypatch.chdir(folders / "two")
    (folders / "two" / "p.csv").unlink()
    assert np.max(one.obstacles[0].shape.corners) == 0.1
    one.save(folders / "three" / "saved.yaml")
    loaded = cdpr.load_scenario(folders / "three" / "saved.yaml")
    assert loaded == one
    for each in (one, loaded, one.with_changes({"name": "other"}), one.replace(robot=built(name="other"))):
        assert np.array_equal(cdpr.simulate(each).rows, rows)
    assert np.array_equal(cdpr.simulate(one, out=folders / "run").rows, rows)
    assert np.array_equal(cdpr.simulate(folders / "run" / "scenario.yaml").rows, rows)
    masses = {"scenario": one, "axes": [{"key": "robot.platform.mass", "values": [10.0, 12.0]}]}
    assert cdpr.study(masses, folders / "study").counts == {"finished": 2}


def test_files_of_a_loaded_scenario_do_not_depend_on_the_working_folder_later(folders, monkeypatch):
    scenario(robot="rob.yaml", trajectory=cdpr.motions.Csv(file="p.csv")).save("loaded.yaml")
    one = cdpr.load_scenario("loaded.yaml")
    text = one.resolved_yaml()
    rows = cdpr.simulate(one).rows
    monkeypatch.chdir(folders / "two")
    one.save(folders / "three" / "saved.yaml")
    for each in (one.with_changes({"name": "other"}), cdpr.load_scenario(folders / "three" / "saved.yaml")):
        assert each.robot.platform.shape.file == str(folders / "one" / "mesh.obj")
        assert np.array_equal(cdpr.simulate(each).rows, rows)
    assert one.resolved_yaml() == text


def test_absolute_file_names_are_for_python_only(folders, monkeypatch):
    robot, motion = folders / "two" / "rob.yaml", cdpr.motions.Csv(file=folders / "two" / "p.csv")
    one = scenario(robot=robot, trajectory=motion)
    assert one.robot.platform.shape.file == str(folders / "two" / "mesh.obj")
    other = cdpr.load_scenario("scenario.yaml").replace(robot=str(robot), trajectory=motion)
    renamed = [each.replace(name="same", robot=each.robot.replace(name="same")) for each in (one, other)]
    assert renamed[0] == renamed[1]
    assert one.with_changes({"trajectory.file": str(folders / "one" / "p.csv")}).trajectory.file == "p.csv"
    file = folders / "scenario.yaml"
    file.write_text(yaml.safe_dump({"robot": str(robot), "simulation": SHORT}))
    assert "expected a file name relative to this file" in message(lambda: cdpr.load_scenario(file))
    assert "expected a file name relative to this file" in message(
        lambda: one.with_changes([f"trajectory.file={folders / 'one' / 'p.csv'}"])
    )
    masses = [{"key": "robot.platform.mass", "values": [10.0]}]
    study = {"scenario": str(folders / "two" / "scenario.yaml"), "axes": masses}
    assert cdpr.study(study, folders / "study").counts == {"finished": 1}
    file = examples.find("design_box", "design").path
    design = yaml.safe_load(file.read_text())
    design["robot"] = str((file.parent / design["robot"]).resolve())
    assert len(cdpr.design(design, folders / "design", evaluations=1).rows) == 2
    design["robot"] = cdpr.load_robot(design["robot"])
    shape = cdpr.load_robot(robot).platform.shape
    design["robot"] = design["robot"].replace(platform=design["robot"].platform.replace(shape=shape))
    loaded = load_design(design, evaluations=1)
    monkeypatch.chdir(folders)
    assert loaded.candidate(None).platform.shape == shape


def test_a_robot_saved_in_a_linked_folder_finds_its_mesh(folders):
    (folders / "deep" / "down").mkdir(parents=True)
    (folders / "link").symlink_to(folders / "deep" / "down")
    robot = cdpr.load_robot("rob.yaml")
    one = scenario(robot=robot)
    robot.save(folders / "link" / "saved.yaml")
    one.save(folders / "link" / "scenario.yaml")
    assert cdpr.load_robot(folders / "link" / "saved.yaml") == robot
    assert cdpr.load_scenario(folders / "link" / "scenario.yaml").robot == robot
    assert cdpr.load_scenario(folders / "link" / "scenario.yaml") == one


UNUSED = {
    "trajectry: unknown key 'trajectry': did you mean 'trajectory'?": lambda: scenario(trajectry=None),
    "nominal: another spelling of 'believed', which is given: remove one of them": lambda: scenario(
        nominal={"platform": {"mass": 13.0}}, believed={"platform": {"mass": 14.0}}
    ),
    "replace(nominal=): another spelling of 'believed', which is given: remove one of them": lambda: scenario().replace(
        nominal={"platform": {"mass": 13.0}}, believed={"platform": {"mass": 14.0}}
    ),
    "load_scenario(text=): replaces the text of a file, got a dict": lambda: cdpr.load_scenario({}, text="["),
    "load_scenario(text=): replaces the text of a file, got a Scenario": lambda: cdpr.load_scenario(
        scenario(), text="["
    ),
    "load_scenario(files=): replaces the text of a file, got a Scenario": lambda: cdpr.load_scenario(
        scenario(), files={"a": "["}
    ),
    "load_robot(text=): replaces the text of a file, got a Robot": lambda: cdpr.load_robot(built(), text="["),
    "controller: expected texts as keys, got 1": lambda: scenario(controller={1: 2, "1": 3}),
    "expected texts as keys, got null": lambda: cdpr.load_scenario({None: 3}),
    "overrides: robot.platform.tools: expected texts as keys, got 1": lambda: scenario().with_changes(
        {"robot.platform.tools": {1: [0, 0, 0]}}
    ),
    "Quintic(to=): expected texts as keys, got 3": lambda: cdpr.motions.Quintic(duration=1, to={3: 4}),
}


@pytest.mark.parametrize("text", UNUSED)
def test_nothing_is_ignored(text):
    assert message(UNUSED[text]).startswith(text)
