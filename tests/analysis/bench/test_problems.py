"""The problems and paths of the benchmark."""

from __future__ import annotations

import numpy as np
import pytest
from bench_cases import wall
from conftest import GRAVITY, ROOT
from spread import sampled

from cdpr.analysis.bench.oracle import consult
from cdpr.analysis.bench.problems import HEAVY_EVERY, TILT, box, make_paths, make_problems, random_pose
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state
from cdpr.model import rotations
from cdpr.scenario import load_robot

ROBOTS = ("caroca", "thesis", "planar", "point_mass", "seven", "crossed", "nine", "twelve")


def robot(name):
    return load_robot(ROOT / "scenarios" / "robots" / f"{name}.yaml")


def test_box_reaches_a_share_of_the_way_to_the_outermost_anchors():
    np.testing.assert_allclose(box(robot("crossed")), [[-1.4, -1.4, 0.45], [1.4, 1.4, 2.55]])


def test_box_of_a_suspended_robot_reaches_as_far_down_as_up():
    low, high = box(robot("caroca"))
    assert high[2] - 1.2 == pytest.approx(0.7 * 2.3)
    assert 1.2 - low[2] == pytest.approx(0.7 * 2.3)


def test_box_is_flat_in_held_directions_and_uneven_where_the_anchors_are():
    assert (np.ptp(box(robot("planar")), axis=0) > 0).tolist() == [True, False, True]
    np.testing.assert_allclose(box(robot("point_mass"))[:, 0], [-7.0, 14.0])


@pytest.mark.parametrize("name", ROBOTS)
def test_poses_keep_to_the_degrees_of_freedom(name):
    one = robot(name)
    low, high = box(one)
    poses = np.array([random_pose(one, np.random.default_rng(k)) for k in range(50)])
    assert (poses[:, :3] >= low).all()
    assert (poses[:, :3] <= high).all()
    assert (np.abs(rotations.rotation_vector(poses[:, 3:])) <= 2 * TILT).all()
    assert all(rotations.held_upright(one.dof, pose[3:]) for pose in poses)
    varied = np.ptp(poses, axis=0)[[0, 1, 2, 4, 5, 6]] > 1e-3
    assert varied.tolist() == [axis in one.dof for axis in ("x", "y", "z", "rx", "ry", "rz")]


def test_a_problem_depends_on_seed_and_number_alone():
    few, many, other = (make_problems(wall(), *what) for what in ((5, 3), (20, 3), (5, 4)))
    assert few.W.tobytes() == many.W[:5].tobytes()
    assert few.wrench.tobytes() == many.first(5).wrench.tobytes()
    assert not np.isclose(few.wrench, other.wrench).any()


def test_loads_are_the_weight_and_up_to_a_fifth_more_and_some_are_heavy():
    one = robot("crossed")
    found = make_problems(one, 200, 1)
    extra = found.wrench - required_wrench(one, make_state([0, 0, 1.5]), GRAVITY)
    heavy = np.arange(200) % HEAVY_EVERY == 0
    force, moment = np.linalg.norm(extra[~heavy, :3], axis=1), np.linalg.norm(extra[~heavy, 3:], axis=1)
    weight = 20 * 9.81
    assert 0.15 * weight < force.max() <= 0.2 * weight
    assert 0.15 * weight < moment.max() / one.characteristic_length <= 0.2 * weight
    assert 5 * weight < found.wrench[heavy, 2].max() < 1.2 * 0.5 * 8 * 500


def test_no_solver_can_change_them():
    found = make_problems(wall(), 2, 1)
    with pytest.raises(ValueError, match="read-only"):
        found.W[0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        found.wrench[0] = 1.0


@pytest.mark.slow
@sampled(2, "name", ROBOTS)
def test_some_are_infeasible_for_every_default_robot(name):
    share = consult(make_problems(robot(name), 100, 1)).infeasible.mean()
    assert 0.05 <= share <= 0.5


def test_paths_are_feasible_from_end_to_end():
    one = robot("twelve")
    for path in make_paths(one, 6, 1):
        for s in np.linspace(0.0, 1.0, 5):
            t = (1 - s) * path.tensions[0] + s * path.tensions[1]
            W, wrench = path.at(s)
            np.testing.assert_allclose(W @ t, wrench)
            assert (t >= one.tension_min).all()
            assert (t <= one.tension_max).all()


def test_paths_end_at_their_poses():
    (path,) = make_paths(robot("seven"), 1, 2)
    for s, (x, y, z, *q) in zip((0.0, 1.0), path.poses, strict=True):
        u = path.robot.anchors[0, :3] - [x, y, z] - rotations.matrix(np.array(q)) @ path.robot.anchors[0, 3:]
        np.testing.assert_allclose(path.at(s)[0][:3, 0], u / np.linalg.norm(u), atol=1e-12)
