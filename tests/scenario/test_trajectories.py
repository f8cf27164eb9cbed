"""The sections of motions beside hold, quintic and waypoints: defaults, files, and what is refused."""

from __future__ import annotations

import hashlib
import os
import pickle

import numpy as np
import pytest
from scenario_cases import PLUGINS, ROBOT, changed, line_of, load, problem, problems, whole

from cdpr.base.errors import ScenarioError
from cdpr.base.files import ContentError
from cdpr.scenario import Circle, Csv, JerkLimited, PickAndPlace, load_scenario
from cdpr.scenario.motions.table import MAX_ROWS, parse_table

ARCH = "trajectory: {type: pick_and_place, duration: 2, to: {position: [1, 0, 1]}, height: 0.5}\n"
CIRCLE = "trajectory: {type: circle, duration: 2, center: [0.5, 0.1, 1.2]}\n"
HELIX = "trajectory: {type: helix, duration: 2, center: [0.5, 0.1, 1.2], pitch: 0.2}\n"
JERK = (
    "trajectory:\n  type: jerk_limited\n  points:\n  - {position: [1, 0, 1], pause: 0.5}\n"
    "  - {position: [1, 1, 1]}\n  limits: {velocity: 1, acceleration: 2, jerk: 20}\n"
)
CSV = "trajectory: {type: csv, file: motion.csv}\n"
ROWS = "# a motion\nt,x,y,z\n0,0,0.1,1.2\n\n1.5,0.5,0,1\n3,1,0,1\n"
PLANAR = changed(ROBOT, "dof: [x, y, z, rx, ry, rz]", "dof: [x, z, ry]")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "motion.csv").write_text(ROWS)
    return tmp_path


def read(folder, rows=None, trajectory=CSV, robot=ROBOT):
    """Load a scenario with a CSV file beside it."""
    if rows is not None:
        (folder / "motion.csv").write_text(rows)
    return load_scenario(folder / "a.yaml", text=whole(trajectory, robot), plugins=PLUGINS)


def refused(folder, rows=None, trajectory=CSV, robot=ROBOT):
    """Return the lines of the error, without the folder."""
    with pytest.raises(ScenarioError) as caught:
        read(folder, rows, trajectory, robot)
    return str(caught.value).replace(f"{folder}{os.sep}", "").splitlines()


@pytest.mark.parametrize("text", [ARCH, CIRCLE, HELIX, JERK], ids=["arch", "circle", "helix", "jerk"])
def test_the_initial_pose_is_filled_in_and_the_resolved_text_is_equal(text):
    scenario = load(whole(text))
    motion = scenario.trajectory
    beginning = motion if isinstance(motion, Circle) else motion.from_
    assert beginning.position == (0, 0.1, 1.2)
    assert np.array_equal(beginning.orientation.quaternion(), [1, 0, 0, 0])
    assert load(scenario.resolved_yaml()) == scenario
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    made = motion.make()
    np.testing.assert_allclose(made.sample(0.0)[:7], [0, 0.1, 1.2, 1, 0, 0, 0])


def test_descriptions_of_sections():
    arch = load(whole(ARCH)).trajectory
    assert isinstance(arch, PickAndPlace)
    assert arch.make().sample(1.0)[2] == pytest.approx(1.7)
    np.testing.assert_allclose(arch.make().sample(9.0)[:3], [1, 0, 1])
    helix = load(whole(HELIX)).trajectory.make()
    np.testing.assert_allclose(helix.sample(1.0)[:3], [1, 0.1, 1.3], atol=1e-11)
    tilted = changed(CIRCLE, "[0.5, 0.1, 1.2]", "[0.5, 0.1, 1.2], normal: [0, -3, 0], turns: -0.5")
    half = load(whole(tilted)).trajectory.make()
    np.testing.assert_allclose(half.sample(1.0)[:3], [0.5, 0.1, 1.7], atol=1e-11)
    jerk = load(whole(JERK)).trajectory
    assert isinstance(jerk, JerkLimited)
    np.testing.assert_allclose(jerk.make().sample(99.0)[:3], [1, 1, 1])


