"""Physically impossible robots and runs are rejected with the reason; unusual ones are accepted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenario_cases import BASE, ROBOT, WAYPOINTS, changed, line_of, load, problem, problems, whole

from cdpr.base.errors import ScenarioError
from cdpr.model import rotations
from cdpr.scenario import load_robot
from cdpr.scenario.robot_schema import TRIANGLE_TOLERANCE

pytestmark = pytest.mark.core

INERTIA = "inertia: [6.5, 20.0, 22.5, 0.1, 0.2, 0.3]"
STEPS = "duration: 4.0, control_step: 0.001, physics_step: 5e-4"


def robot_problem(old: str, new: str) -> str:
    with pytest.raises(ScenarioError) as caught:
        load_robot("r.yaml", text=changed(ROBOT, old, new))
    (only,) = caught.value.problems
    return only


@pytest.mark.parametrize(
    ("inertia", "what"),
    [
        ("[1, 1, 5, 0, 0, 0]", "principal moments are 1, 1, 5 kg m^2, the largest exceeds the sum"),
        ("[1, 1, 2.0001, 0, 0, 0]", "the largest exceeds the sum of the two others"),
        ("[-1, 1, 1, 0, 0, 0]", "principal moments are -1, 1, 1 kg m^2, each must be greater than 0"),
        ("[0, 1, 1, 0, 0, 0]", "each must be greater than 0"),
        ("[0, 0, 0, 0, 0, 0]", "each must be greater than 0"),
        ("[1, 1, 1, 2, 0, 0]", "each must be greater than 0"),  # indefinite by its products
        ("[1, 1, 1, 0, 0, 1.0]", "each must be greater than 0"),  # singular
        ("[1e300, 1, 1, 0, 0, 0]", "must lie between"),
    ],
)
def test_inertias_that_no_body_has(inertia, what):
    assert what in robot_problem(INERTIA, f"inertia: {inertia}")


@pytest.mark.parametrize(
    "inertia",
    [
        "[1, 1, 2, 0, 0, 0]",  # a flat plate: equality
        "[0.333333, 0.333333, 0.666667, 0, 0, 0]",  # the same, rounded
        "[1e-6, 1, 1, 0, 0, 0]",  # a rod
        "[36.598, 35.982, 25.439, -0.453, 3.012, -1.539]",  # CoGiRo's
    ],
)
def test_inertias_that_some_body_has(inertia):
    robot = load_robot("r.yaml", text=changed(ROBOT, INERTIA, f"inertia: {inertia}"))
    assert np.all(np.linalg.eigvalsh(robot.platform.inertia) > 0)


ALL_FREE = "dof: [x, y, z, rx, ry, rz]"
BARE = {"x": [0] * 6, "ry": [0, 0.4, 0, 0, 0, 0], "rx": [0.4, 0, 0, 0, 0, 0], "rz": [0, 0, 0.4, 0, 0, 0]}


@pytest.mark.parametrize("last", BARE)
def test_moments_that_have_no_effect_may_be_zero(last):
    """As planar robots are published; `test_held_moments_have_no_effect` checks the motion."""
    dof = ["x"] if last == "x" else ["x", "z", last]
    bare, full = (
        load_robot("r.yaml", text=changed(changed(ROBOT, INERTIA, f"inertia: {entries}"), ALL_FREE, f"dof: {dof}"))
        for entries in (BARE[last], [max(entry, 0.3) for entry in BARE[last][:3]] + [0, 0, 0])
    )
    axis = [last == name for name in ("rx", "ry", "rz")]
    np.testing.assert_array_equal(*(robot.platform.inertia.diagonal()[axis] for robot in (bare, full)))
    assert np.all(np.linalg.eigvalsh(bare.platform.inertia) > 0)


@pytest.mark.parametrize("dof", ["[x, z, rx]", "[rz]", "[rx, ry, rz]", "[x, y, z, rx, ry, rz]"])
def test_the_moment_about_a_free_direction_is_needed(dof):
    text = changed(changed(ROBOT, INERTIA, "inertia: [0, 0.4, 0, 0, 0, 0]"), ALL_FREE, f"dof: {dof}")
    with pytest.raises(
        ScenarioError, match=r"platform.inertia: no rigid body has this inertia: .* where it turns about"
    ):
        load_robot("r.yaml", text=text)


@given(
    st.lists(st.floats(0.1, 10), min_size=3, max_size=3),
    st.lists(st.floats(-3, 3), min_size=3, max_size=3),
    st.booleans(),
)
def test_turning_a_body_does_not_change_whether_it_can_exist(masses, rpy, possible):
    """Second moments a, b, c >= 0 give principal moments b + c, c + a, a + b; a negative one is not a body's."""
    a, b, c = masses
    if not possible:
        a = -a
    principal = np.array([b + c, c + a, a + b])
    R = rotations.matrix(rotations.from_rpy(*rpy))
    tensor = R @ np.diag(principal) @ R.T
    entries = [tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2]]
    text = changed(ROBOT, INERTIA, f"inertia: {[float(entry) for entry in entries]}")
    if possible:
        assert np.allclose(load_robot("r.yaml", text=text).platform.inertia, tensor)
    else:
        with pytest.raises(ScenarioError, match="no rigid body has this inertia"):
            load_robot("r.yaml", text=text)


