"""Content, writing and changes of loaded scenarios."""

from __future__ import annotations

import dataclasses
import pickle
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from scenario_cases import BASE, PLUGINS, ROBOT, TEXTS, WAYPOINTS, changed, load, problems, whole
from scipy.spatial.transform import Rotation

from cdpr.base.errors import ScenarioError
from cdpr.model import DOF_NAMES, Box, Sphere, rotations
from cdpr.scenario import Hold, Orientation, Quintic, Scenario, Waypoints, load_robot, load_scenario
from cdpr.scenario.robot_schema import ALL_DOF

SCENARIOS = ROOT / "scenarios"

SHORT = """\
robot:
  platform: {mass: 1, inertia: [1, 1, 1, 0, 0, 0]}
  tension: {min: 0, max: 10}
  cables:
  - {frame: [0, 0, 3], platform: [0, 0, 0]}
simulation: {duration: 1}
initial: {position: [0.1, 0.2, 1.0]}
"""


def test_the_shortest_scenario_and_all_defaults():
    scenario = load(SHORT)
    assert scenario.name == "a"
    assert scenario.source == "a.yaml"
    assert scenario.unused == ()
    assert scenario.world.gravity == (0, 0, -9.81)
    simulation = scenario.simulation
    assert (simulation.backend, simulation.duration, simulation.seed) == ("reference", 1.0, 0)
    assert (simulation.control_step, simulation.physics_step) == (0.001, 0.001)
    assert (simulation.steps, simulation.substeps) == (1000, 1)
    assert np.array_equal(scenario.initial.state(), [0.1, 0.2, 1.0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0])
    assert isinstance(scenario.trajectory, Hold)
    assert scenario.trajectory.position == (0.1, 0.2, 1.0)
    assert np.array_equal(scenario.trajectory.orientation.quaternion(), [1, 0, 0, 0])
    assert (scenario.controller.type, scenario.solver.type) == ("computed_torque", "qp")
    assert scenario.solver.infeasible == "best_effort"
    robot = scenario.robot
    assert (robot.name, robot.dof, robot.unilateral) == ("robot", DOF_NAMES, True)
    assert robot.platform.shape is None
    assert np.array_equal(robot.platform.center_of_mass, np.zeros(3))
    assert [cable.name for cable in robot.cables] == ["cable_1"]


def test_invalid_file_names_are_reported():
    for loader, own in ((load_scenario, "Scenario"), (load_robot, "Robot")):
        with pytest.raises(ScenarioError, match=f"expected a file, an example's name, a dict or a {own}, got a list"):
            loader(["caroca.yaml"])


def test_the_physics_step_follows_the_control_step():
    simulation = load(changed(SHORT, "duration: 1", "duration: 1, control_step: 0.01")).simulation
    assert (simulation.physics_step, simulation.steps, simulation.substeps) == (0.01, 100, 1)


def test_the_robot_of_the_full_text():
    robot = load().robot
    assert robot.name == "tripod"
    platform = robot.platform
    assert platform.mass == 150
    assert np.array_equal(platform.inertia, [[6.5, 0.1, 0.2], [0.1, 20, 0.3], [0.2, 0.3, 22.5]])
    assert np.array_equal(platform.center_of_mass, [0.01, 0.02, 0.03])
    assert platform.shape == Box((1.2, 0.6, 0.4))
    first, second, third = robot.cables
    assert (first.name, second.name, third.name) == ("left", "cable_2", "cable_3")
    assert np.array_equal(first.frame, [-3.5, -2, 3.5])
    assert np.array_equal(first.platform, [0.6, -0.3, -0.2])
    limits = [(cable.tension_min, cable.tension_max) for cable in robot.cables]
    assert limits == [(40, 9500), (50, 9000), (50, 8000)]
    assert (first.diameter, first.axial_stiffness, first.linear_density) == (0.006, 1e6, 0.15)
    assert (first.length_min, first.length_max, first.speed_max) == (0.5, 12, 2.5)
    assert second.diameter is second.length_min is second.speed_max is None
    with pytest.raises(ValueError, match="read-only"):
        first.frame[0] = 1.0


def test_a_sphere():
    robot = load_robot("r.yaml", text=changed(ROBOT, "{box: [1.2, 0.6, 0.4]}", "{sphere: 0.2}"))
    assert robot.platform.shape == Sphere(0.2)