@pytest.mark.parametrize(
    ("text", "old", "new", "key", "what"),
    [
        (ARCH, "height: 0.5", "height: -1", "trajectory.height", "must be at least 0 (m), got -1"),
        (ARCH, "height: 0.5", "height: 1, vertical: 0.5", "trajectory.vertical", "must be at most 0.49, got 0.5"),
        (ARCH, ", height: 0.5", "", "trajectory.height", "required but not given: height of the top"),
        (CIRCLE, "center", "centre", "trajectory.centre", "did you mean 'center'?"),
        (CIRCLE, "[0.5, 0.1, 1.2]", "[0.5, 0.1, 1.3]", "trajectory.center", "nearest in it: [0.5, 0.1, 1.2]"),
        (CIRCLE, "[0.5, 0.1, 1.2]", "[0, 0.1, 1.2]", "trajectory.center", "the circle has no radius"),
        (CIRCLE, "duration: 2", "duration: 2, normal: [0, 0, 0]", "trajectory.normal", "must not be zero"),
        (CIRCLE, "duration: 2", "duration: 2, turns: 0", "trajectory.turns", "to stay, use type: hold"),
        (CIRCLE, "duration: 2", "duration: 2, turns: 1001", "trajectory.turns", "must be at most 1000, got 1001"),
        (CIRCLE, "duration: 2", "duration: 2, pitch: 1", "trajectory.pitch", "unknown key 'pitch'"),
        (HELIX, ", pitch: 0.2", "", "trajectory.pitch", "way along the normal per turn"),
        (JERK, "velocity: 1", "velocity: 0", "trajectory.limits.velocity", "must be greater than 0 (m/s), got 0"),
        (JERK, "pause: 0.5", "orientation: {rpy: [0, 0, 1]}", "trajectory.angular_limits", "the way to point 0"),
        (CSV, "csv,", "cvs,", "trajectory.type", "did you mean 'csv'?"),
    ],
)
def test_rejected_input(text, old, new, key, what):
    lines = problems(whole(changed(text, old, new)))
    assert [line for line in lines if f": {key}: " in line and what in line], lines
    # A misspelt key is also missed.
    assert len(lines) == 1 + ("centre" in new), lines


def test_turning_with_limits_is_allowed():
    turned = changed(JERK, "pause: 0.5", "orientation: {rpy: [0, 0, 1]}")
    text = turned + "  angular_limits: {velocity: 1, acceleration: 2, jerk: 20}\n"
    assert load(whole(text)).trajectory.make().sample(0.5)[12] != 0


# Guides


def guided(trajectory, *texts):
    """A motion in the plane is allowed, or refused with these texts."""
    text = changed(whole(trajectory, PLANAR), "angular_velocity: [0, 0.1, 0]", "angular_velocity: [0, 0, 0]")
    if not texts:
        load(text)
    for part in texts:
        assert part in problem(text)


def test_paths_stay_in_the_guide():
    still = "[0.5, 0.1, 1.2], normal: [0, 1, 0]"
    guided(changed(ARCH, "[1, 0, 1]", "[1, 0.1, 1]"))
    guided(changed(CIRCLE, "[0.5, 0.1, 1.2]", still + ", turning: true"))
    guided(changed(JERK.replace("[1, 1, 1]", "[1, 0.1, 2]"), "[1, 0, 1]", "[1, 0.1, 1]"))
    guided(ARCH, "trajectory.to.position: the robot moves along x, z, ry only")
    guided(CIRCLE, "trajectory.normal: the robot moves along x, z, ry only, so the circle must not leave its plane")
    guided(changed(HELIX, "[0.5, 0.1, 1.2]", still), "trajectory.pitch: the robot moves along x, z, ry only")
    guided(JERK.replace("[1, 0, 1]", "[1, 0.1, 1]"), "trajectory.points[1].position: ")
    level = changed(PLANAR, "dof: [x, z, ry]", "dof: [x, y]")
    lines = problems(changed(whole(ARCH, level), "angular_velocity: [0, 0.1, 0]", "angular_velocity: [0, 0, 0]"))
    assert any("trajectory.height: expected 0, got " in line for line in lines)
    lines = problems(
        changed(whole(changed(CIRCLE, "duration: 2", "duration: 2, turning: true"), level), "[0, 0.1, 0]", "[0, 0, 0]")
    )
    assert any("trajectory.turning: " in line for line in lines)


