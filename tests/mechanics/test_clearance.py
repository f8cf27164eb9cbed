"""Distances of cables from each other, from their platform and from obstacles, against other ways to find them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear
from spread import sampled
from workspace_cases import poses_of, robot_of

from cdpr.base.errors import CdprError
from cdpr.mechanics import solids
from cdpr.mechanics.clearance import clearance
from cdpr.mechanics.distances import segment_distances, solid_distances
from cdpr.model import rotations
from cdpr.model.shapes import Box, Cylinder, Hull, Mesh, Obstacle, Sphere

# m: of two ways to the same distance, whose numbers are some metres; the oracle's own tolerance.
SAME = 1e-9
POINTS = 20001
# m: of a cable's end so near to the tangent plane of its anchor, points are hardly inside of a round platform.
GRAZING = 0.1

SHAPES = [Box((1.0, 0.6, 0.4)), Sphere(0.5), Cylinder(0.4, 0.9), Mesh("", (-0.2, 0.0, 0.1), (0.7, 0.3, 0.5))]


def distance(ends):
    """Between segments (4, 3), by bounded least squares."""
    a, b, c, d = ends
    found = lsq_linear(np.stack([b - a, c - d], axis=1), c - a, bounds=(0.0, 1.0), method="bvls", tol=1e-15)
    return np.linalg.norm(a + found.x[0] * (b - a) - c - found.x[1] * (d - c))


def outside(shape, x):
    """How far points (k, 3) are from a shape about its middle, negative inside: by its definition."""
    if isinstance(shape, Sphere):
        return np.linalg.norm(x, axis=1) - shape.radius
    if isinstance(shape, Cylinder):
        flat = np.stack([np.hypot(x[:, 0], x[:, 1]) - shape.radius, np.abs(x[:, 2]) - shape.height / 2], axis=1)
    elif isinstance(shape, Box):
        flat = np.abs(x) - 0.5 * np.array(shape.size)
    else:
        low, high = np.array(shape.lower), np.array(shape.upper)
        flat = np.abs(x - 0.5 * (low + high)) - 0.5 * (high - low)
    return np.linalg.norm(np.maximum(flat, 0.0), axis=1) + np.minimum(flat.max(axis=1), 0.0)


@given(seed=st.integers(0, 10**6), kind=st.sampled_from(["any", "near parallel", "touching", "short"]))
def test_between_segments(seed, kind):
    rng = np.random.default_rng(seed)
    ends = rng.uniform(-3.0, 3.0, (4, 3))
    if kind == "near parallel":
        ends[3] = ends[2] + (ends[1] - ends[0]) * rng.uniform(0.2, 2.0) + 1e-5 * rng.standard_normal(3)
    elif kind == "touching":
        ends[2] = ends[0] + rng.random() * (ends[1] - ends[0])
    elif kind == "short":
        ends[3] = ends[2]
    (found,) = segment_distances(*ends.reshape(2, 1, 6))
    assert found == pytest.approx(distance(ends), abs=SAME if kind != "near parallel" else 1e-7)


@pytest.mark.parametrize("last", [(1.0, 2.0, 0.0), (0.0, 2.0, 0.0), (5.0, 2.0, 0.0)], ids=str)
def test_parallel_segments_and_points(last):
    second = [(0.0, 2.0, 0.0, *last)]
    for end in (1.0, 0.0):
        assert segment_distances([(0.0, 0.0, 0.0, end, 0.0, 0.0)], second).tolist() == [2.0]


def test_wrong_shapes_are_errors():
    with pytest.raises(ValueError, match=r"segment_distances: second: expected shape \(k, 6\)"):
        segment_distances(np.zeros((2, 6)), np.zeros((1, 6)))
    with pytest.raises(ValueError, match=r"solid_distances: solid: expected shape \(s >= 11,\), got \(10,\)"):
        solid_distances(np.zeros(10), np.zeros((1, 6)))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
@given(seed=st.integers(0, 10**6))
def test_from_solids(shape, seed):
    rng = np.random.default_rng(seed)
    start, end, place = rng.uniform(-1.5, 1.5, (3, 3))
    q = rng.standard_normal(4)
    q /= np.linalg.norm(q)
    row = solids.row(shape, place, q)
    (found,) = solid_distances(row, [[*start, *end]])

    def local(s):
        x = start + np.atleast_1d(np.asarray(s))[:, None] * (end - start) - place
        return x @ rotations.matrix(q)

    way = np.linspace(0.0, 1.0, POINTS)
    values = outside(shape, local(way))
    k = int(np.argmin(values))
    low, high = way[max(k - 1, 0)], way[min(k + 1, POINTS - 1)]
    for _ in range(100):  # convex: of three parts one outer can go
        first, second = low + (high - low) / 3.0, high - (high - low) / 3.0
        ahead, behind = outside(shape, local([first, second]))
        low, high = (first, high) if ahead > behind else (low, second)
    assert found == pytest.approx(min(outside(shape, local(low))[0], values[k]), abs=SAME)


@sampled(1, "name", ["caroca", "cogiro", "twelve", "planar"])
def test_the_least_of_all_pairs_is_reported_with_its_names(name):
    robot = replace(robot_of(name), platform=replace(robot_of(name).platform, shape=None))
    among, poses = clearance(robot, diameter=0.012), poses_of(robot, 40)
    found, which = among.at(poses)
    names = [cable.name for cable in robot.cables]
    shared = {frozenset(pair) for pair in among.sharing}
    for pose, value, number in zip(poses, found, which, strict=True):
        turned = rotations.matrix(pose[3:])
        tips = pose[:3] + np.array([cable.platform for cable in robot.cables]) @ turned.T
        exits = robot.anchors[:, :3]
        pairs = {}
        for i in range(robot.m):
            for j in range(i):
                ends = np.array([exits[i], tips[i], exits[j], tips[j]])
                if frozenset((names[i], names[j])) not in shared:
                    pairs[f"{names[j]} and {names[i]}"] = distance(ends)
                else:
                    free = (1, 3) if np.allclose(robot.anchors[i, :3], robot.anchors[j, :3]) else (0, 2)
                    ways = [(ends[free[0]], ends[2:]), (ends[free[1]], ends[:2])]
                    pairs[f"{names[j]} and {names[i]}"] = min(distance([x, x, *way]) for x, way in ways)
        least = min(pairs, key=pairs.get)
        assert value == pytest.approx(pairs[least] - 0.012, abs=SAME)
        assert pairs[among.name(number)] == pytest.approx(pairs[least], abs=SAME)


def test_cables_over_pulleys_leave_where_the_rope_leaves_them():
    """At the end of a pulley that is not in the frame's anchor, but no farther from it than across."""
    robot, points = robot_of("cogiro_pulleys"), robot_of("cogiro")
    poses, across = poses_of(points, 300), 2.0 * max(cable.exit.radius for cable in robot.cables)
    on, off = (clearance(each, diameter=0.01).at(poses)[0] for each in (robot, points))
    assert 1e-6 < np.abs(on - off).max() < 2.0 * across