def test_the_rounding_that_a_published_inertia_may_have():
    for share, fine in [(0.5, True), (2.0, False)]:
        largest = 2.0 / (1.0 - share * TRIANGLE_TOLERANCE)
        text = changed(ROBOT, INERTIA, f"inertia: [1, 1, {largest!r}, 0, 0, 0]")
        if fine:
            load_robot("r.yaml", text=text)
        else:
            with pytest.raises(ScenarioError):
                load_robot("r.yaml", text=text)


TENSION = "tension: {min: 50, max: [10000, 9000, 8000]}"


@pytest.mark.parametrize(
    ("tension", "key", "what"),
    [
        ("{min: -1, max: 100}", "tension.min", "must be at least 0 (N), got -1: a cable cannot push"),
        (
            "{min: 0, max: 0}",
            "tension.max",
            "must be greater than 0 (N), got 0: a cable must be able to pull",
        ),
        ("{min: 0, max: -5}", "tension.max", "must be greater than 0 (N), got -5"),
        (
            "{min: 200, max: 100}",
            "tension.min",
            "must not exceed the highest tension of this cable, 100 (N), got 200",
        ),
        (
            "{min: [1, 1, 200], max: 100}",
            "tension.min[2]",
            "must not exceed the highest tension of this cable, 100 (N)",
        ),
        (
            "{min: 5, max: [100, 100, 4]}",
            "tension.min",
            "must not exceed the highest tension of this cable, 4 (N), got 5",
        ),
        ("{min: [1, 1], max: 100}", "tension.min", "expected 3 numbers (N), one per cable, got 2"),
        ("{min: 1, max: [1, 2, 3, 4]}", "tension.max", "expected 3 numbers (N), one per cable, got 4"),
    ],
)
def test_tension_limits(tension, key, what):
    text = changed(ROBOT, "  tension: {min: 40, max: 9500}\n", "")
    with pytest.raises(ScenarioError) as caught:
        load_robot("r.yaml", text=changed(text, TENSION, f"tension: {tension}"))
    (only,) = caught.value.problems
    assert only.startswith(f"r.yaml:{line_of(ROBOT, TENSION)}:")
    assert f": {key}: " in only
    assert what in only


def test_tension_limits_of_one_cable():
    assert "cables[0].tension.min: must not exceed" in robot_problem("{min: 40, max: 9500}", "{min: 9501, max: 9500}")
    assert "cables[0].tension.max: must be greater" in robot_problem("{min: 40, max: 9500}", "{max: 0}")
    # The robot's minimum against the cable's own maximum:
    assert "tension.min: must not exceed the highest tension of this cable, 30" in robot_problem(
        "{min: 40, max: 9500}", "{max: 30}"
    )