HINGED, BALL = (changed(PLANAR, "dof: [x, z, ry]", f"dof: {dof}") for dof in ("[ry]", "[rx, ry, rz]"))


@pytest.mark.parametrize("robot", [HINGED, BALL])
def test_platforms_on_a_ball_joint_only_rotate(robot):
    def text(trajectory):
        return changed(whole(trajectory, robot), "  velocity: [0.1, 0, 0]", "  velocity: [0, 0, 0]")

    circle = problem(text(CIRCLE))
    assert "trajectory.type: the robot moves along " in circle
    assert "no circle is possible" in circle
    moved = problems(text(ARCH))
    assert any("trajectory.to.position: " in line and "holds it at x = 0, y = 0.1" in line for line in moved)
    assert any("trajectory.height: " in line for line in moved)
    turn = "[0, 0.4, 0]" if robot is HINGED else "[0.2, 0.4, 1]"
    load(text(f"trajectory: {{type: quintic, duration: 2, to: {{orientation: {{rpy: {turn}}}}}}}\n"))


def test_rows_stay_in_the_guide(folder):
    rows = (
        "t,x,y,z,qw,qx,qy,qz,vx,vy,vz\n0,0,0.1,1.2,1,0,0,0,0,0,0\n1,0,0.1,1,1,0,0,0,0,0.5,0\n4,0,0.2,1,0,0,0,1,0,0,0\n"
    )
    lines = refused(folder, rows, robot=PLANAR)
    assert [line.partition(": the robot")[0] for line in lines] == [
        "motion.csv:3:1: trajectory.file: velocity",
        "motion.csv:4:1: trajectory.file: orientation",
        "motion.csv:4:1: trajectory.file: position",
    ]


# CSV files