def test_the_names_of_the_degrees_of_freedom_are_the_models():
    assert ALL_DOF == DOF_NAMES


def test_a_scenario_cannot_be_changed_in_place():
    scenario = load()
    with pytest.raises(dataclasses.FrozenInstanceError):
        scenario.robot = None
    with pytest.raises(ValidationError):
        scenario.simulation.duration = 3.0


# Orientations

angles = st.lists(st.floats(-7, 7), min_size=3, max_size=3)


def attitude(text: str) -> np.ndarray:
    return load(changed(BASE, "{quaternion: [1, 0, 0, 0]}", text)).initial.orientation.quaternion()


@given(angles)
def test_rpy_is_about_fixed_axes(rpy):
    R = rotations.matrix(attitude(f"{{rpy: {rpy}}}"))
    assert np.allclose(R, Rotation.from_euler("xyz", rpy).as_matrix(), atol=1e-12)


@given(angles, st.sampled_from(["XYZ", "xyz", "ZYX", "ZXZ", "zxz", "YXY", "yzx"]))
def test_euler_angles_follow_scipy(values, order):
    R = rotations.matrix(attitude(f"{{euler: {{angles: {values}, order: {order}}}}}"))
    assert np.allclose(R, Rotation.from_euler(order, values).as_matrix(), atol=1e-12)


@given(
    st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1),
    st.floats(-9e-4, 9e-4),
)
def test_quaternions_are_normalised(q, error):
    unit = np.array(q) / np.linalg.norm(q)
    given_ = [float(value) for value in unit * (1 + error)]
    assert np.allclose(attitude(f"{{quaternion: {given_}}}"), unit, atol=1e-15)


# Trajectories


def test_a_quintic_begins_and_ends_at_the_initial_pose_by_default():
    scenario = load(SHORT + "trajectory: {type: quintic, duration: 0.5, to: {position: [1, 1, 1]}}\n")
    motion = scenario.trajectory
    assert isinstance(motion, Quintic)
    assert (motion.start, motion.duration, motion.end) == (0, 0.5, 0.5)
    assert (motion.from_.position, motion.to.position) == ((0.1, 0.2, 1.0), (1, 1, 1))
    for knot in (motion.from_, motion.to):
        assert np.array_equal(knot.orientation.quaternion(), [1, 0, 0, 0])
        for name in ("velocity", "angular_velocity", "acceleration", "angular_acceleration"):
            assert getattr(knot, name) == (0, 0, 0)


def test_a_quintic_with_everything():
    motion = load().trajectory
    assert (motion.start, motion.end) == (0.5, 3.5)
    assert motion.from_.acceleration == (0, 0, 0.5)
    assert motion.to.orientation.euler.order == "XYZ"


def test_the_initial_orientation_is_taken_over():
    text = SHORT + "trajectory: {type: quintic, duration: 0.5, to: {}}\n"
    text = changed(text, "position: [0.1, 0.2, 1.0]", "position: [0, 0, 1], orientation: {rpy: [0, 0, 0.5]}")
    expected = rotations.from_rpy(0, 0, 0.5)
    assert np.allclose(load(text).trajectory.to.orientation.quaternion(), expected)
    assert np.allclose(load(text).trajectory.from_.orientation.quaternion(), expected)


def test_waypoints_after_time_0_start_at_the_initial_pose_at_rest():
    points = "[{time: 0.5, position: [1, 1, 1]}, {time: 1, position: [2, 2, 2]}]"
    motion = load(SHORT + f"trajectory: {{type: waypoints, points: {points}}}\n").trajectory
    assert isinstance(motion, Waypoints)
    assert [point.time for point in motion.points] == [0, 0.5, 1]
    first, inner, last = motion.points
    assert first.position == (0.1, 0.2, 1.0)
    for end in (first, last):
        assert end.velocity == end.angular_velocity == end.acceleration == end.angular_acceleration == (0, 0, 0)
    assert inner.velocity is inner.angular_velocity is inner.acceleration is inner.angular_acceleration is None
    assert np.array_equal(inner.orientation.quaternion(), [1, 0, 0, 0])
    assert motion.end == 1


def test_waypoints_from_time_0_keep_their_first_point():
    points = "[{time: 0, position: [1, 1, 1], acceleration: [1, 0, 0]}, {time: 1, position: [2, 2, 2]}]"
    motion = load(SHORT + f"trajectory: {{type: waypoints, points: {points}}}\n").trajectory
    assert [point.position for point in motion.points] == [(1, 1, 1), (2, 2, 2)]
    assert motion.points[0].acceleration == (1, 0, 0)
    assert motion.points[0].velocity == (0, 0, 0)