def test_equal_limits_and_zero_minimum_are_fine():
    load_robot("r.yaml", text=changed(ROBOT, "{min: 40, max: 9500}", "{min: 100, max: 100}"))
    assert load_robot("r.yaml", text=changed(ROBOT, "{min: 40", "{min: 0")).tension_min[0] == 0


def test_rigid_legs_may_push():
    text = changed(changed(ROBOT, "unilateral: true", "unilateral: false"), "{min: 40", "{min: -9500")
    robot = load_robot("r.yaml", text=text)
    assert not robot.unilateral
    assert list(robot.tension_min) == [-9500, 50, 50]
    assert list(robot.tension_max) == [9500, 9000, 8000]


def test_cables_that_coincide_at_both_ends_are_one():
    again = "- {frame: [3.5, -2.0, 3.5000001], platform: [-0.6, -0.3, 0.2]}"
    line = robot_problem("- {frame: [3.5, 2.0, 3.5], platform: [0.6, 0.3, -0.2]}", again)
    assert line.startswith(
        f"r.yaml:{line_of(ROBOT, '3.5, 2.0, 3.5')}:3: cables[2]: coincides with cables[1] at both ends"
    )


@pytest.mark.parametrize(
    "cable",
    [
        "{frame: [3.5, -2.0, 3.5], platform: [-0.6, -0.3, 0.21]}",
        "{frame: [3.5, -2.0, 3.51], platform: [-0.6, -0.3, 0.2]}",
    ],
)
def test_cables_may_share_one_end(cable):
    load_robot("r.yaml", text=changed(ROBOT, "{frame: [3.5, 2.0, 3.5], platform: [0.6, 0.3, -0.2]}", cable))


def test_names_of_cables_differ_from_given_and_from_default_ones():
    assert "'cable_2' is the name of cables[0] too" in robot_problem("name: left", "name: cable_2")
    robot = load_robot("r.yaml", text=ROBOT)
    assert [cable.name for cable in robot.cables] == ["left", "cable_2", "cable_3"]


def cables(count):
    rows = "".join(f"- {{frame: [{i}, 0, 3], platform: [0, 0, 0]}}\n" for i in range(count))
    head = changed(ROBOT[: ROBOT.index("cables:")], "max: [10000, 9000, 8000]", "max: 9000")
    return head + "cables:" + (f"\n{rows}" if count else " []\n")


def test_the_number_of_cables():
    assert load_robot("r.yaml", text=cables(1)).m == 1
    assert load_robot("r.yaml", text=cables(256)).m == 256
    for count, what in [(0, "expected 1 or more items, got 0"), (257, "expected at most 256 items, got 257")]:
        with pytest.raises(ScenarioError, match=f"cables: {what}"):
            load_robot("r.yaml", text=cables(count))


@pytest.mark.parametrize(
    ("dof", "text"),
    [
        ("[y, x, z, rx, ry, rz]", "at most once and in this order"),
        ("[]", "at least one"),
        ("[x, y, z, rx, ry, rz, rz]", "at most once"),
        (
            "[x, y, rx, ry]",
            "no guide leaves x, y, rx, ry free; allowed: any of x, y, z with at most one of",
        ),
        ("[z, rx, ry, rz]", "only rx, ry, rz (ball joint at the origin); or all six"),
        ("[rx, rz]", "no guide leaves rx, rz free"),
        ("[x, w]", "w"),
    ],
)
def test_directions_that_no_guide_leaves_free(dof, text):
    assert text in robot_problem("[x, y, z, rx, ry, rz]", dof)


def test_a_ball_leaves_all_rotations_free():
    robot = load_robot("r.yaml", text=changed(ROBOT, ALL_FREE, "dof: [rx, ry, rz]"))
    assert (robot.pattern, robot.n, robot.rows) == ("3R", 3, [3, 4, 5])


def test_a_degree_of_freedom_that_does_not_exist():
    assert "dof[1]: expected one of x, y, z, rx, ry, rz, got 'q'" in robot_problem("[x, y, z,", "[x, q, z,")


