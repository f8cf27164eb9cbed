"""Robots and scenarios built in Python: the same data, checks and bits as from files; saved, changed and sent."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
import yaml
from conftest import EXAMPLES, ROOT
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import cdpr
from cdpr.scenario import examples

pytestmark = pytest.mark.core

SIGNS = [[1, -1, -1], [-1, 1, 1], [-1, -1, 1], [1, 1, -1], [-1, -1, -1], [1, 1, 1], [1, -1, 1], [-1, 1, -1]]
FRAME = np.repeat([[-2.0, -1.5, 3.0], [2.0, -1.5, 3.0], [-2.0, 1.5, 3.0], [2.0, 1.5, 3.0]], 2, axis=0)
SHORT = {"duration": 0.02}


def built(mass=12.0, **changes):
    points = 0.5 * np.array(SIGNS) * [0.6, 0.4, 0.2]
    return cdpr.Robot.from_points(FRAME, points, mass=mass, **{"home": [0.0, 0.0, 1.2]} | changes)


def scenario(**changes):
    move = cdpr.motions.Quintic(duration=0.02, to=cdpr.motions.Knot(position=np.array([0.001, 0.0, 1.2])))
    push = cdpr.events.Wrench(time=0.01, duration=0.005, force=[10, 0, 0])
    parts = {"robot": built(), "simulation": SHORT, "trajectory": move, "events": [push]}
    return cdpr.Scenario(**parts | changes)


def message(make):
    with pytest.raises(cdpr.CdprError) as caught:
        make()
    return str(caught.value)


def same_bits(one, other):
    return np.array_equal(cdpr.simulate(one).rows, cdpr.simulate(other).rows, equal_nan=True)


@pytest.mark.parametrize("name", [each.name for each in examples.examples() if each.kind == "robot"])
def test_a_robot_is_data_and_back(name, tmp_path):
    robot = cdpr.load_robot(name)
    assert cdpr.load_robot(robot.to_dict()) == robot
    robot.save(tmp_path / "robot.yaml")
    assert cdpr.load_robot(tmp_path / "robot.yaml") == robot


@pytest.mark.parametrize("name", ["believed", "caroca", "cogiro_pulleys", "gcode", "external_wrench", "winch"])
def test_a_scenario_is_saved_as_it_was_given(name, tmp_path):
    loaded = cdpr.load_scenario(name)
    loaded.save(tmp_path / "folder" / "saved.yaml")
    assert cdpr.load_scenario(tmp_path / "folder" / "saved.yaml") == loaded


def test_all_forms_of_a_scenario_are_the_same(tmp_path):
    one = scenario()
    one.save(tmp_path / "saved.yaml")
    forms = [
        cdpr.load_scenario(tmp_path / "saved.yaml"),
        pickle.loads(pickle.dumps(one)),
        one.replace(events=one.events),
        cdpr.load_scenario(
            {"robot": built(), **{key: getattr(one, key) for key in ("simulation", "trajectory", "events")}}
        ),
    ]
    for other in forms:
        assert other == one
        assert hash(other) == hash(one)
        assert other.robot == one.robot == built()
        assert same_bits(other, one)
    assert one != scenario(events=[])
    assert "defaults" not in (text := (tmp_path / "saved.yaml").read_text())
    assert "physics_step" not in text  # given values only


number = st.floats(-0.4, 0.4, allow_subnormal=False)
vectors = st.tuples(number, number, number)


@st.composite
def robots(draw):
    points = 0.5 * np.array(SIGNS) * [0.6, 0.4, 0.2] * (1.0 + 0.1 * np.array(draw(vectors)))
    robot = cdpr.Robot.from_points(
        FRAME + np.array(draw(vectors)),
        points,
        mass=draw(st.floats(1.0, 50.0)),
        tension_max=draw(st.sampled_from([math.inf, 900.0, list(range(500, 580, 10))])),
        home=[*draw(vectors), *cdpr.model.rotations.from_rpy(*draw(vectors))],
        center_of_mass=np.array(draw(vectors)) * 0.1,
    )
    cables = [cable.replace(diameter=draw(st.sampled_from([None, 0.004]))) for cable in robot.cables]
    return robot.replace(cables=cables, name=draw(st.sampled_from(["robot", "no", "1e3", "a.b"])))


@st.composite
def scenarios(draw):
    robot = draw(robots())
    to = {"position": (robot.home[:3] + 0.001 * np.array(draw(vectors))).tolist()}
    motions = (
        cdpr.motions.Hold(),
        cdpr.motions.Quintic(duration=0.02, to=to),
        cdpr.motions.PickAndPlace(duration=0.02, height=0.001, to=to),
    )
    events = [
        cdpr.events.Wrench(time=0.005, force=draw(vectors)),
        cdpr.events.Sine(moment=draw(vectors), frequency=draw(st.floats(1.0, 100.0)), phase_deg=draw(number)),
        cdpr.events.CableJam(time=0.01, cable=draw(st.integers(1, 8))),
    ]
    return cdpr.Scenario(
        robot=robot,
        simulation={"duration": 0.02, "seed": draw(st.integers(0, 2**40))},
        trajectory=draw(st.sampled_from(motions)),
        events=draw(st.lists(st.sampled_from(events), unique_by=lambda event: event.type)),
        world={"gravity": (0.0, 0.0, draw(st.floats(-20.0, 0.0)))},
    )


@settings(max_examples=min(EXAMPLES, 15), deadline=None, suppress_health_check=list(HealthCheck))
@given(one=scenarios())
def test_any_scenario_is_saved_and_loaded_with_the_same_bits(one, tmp_path_factory):
    file = tmp_path_factory.mktemp("saved") / "one.yaml"
    one.save(file)
    other = cdpr.load_scenario(file)
    assert other == one
    assert other.robot == one.robot
    assert same_bits(other, one)
    one.robot.save(file)
    assert cdpr.load_robot(file) == one.robot


def test_replaced_sections_are_checked():
    one = scenario()
    heavier = one.replace(robot=one.robot.replace(platform=one.robot.platform.replace(mass=20.0)))
    assert heavier.robot.platform.mass == 20.0
    assert heavier.trajectory == one.trajectory
    assert one.with_changes({"trajectory": cdpr.motions.Hold()}).trajectory.type == "hold"
    assert "replace(trajectoy=): unknown section: did you mean 'trajectory'?" in message(
        lambda: one.replace(trajectoy=1)
    )
    pushed = one.replace(events=[{"type": "wrench", "time": 0, "force": [1, 2, 3]}], trajectory={"type": "hold"})
    assert pushed.replace(events=None, trajectory=None) == one.replace(events=None).replace(trajectory=None)
    assert pushed.replace(events=None).events == ()
    assert one.replace(nominal={"platform": {"mass": 9.0}}).replace(nominal=None) == one.replace(initial=None) == one
    assert message(lambda: one.replace(simulation=None)).startswith("simulation: required")
    late = {"type": "wrench", "time": -1, "force": [1, 2]}
    assert message(lambda: one.replace(events=[late])).splitlines() == [
        "events[0].force: expected 3 numbers (N), got 2",
        "events[0].time: must be at least 0 (s), got -1",
    ]


ARGUMENTS = {
    "Quintic(duration=): must be greater than 0 (s), got -1": lambda: cdpr.motions.Quintic(duration=-1, to={}),
    "Quintic(to=).position[2]: expected a finite number (m), got nan": lambda: cdpr.motions.Quintic(
        duration=1, to={"position": [0, 0, math.nan]}
    ),
    "Quintic(from_=).position: expected 3 numbers (m), got 2": lambda: cdpr.motions.Quintic(
        duration=1, from_={"position": np.zeros(2)}, to={}
    ),
    "Scenario(robot=, simulation=): expected arguments by name, got 'caroca'": lambda: cdpr.Scenario("caroca"),
    "Quintic: expected arguments by name, got 3": lambda: cdpr.motions.Quintic(3),
    "Knot(position=): expected 3 numbers (m), got 'home'": lambda: cdpr.motions.Knot(position="home"),
    "Wrench(time=): expected a number (s), got '1 s'; write 1, without the unit": lambda: cdpr.events.Wrench(
        time="1 s", force=[1, 2, 3]
    ),
    "Wrench(forse=): unknown key 'forse': did you mean 'force'?": lambda: cdpr.events.Wrench(forse=[1, 2, 3]),
    "Wrench: force (N) or moment (N m) is missing": lambda: cdpr.events.Wrench(),
    "Hold(position=): expected a number, a text, a list or a mapping, got set": lambda: cdpr.motions.Hold(position={1}),
    "Wrench(force=): masked values": lambda: cdpr.events.Wrench(force=np.ma.array([1.0, 2.0, 3.0], mask=[1, 0, 0])),
}


@pytest.mark.parametrize("text", ARGUMENTS)
def test_wrong_arguments_of_sections(text):
    assert message(ARGUMENTS[text]).startswith(text)


WRONG = {
    "simulation.duration: must be greater than 0 (s), got -1": {"simulation": {"duration": -1}},
    "simulation.x: unknown key 'x'": {"simulation": {"duration": 1, "x": 1}},
    "robot: there is no file 'caroc', and no example has that name: did you mean 'caroca'": {"robot": "caroc"},
    "robot: expected a number, a text, a list or a mapping, got object": {"robot": object()},
    "trajectory: expected a mapping (type, ": {"trajectory": 3},
    "controller.kp: expected ": {"controller": {"kp": "high"}},
    "foo: unknown key 'foo'": {"foo": 3},
    "robot.dof: no guide leaves ry, rz free": {"robot": built(dof=("ry", "rz"))},
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_sections(text):
    assert message(lambda: scenario(**WRONG[text])).startswith(text)


def test_all_problems_are_reported_together():
    lines = message(lambda: scenario(simulation={"duration": -1}, world={"gravity": [0, 1]}, limits="no")).splitlines()
    assert [line.partition(":")[0] for line in lines] == ["limits", "simulation.duration", "world.gravity"]


def test_every_robot_is_accepted_everywhere(tmp_path):
    robot = built()
    robot.save(tmp_path / "robot.yaml")
    scenario().save(tmp_path / "scenario.yaml")
    forms = (robot, robot.to_dict(), tmp_path / "robot.yaml", str(tmp_path / "scenario.yaml"), scenario())
    wanted = cdpr.distribute(robot, robot.home).tension
    for each in forms:
        assert np.array_equal(cdpr.distribute(each, robot.home).tension, wanted)
        assert cdpr.workspace(each, "closure", cells=3).region.cells == 12
    assert cdpr.admissible("caroca", cdpr.load_robot("caroca").home).feasible
    for verb in (lambda: cdpr.distribute(3, robot.home), lambda: cdpr.workspace([], "static")):
        assert message(verb).startswith("robot: expected a Robot, a file, an example's name, a dict or a Scenario, got")
    assert "Scenario, got a Robot; cdpr.Scenario(robot=robot, ...)" in message(lambda: cdpr.simulate(robot))
    assert "and no example has that name: did you mean 'caroca'?" in message(
        lambda: cdpr.distribute("caroc", robot.home)
    )


def test_infinite_limits_in_files(tmp_path):
    text = (ROOT / "scenarios" / "robots" / "caroca.yaml").read_text()
    assert "max: 10000" in text
    robot = cdpr.load_robot("endless", text=text.replace("max: 10000", "max: .inf"))
    assert set(robot.tension_max) == {math.inf}
    assert "expected a number, got nan" in message(
        lambda: cdpr.load_robot("x", text=text.replace("max: 10000", "max: .nan"))
    )
    run = cdpr.simulate({"robot": robot, "simulation": SHORT}, out=tmp_path / "run")
    assert np.array_equal(cdpr.load_run(tmp_path / "run").rows, run.rows)
    assert cdpr.view(run, tmp_path / "run.html").read_text()
    assert cdpr.view(robot, tmp_path / "robot.html").read_text()
    assert "inf" not in cdpr.export(robot, "mjcf", tmp_path / "robot.xml").read_text().partition("<actuator>")[2]
    assert message(lambda: cdpr.workspace(robot, "static", cells=3)).endswith("give tension_max")


VERBS = {
    "size(safety)": (lambda: cdpr.size("caroca", safety="x"), "safety: expected a number from 1 on, got 'x'"),
    "size": (lambda: cdpr.size(5), "expected a file, an example's name, a dict or a Scenario, got a int"),
    "design": (lambda: cdpr.design("design_box", "out", jobs="x"), "design(jobs=): expected a whole number from 1 on"),
    "study": (lambda: cdpr.study("thesis_belief", "out", jobs=0), "study(jobs=): expected a whole number from 1 on"),
    "study{}": (lambda: cdpr.study({"scenario": "caroca", "axes": 3}, "out"), "axes: expected a list, got 3"),
    "compare": (lambda: cdpr.compare(built()), "compare(what=): expected a scenario or a list of runs, got a Robot"),
    "workspace": (lambda: cdpr.workspace("caroca", "static", 3), "region: expected a cdpr.analysis.workspace.Region"),
    "export": (lambda: cdpr.export("caroca", "mjc"), "export(to=): expected one of mjcf, sdf, urdf, ros2, native"),
    "export-option": (lambda: cdpr.export("caroca", "urdf", style="x"), "export(style=): urdf has no options"),
    "import": (lambda: cdpr.import_file(5), "import_file(path=): expected a file name, got 5"),
    "view": (lambda: cdpr.view("caroca", "x.txt"), "view(out=): 'x.txt': expected the name of a new page"),
    "view-pose": (lambda: cdpr.view("caroca", "x.html", pose=[1]), "view(pose=): the shape must be (7,), got (1,)"),
    "save": (lambda: built().save(5), "save(path=): expected the name of a file that ends in .yaml, got 5"),
    "model": (
        lambda: scenario(robot=built().replace(cable_model="soft")),
        "Robot(cable_model=): expected one of ideal",
    ),
}


@pytest.mark.parametrize("verb", VERBS)
def test_wrong_arguments_of_verbs(verb, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, text = VERBS[verb]
    assert message(call).startswith(text)
    assert not list(tmp_path.iterdir())


def test_studies_and_designs_of_objects(tmp_path):
    one = scenario(name="mine")
    masses = {"scenario": one, "axes": [{"key": "robot.platform.mass", "values": [10.0, 12.0]}]}
    assert cdpr.study(masses, tmp_path / "study").counts == {"finished": 2}
    assert cdpr.rollout(one, 2, vary={"robot": [built(10.0), built(12.0)]}).status.tolist() == ["finished"] * 2
    assert cdpr.size([one, cdpr.simulate(one)]).cables == tuple(cable.name for cable in one.robot.cables)
    file = examples.find("design_box", "design").path
    given = yaml.safe_load(file.read_text())
    given["robot"] = cdpr.load_robot(file.parent / given["robot"])
    found = cdpr.design(given, tmp_path / "design", evaluations=2)
    assert found.rows[0].figures == cdpr.design("design_box", tmp_path / "other", evaluations=2).rows[0].figures


def test_motions_and_events_are_listed():
    assert set(dir(cdpr.motions)) >= {"Hold", "Quintic", "Gcode"}
    assert set(dir(cdpr.events)) >= {"Wrench", "CableBreak"}