def test_a_file_is_followed(folder):
    scenario = read(folder)
    motion = scenario.trajectory
    assert isinstance(motion, Csv)
    assert motion.sha256 == hashlib.sha256(ROWS.encode()).hexdigest()
    made = motion.make()
    np.testing.assert_allclose(made.sample(1.5)[:7], [0.5, 0, 1, 1, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(made.sample(9.0), [1, 0, 1, 1, *[0] * 15], atol=1e-12)
    assert pickle.loads(pickle.dumps(scenario)).trajectory.table.lines == [3, 5, 6]
    resolved = scenario.resolved_yaml()
    assert load_scenario(folder / "b.yaml", text=resolved, plugins=PLUGINS) == scenario
    assert scenario.with_changes(["simulation.seed=3"]).trajectory.sha256 == motion.sha256
    (folder / "motion.csv").write_text(ROWS + "3.5,1,0,1\n")
    with pytest.raises(ScenarioError, match=r"trajectory.sha256: .* has changed"):
        load_scenario(folder / "b.yaml", text=resolved, plugins=PLUGINS)


def test_every_column_is_used(folder):
    names = "ax,ay,az,t,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz"
    row = "0.7,0.8,0.9,{},0.1,0.2,0.3,0.8,0,0.6,0,0.4,0.5,0.6,0.1,0.2,0.3"
    rows = "\r\n".join([names, *(row.format(k) for k in range(5))])
    made = read(folder, rows, changed(CSV, "csv,", "csv, start: 0,")).trajectory.make()
    expected = [0.1, 0.2, 0.3, 0.8, 0, 0.6, 0, 0.4, 0.5, 0.6, 0.1, 0.2, 0.3, 0.7, 0.8, 0.9]
    np.testing.assert_allclose(made.sample(2.0)[:16], expected, atol=1e-12)


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        ("t,x,y,z\n0,0,0,1\n1,0,a,1\n", "motion.csv:3:5: trajectory.file: y: expected a number, got 'a'"),
        ("t,x,y,z\n0,0,0,1\n1,0, nan,1\n", "motion.csv:3:6: trajectory.file: y: expected a finite number, got nan"),
        ("t,x,y,z\n0,0,0,1\n1,0,1e13,1\n", "motion.csv:3:5: trajectory.file: y: must lie between"),
        ("t,x,y,z\n0,0,0,1\n1,0,1_0,1\n", "motion.csv:3:5: trajectory.file: y: expected a number, got '1_0'"),
        ("t,x,y,z\n0,0,0,1\n1,0,,1\n", "motion.csv:3:5: trajectory.file: y: expected a number, got ''"),
        ("t,x,y,z\n0,0,0,1\n1,0,1\n", "motion.csv:3:1: trajectory.file: expected 4 numbers (t, x, y, z), got 3"),
        ("t,x,y,z\n0,0,0,1\n0,0,1,1\n", "motion.csv:3:1: trajectory.file: t: must be greater than the previous"),
        ("t,x,y,z\n-1,0,0,1\n0,0,1,1\n", "motion.csv:2:1: trajectory.file: t: must be at least 0 (s), got -1"),
        ("t,x,y,z\n0,0,0,1\n", "motion.csv:2:1: trajectory.file: expected two or more points, got 1"),
        ("", "motion.csv:1:1: trajectory.file: the first line must name the columns: t,x,y,z"),
        ("t;x;y;z\n", "motion.csv:1:1: trajectory.file: unknown column 't;x;y;z': columns are separated by commas"),
        ("0,0,0,1\n", "motion.csv:1:1: trajectory.file: unknown column '0'"),
        ("t,x,y\n0,0,1\n", "motion.csv:1:1: trajectory.file: missing column z; x, y, z go together"),
        ("t,x,y,z,qw\n", "motion.csv:1:1: trajectory.file: missing column qx, qy, qz"),
        ("t,x,y,z,x\n", "motion.csv:1:9: trajectory.file: column 'x' occurs twice"),
        (
            "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,0,0,0,1,1,0,0\n",
            "motion.csv:3:1: trajectory.file: qw, qx, qy, qz: expected a quaternion of norm 1, got norm 1.41421",
        ),
        (
            "t,x,y,z,vx,vy,vz\n0,0,0,0,0,0,0\n1,0,0,0,0,0,1\n",
            "motion.csv:3:1: trajectory.file: velocity: the motion ends at 1 s and the run at 4 s",
        ),
        (
            "t,x,y,z,vx,vy,vz\n1,0,0,0,0,0,1\n2,0,0,0,0,0,0\n",
            "motion.csv:2:1: trajectory.file: velocity: the pose is held until 1 s",
        ),
    ],
)
def test_a_wrong_file_is_refused_with_the_place(folder, rows, expected):
    assert refused(folder, rows)[0].startswith(expected)


def test_files_that_are_none(folder):
    def line(name):
        return refused(folder, trajectory=changed(CSV, "motion.csv", name))[0]

    assert "there is no file 'moton.csv': did you mean 'motion.csv'?" in line("moton.csv")
    assert "expected a file name relative to this file" in line(str(folder / "motion.csv"))
    os.mkfifo(folder / "pipe.csv")
    assert "is not a regular file" in line("pipe.csv")
    (folder / "bytes.csv").write_bytes(b"t,x,y,z\n0,0,\xff,1\n")
    assert line("bytes.csv").startswith("bytes.csv:2:1: trajectory.file: this is not a text in UTF-8")
    text = whole(CSV)
    assert line("x.csv").startswith(f"a.yaml:{line_of(text, 'file:')}:")
    assert len(refused(folder, "t,x,y,z\n" + "a,b,c,d\n" * 1000)) == 10


@pytest.mark.slow
def test_large_tables():
    rows = "t,x,y,z\n" + "\n".join(f"{k},0,0,1" for k in range(MAX_ROWS))
    assert len(parse_table(rows.encode()).times) == MAX_ROWS
    with pytest.raises(ContentError, match="100000 points at most"):
        parse_table(f"{rows}\n1e9,0,0,1".encode())
    with pytest.raises(ContentError, match="larger than 32 MiB"):
        parse_table(b" " * (32 * 1024**2 + 1))