def test_given_derivatives_of_waypoints_are_kept():
    motion = load(whole(WAYPOINTS)).trajectory
    assert motion.points[1].acceleration == (0, 0, 0.5)
    assert motion.points[1].velocity == (0, 0, 0)


def test_a_hold_elsewhere():
    motion = load(TEXTS["hold"]).trajectory
    assert motion.position == (1, 0, 1)
    assert np.allclose(motion.orientation.quaternion(), rotations.from_rpy(0, 0, 0.1))


# Written content


@pytest.mark.parametrize("text", [*TEXTS.values(), SHORT], ids=[*TEXTS, "short"])
def test_the_resolved_text_loads_to_an_equal_scenario(text):
    scenario = load(text)
    resolved = scenario.resolved_yaml()
    again = load_scenario("elsewhere/b.yaml", text=resolved, plugins=PLUGINS)
    assert again == scenario
    assert again.resolved_yaml() == resolved
    assert hash(again) == hash(scenario)
    assert np.array_equal(again.robot.inertial, scenario.robot.inertial)
    assert np.array_equal(again.initial.state(), scenario.initial.state())


def test_the_resolved_text_is_complete():
    resolved = load(SHORT).resolved_yaml()
    for part in (
        "name: a\n",
        "gravity: [0.0, 0.0, -9.81]\n",
        "physics_step: 0.001\n",
        "- name: cable_1\n",
        "seed: 0\n",
    ):
        assert part in resolved
    for part in (
        "type: hold\n  position: [0.1, 0.2, 1.0]\n",
        "type: computed_torque\n  kp: 10.0\n",
        "infeasible: best_effort\n",
    ):
        assert part in resolved


def test_the_resolved_text_holds_the_changes_and_the_options_of_the_chosen_backend():
    scenario = load(SHORT, "robot.platform.mass=1e-5", backend="tuned")
    resolved = scenario.resolved_yaml()
    assert "mass: 1e-05\n" in resolved
    assert "tuned:\n    integrator: euler\n    tolerance: 1e-08\n" in resolved
    assert load(resolved) == scenario


def test_the_order_of_the_keys_does_not_matter():
    lines = SHORT.splitlines(keepends=True)
    assert load("".join(lines[5:] + lines[:5])).resolved_yaml() == load(SHORT).resolved_yaml()


@given(st.floats(1e-9, 1e9), st.floats(-1e3, 1e3), st.integers(0, 2**63 - 1))
def test_no_digit_is_lost(mass, x, seed):
    scenario = load(BASE, f"robot.platform.mass={mass!r}", f"robot.cables[0].frame[0]={x!r}", f"simulation.seed={seed}")
    again = load(scenario.resolved_yaml())
    assert again.robot.platform.mass == mass
    assert again.robot.cables[0].frame[0] == x
    assert again.simulation.seed == seed


def test_scenarios_that_differ_are_not_equal():
    assert load() == load()
    assert load() != load(BASE, "simulation.seed=8")
    assert load() != load(BASE, "controller.kp=101")
    assert load() != load(BASE, "backend_options.tuned.tolerance=1e-5")
    assert load() != "a scenario"


# Changes


def test_changes_are_checked_and_leave_the_original():
    scenario = load()
    other = scenario.with_changes({"simulation.duration": 2.0}, backend="reference", controller="none")
    assert (scenario.simulation.duration, other.simulation.duration) == (4.0, 2.0)
    assert (other.simulation.backend, other.controller.type) == ("reference", "none")
    assert other.unused[-2:] == ("controller.kp", "controller.kd")
    assert scenario.controller.type == "gains"
    assert other == load(BASE, "simulation.duration=2", backend="reference", controller="none")
    with pytest.raises(ScenarioError, match=r"^--set simulation.duration=x: simulation.duration: expected a number"):
        scenario.with_changes(["simulation.duration=x"])
    assert scenario == load()


def test_defaults_that_follow_other_keys_follow_the_changes():
    scenario = load(SHORT)
    other = scenario.with_changes({"initial.position": [0, 0, 2], "simulation.control_step": 0.01})
    assert other.trajectory.position == (0, 0, 2)
    assert other.simulation.physics_step == 0.01