@pytest.mark.parametrize(
    ("shape", "what"),
    [
        ("{box: [1, 1, 0]}", "shape.box[2]: must be greater than 0 (m), got 0"),
        ("{sphere: -1}", "shape.sphere: must be greater than 0 (m), got -1"),
        ("{}", "shape: expected exactly one of box, sphere, cylinder, mesh"),
        ("{box: [1, 1, 1], sphere: 1}", "shape: expected exactly one of box, sphere, cylinder, mesh"),
    ],
)
def test_shapes(shape, what):
    assert what in robot_problem("{box: [1.2, 0.6, 0.4]}", shape)


@pytest.mark.parametrize("turned", [False, True])
def test_a_cable_without_length_at_the_start(turned):
    """The start puts B_2 on A_2, also where the platform is turned."""
    rpy = (0.2, 0.3, 0.4) if turned else (0.0, 0.0, 0.0)
    p = np.array([3.5, -2.0, 3.5]) - rotations.matrix(rotations.from_rpy(*rpy)) @ [-0.6, -0.3, 0.2]
    text = changed(BASE, "position: [0.0, 0.1, 1.2]", f"position: {p.tolist()}")
    text = changed(text, "{quaternion: [1, 0, 0, 0]}", f"{{rpy: {list(rpy)}}}")
    assert "initial.position: cable 'cable_2' has no length here" in problem(text)
    load(changed(text, f"position: {p.tolist()}", f"position: {(p + np.array([0, 0, 2e-6])).tolist()}"))


@pytest.mark.parametrize(
    ("steps", "key", "what"),
    [
        (
            "duration: 4.0, control_step: 0.001, physics_step: 0.0003",
            "physics_step",
            "nearest: 0.000333333333333 or 0.00025",
        ),
        (
            "duration: 4.0, control_step: 0.001, physics_step: 0.002",
            "physics_step",
            "divided by an integer, got 0.002; nearest: 0.001",
        ),
        (
            "duration: 4.0005, control_step: 0.001",
            "duration",
            "integer multiple of control_step, 0.001 (s), got 4.0005; nearest: 4 or 4.001",
        ),
        ("duration: 0.0004, control_step: 0.001", "duration", "got 0.0004; nearest: 0.001"),
        ("duration: 1.1e6, control_step: 0.01", "duration", "1.1e+08 steps; at most 1e+08 are allowed"),
        ("duration: 1, control_step: 0.001, physics_step: 1e-9", "duration", "1e+09 steps"),
        ("duration: 1e12, control_step: 1e-300", "duration", "steps; at most"),
        ("duration: 5e-324, control_step: 1e12, physics_step: 5e-324", "duration", "steps; at most"),
        ("duration: -1", "duration", "must be greater than 0 (s), got -1"),
        ("duration: 1, control_step: 0", "control_step", "must be greater than 0 (s), got 0"),
        ("duration: 1, physics_step: -0.001", "physics_step", "must be greater than 0 (s), got -0.001"),
    ],
)
def test_steps_that_do_not_fit(steps, key, what):
    line = problem(changed(BASE, STEPS, steps))
    assert f": simulation.{key}: " in line
    assert what in line


@given(st.integers(1, 10_000), st.integers(1, 50), st.sampled_from([1e-3, 0.002, 1e-4, 0.01, 1 / 3, 0.1]))
def test_decimal_steps_fit_whatever_their_rounding(steps, substeps, physics):
    control = float(f"{substeps * physics:.12g}")
    physics = control / substeps
    duration = float(f"{steps * control:.15g}")
    simulation = load(
        changed(BASE, STEPS, f"duration: {duration!r}, control_step: {control!r}, physics_step: {physics!r}")
    ).simulation
    assert (simulation.steps, simulation.substeps) == (steps, substeps)


def test_the_suggested_steps_are_accepted():
    line = problem(changed(BASE, STEPS, "duration: 4.0, control_step: 0.001, physics_step: 0.0003"))
    for value, substeps in zip(line.partition("nearest: ")[2].split(" or "), (3, 4), strict=True):
        text = changed(BASE, STEPS, f"duration: 4.0, control_step: 0.001, physics_step: {value}")
        assert load(text).simulation.substeps == substeps