def test_cables_that_share_an_anchor_touch_where_they_lie_along_each_other():
    robot = robot_of("planar")
    first, second, *_ = robot.cables
    pair = (first, replace(second, frame=first.frame))
    robot = replace(robot, cables=pair, platform=replace(robot.platform, shape=None))
    among = clearance(robot, diameter=0.01)
    assert among.sharing == ((first.name, second.name),)
    home = np.array([[0.0, 0.0, 1.5, 1.0, 0.0, 0.0, 0.0]])
    assert among.at(home)[0][0] > 0.0  # though they touch at their anchor
    along = first.frame - (second.platform - first.platform) * 4.0 - first.platform
    value, which = among.at([[*along, 1.0, 0.0, 0.0, 0.0]])
    assert value[0] == pytest.approx(-0.01, abs=1e-9)
    assert among.name(which[0]) == f"{first.name} and {second.name}"


@sampled(1, "shape", [Box((1.2, 0.6, 0.4)), Sphere(0.5), Cylinder(0.5, 0.4)], ids=lambda s: type(s).__name__)
def test_a_cable_from_the_surface_goes_through_the_platform_or_not(shape):
    """Points of the cable are inside of the shape, or none is."""
    rng = np.random.default_rng(1)
    robot = robot_of("caroca")
    asked = 0
    for _ in range(60):
        anchor = rng.standard_normal(3)
        if isinstance(shape, Box):
            half = 0.5 * np.array(shape.size)
            anchor = half * (anchor / np.abs(anchor).max() if rng.random() < 0.7 else np.sign(anchor))
        elif isinstance(shape, Sphere):
            anchor *= shape.radius / np.linalg.norm(anchor)
        else:
            anchor = (
                np.array([shape.radius * 0.6, 0.1, 0.5 * shape.height])
                if rng.random() < 0.5
                else np.array([shape.radius * math.cos(1.0), shape.radius * math.sin(1.0), 0.05])
            )
        cable = replace(robot.cables[0], platform=anchor)
        one = replace(robot, cables=(cable,), platform=replace(robot.platform, shape=shape))
        among = clearance(one, diameter=0.01)
        assert among.unjudged == ()
        pose = poses_of(robot, 1, seed=int(rng.integers(1000)))[0]
        value = among.at(pose[None])[0][0]
        exit_ = rotations.matrix(pose[3:]).T @ (cable.frame - pose[:3])
        deepest = outside(shape, anchor + np.linspace(0.0, 1.0, POINTS)[:, None] * (exit_ - anchor)).min()
        if abs(value) > GRAZING:
            asked += 1
            assert (deepest < -1e-5) == (value < 0.0)
    assert asked > 30