def test_changes_of_changes():
    scenario = load().with_changes(["robot.platform.mass=3"]).with_changes(["simulation.seed=9"])
    assert (scenario.robot.platform.mass, scenario.simulation.seed) == (3, 9)
    assert scenario.name == "every-key"


def test_another_robot_file_is_found_from_the_scenario(tmp_path):
    (tmp_path / "r.yaml").write_text(ROBOT)
    scenario = load_scenario(tmp_path / "a.yaml", text=SHORT, plugins=PLUGINS)
    assert scenario.with_changes({"robot": "r.yaml"}).robot.name == "tripod"


def test_a_scenario_can_be_sent_to_another_process():
    scenario = load()
    assert pickle.loads(pickle.dumps(scenario)) == scenario


# The shipped files


@pytest.mark.parametrize("file", sorted(SCENARIOS.glob("*.yaml")), ids=lambda file: file.stem)
def test_shipped_scenarios(file):
    assert file.read_text().startswith("# ")
    scenario = load_scenario(file)
    assert isinstance(scenario, Scenario)
    assert scenario.name == file.stem
    assert scenario.unused == ()
    assert load_scenario(SCENARIOS / "x.yaml", text=scenario.resolved_yaml()) == scenario


@pytest.mark.parametrize("file", sorted((SCENARIOS / "robots").glob("*.yaml")), ids=lambda file: file.stem)
def test_shipped_robots(file):
    assert file.read_text().startswith("# ")
    assert load_robot(file).name == file.stem


def test_caroca():
    scenario = load_scenario(SCENARIOS / "caroca.yaml")
    robot = scenario.robot
    assert (robot.m, robot.platform.mass) == (8, 150)
    assert np.array_equal(np.diag(robot.platform.inertia), [6.5, 20.0, 22.5])
    assert set(robot.tension_min) == {50}
    assert set(robot.tension_max) == {10000}
    assert np.array_equal(np.abs(robot.anchors), np.tile([3.5, 2, 3.5, 0.6, 0.3, 0.2], (8, 1)))
    assert scenario.initial.position == (0, 0, 1.2)
    assert scenario.trajectory.to.position == (1.5, 0.5, 1.6)
    assert (scenario.trajectory.end, scenario.simulation.duration) == (3, 4)


def test_thesis():
    scenario = load_scenario(SCENARIOS / "thesis.yaml")
    robot = scenario.robot
    assert (robot.m, robot.platform.mass) == (8, 50)
    a, b, c = robot.platform.shape.size
    expected = 50 / 12 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    assert np.allclose(np.diag(robot.platform.inertia), expected, rtol=1e-15)
    assert sorted(set(robot.anchors[:, 2])) == [3.5, 3.5001]
    assert scenario.world.gravity == (0, 0, -9.8)
    assert scenario.initial.position == (0, -2, 2)
    assert scenario.trajectory.to.position == (0, 0, 2)
    assert (scenario.trajectory.duration, scenario.simulation.steps) == (100, 100_000)


@pytest.mark.slow
def test_models_are_made_into_validators_when_first_used():
    """Most of them, of events, motions and parts, a run never needs."""
    code = (
        "import cdpr.scenario.loader; from cdpr.plugins.registry import registry; registry();"
        "from cdpr.base.fields import Section; from cdpr.plugins.info import PluginOptions;"
        "below = lambda kind: {kind}.union(*map(below, kind.__subclasses__()));"
        "print(sum(each.__pydantic_complete__ for each in below(Section) | below(PluginOptions)),"
        "len(below(Section) | below(PluginOptions)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    made, known = map(int, done.stdout.split())
    assert known > 60
    assert made < 10  # some have an object as default


def test_unchanged_values_are_not_checked_again(monkeypatch):
    loaded = load_scenario(SCENARIOS / "caroca.yaml")
    monkeypatch.setattr("cdpr.scenario.scenario.build_scenario", None)
    assert loaded.with_changes({}, plugins=loaded.plugins) is loaded


def test_orientations_are_independent():
    assert np.array_equal(Orientation(rpy=(0.0, 0.0, 0.0)).quaternion(), [1, 0, 0, 0])
    assert problems(changed(BASE, "{quaternion: [1, 0, 0, 0]}", "{roll: 1}"))


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_the_texts_that_hold_every_key_load(text):
    assert load(text).name == "every-key"