def test_times_of_waypoints_increase():
    text = whole(WAYPOINTS)
    line = problem(changed(text, "time: 2.0", "time: 1.0"))
    assert "trajectory.points[1].time: must be greater than the previous point's, 1 (s), got 1" in line
    assert "trajectory.points[0].time: must be at least 0 (s), got -1" in problem(
        changed(text, "time: 1.0", "time: -1")
    )
    assert "expected 1 or more items" in problem(whole("trajectory: {type: waypoints, points: []}\n"))
    alone = "trajectory: {type: waypoints, points: [{time: 0, position: [0, 0, 1]}]}\n"
    assert "to stay, use type: hold" in problem(whole(alone))


END = "a velocity"


def quintic(**keys):
    rows = {"start": "0", "duration": "3", "from": "{}", "to": "{}", **keys}
    return whole("trajectory:\n  type: quintic\n" + "".join(f"  {key}: {value}\n" for key, value in rows.items()))


def test_a_motion_must_not_end_moving_before_the_run_ends():
    line = problem(quintic(to="{velocity: [0, 0, 1]}"))
    assert "trajectory.to.velocity: the motion ends at 3 s and the run at 4 s, so the motion must end at rest" in line
    assert "trajectory.to.angular_velocity: " in problem(quintic(to="{angular_velocity: [0, 0, 1]}"))
    assert len(problems(quintic(to="{velocity: [0, 0, 1], angular_velocity: [0, 0, 1]}"))) == 2
    load(quintic(to="{velocity: [0, 0, 1]}", duration="4"))
    load(quintic(to="{velocity: [0, 0, 1]}", duration="3", start="1"))
    load(quintic(to="{velocity: [0, 0, 1]}", duration="5"))


def test_a_motion_must_not_start_moving_after_a_rest():
    line = problem(quintic(**{"from": "{velocity: [0, 0, 1]}", "start": "0.5"}))
    assert "trajectory.from.velocity: the pose is held until 0.5 s, so the motion must start at rest" in line
    load(quintic(**{"from": "{velocity: [0, 0, 1]}"}))


def waypoints(*points, start=0):
    rows = "".join(f"  - {point}\n" for point in points)
    return whole(f"trajectory:\n  type: waypoints\n  start: {start}\n  points:\n{rows}")


def test_waypoints_rest_where_they_are_held():
    moving = "position: [0, 0, 1], velocity: [0, 0, 1]}"
    assert "points[1].velocity: the motion ends at 3 s" in problem(
        waypoints("{time: 1, position: [0, 0, 1]}", f"{{time: 3, {moving}")
    )
    load(waypoints("{time: 1, position: [0, 0, 1]}", f"{{time: 4, {moving}"))
    assert "points[0].velocity: the pose is held until 0.5 s" in problem(
        waypoints(f"{{time: 0, {moving}", "{time: 3, position: [0, 0, 1]}", start=0.5)
    )
    # The initial pose, at rest, comes before a first point after time 0.
    load(waypoints(f"{{time: 1, {moving}", "{time: 3, position: [0, 0, 1]}", start=0.5))


def test_as_many_steps_as_are_allowed():
    assert load(changed(BASE, STEPS, "duration: 1e6, control_step: 0.01")).simulation.steps == 100_000_000
    line = problem(changed(BASE, STEPS, "duration: 1000000.01, control_step: 0.01"))
    assert "at most 1e+08 are allowed" in line


def test_waypoints_start_at_the_initial_pose_or_at_the_first_of_them():
    """A first point after the start is reached from rest; one at the start must itself be at rest, where one waits."""
    points = WAYPOINTS.replace("\n    velocity: [0, 0, 0]", "\n    velocity: [0, 0, 0.1]", 1)
    moving = whole(points)
    load(moving)
    at_once = changed(moving, "- time: 1.0\n", "- time: 0.0\n")
    assert "the pose is held until 0.5 s, so the motion must start at rest" in problem(at_once)
    load(changed(at_once, "start: 0.5", "start: 0.0"))