def test_an_anchor_outside_of_the_platform_is_judged_by_its_distance_and_one_inside_not_at_all():
    robot = robot_of("caroca")
    home = [[0.0, 0.0, 1.2, 1.0, 0.0, 0.0, 0.0]]
    far = replace(robot, cables=robot.cables[:1], platform=replace(robot.platform, shape=Sphere(0.1)))
    reach = np.linalg.norm(robot.cables[0].platform)
    value, which = clearance(far, diameter=0.02).at(home)
    assert clearance(far, diameter=0.02).name(which[0]) == "cable_1 and the platform"
    assert value[0] <= reach - 0.1 - 0.01 + SAME
    deep = replace(robot, cables=robot.cables[:1], platform=replace(robot.platform, shape=Box((3.0, 3.0, 3.0))))
    assert clearance(deep, diameter=0.02).unjudged == ("cable_1",)
    assert clearance(deep, diameter=0.02).at(home)[0][0] == math.inf


def test_obstacles_have_names():
    robot = replace(robot_of("caroca"), platform=replace(robot_of("caroca").platform, shape=None))
    middle = 0.5 * (robot.cables[2].frame + robot.cables[2].platform + [0.0, 0.0, 1.2])
    pillar = Obstacle("pillar", Cylinder(0.1, 1.0), middle, np.array([1.0, 0.0, 0.0, 0.0]))
    among = clearance(robot, [pillar], 0.02)
    value, which = among.at([[0.0, 0.0, 1.2, 1.0, 0.0, 0.0, 0.0]])
    assert among.name(which[0]) == "cable_3 and pillar"
    assert value[0] < -0.1


def test_it_changes_no_more_than_the_position_does():
    """Basis of proofs: cables end on a moved body, so no distance grows faster."""
    robot = robot_of("caroca")
    among, rng = clearance(robot, diameter=0.01), np.random.default_rng(2)
    poses = poses_of(robot, 500)
    other = poses.copy()
    step = rng.standard_normal((500, 3)) * 0.05
    other[:, :3] += step
    change = np.abs(among.at(poses)[0] - among.at(other)[0])
    assert (change <= np.linalg.norm(step, axis=1) + SAME).all()


def test_without_a_diameter_there_is_none():
    with pytest.raises(CdprError, match=r"cable 'cable_1' has no diameter: .*a `diameter`"):
        clearance(robot_of("caroca"))
    with pytest.raises(CdprError, match="diameter: expected a length of at least 0 m, got nan"):
        clearance(robot_of("caroca"), diameter=math.nan)


def test_threads_change_nothing():
    robot, poses = robot_of("cogiro"), poses_of(robot_of("cogiro"), 5000)
    one, two = (clearance(robot, diameter=0.01).at(poses, jobs) for jobs in (1, 2))
    assert np.array_equal(one[0], two[0])
    assert np.array_equal(one[1], two[1])


BALL = Obstacle("ball", Sphere(0.5), np.array([1.0, 0, 1]), np.array([1.0, 0, 0, 0]))


@pytest.mark.parametrize("name", ["cogiro", "caroca", "planar", "cogiro_pulleys", "point_mass", "twelve"])
@pytest.mark.parametrize("obstacles", [(), (BALL,)])
def test_poses_in_lanes_are_judged_to_the_bit_as_alone(name, obstacles):
    robot = robot_of(name)
    among, poses = clearance(robot, obstacles, 0.01), poses_of(robot, 203)  # no multiple of eight
    poses[5::50, :3] = robot.anchors[0, :3] - robot.anchors[0, 3:]  # a cable without length
    poses[5::50, 3:] = (1.0, 0.0, 0.0, 0.0)
    together = among.at(poses)
    alone = [among.at(poses[k : k + 7]) for k in range(0, len(poses), 7)]  # fewer than fill a register
    assert np.array_equal(together[0], np.concatenate([gaps for gaps, _ in alone]), equal_nan=True)
    assert np.array_equal(together[1], np.concatenate([which for _, which in alone]))


def test_obstacles_that_are_skipped_are_farther():
    """Each obstacle alone, and all of them: what the spheres around them rule out is not the nearest."""
    robot = replace(robot_of("caroca"), platform=replace(robot_of("caroca").platform, shape=None))
    rng, poses = np.random.default_rng(3), poses_of(robot, 100)
    shapes = [*SHAPES, Hull("", ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))] * 2
    several = []
    for k, shape in enumerate(shapes):
        several.append(Obstacle(str(k), shape, rng.uniform(-3, 3, 3), rotations.from_rpy(*rng.normal(size=3))))
    each = np.array([clearance(robot, [one], 0.01).at(poses)[0] for one in several])
    assert np.array_equal(clearance(robot, several, 0.01).at(poses)[0], each.min(axis=0))
    assert len(set(each.argmin(axis=0).tolist())) > 3
