"""Clearances of cables that sag, against curves from their differential equation and minimisation by scipy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sagging_curves import GRAVITY, PIECES, REACHED, integrated
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize, minimize_scalar
from test_clearance import outside

import cdpr
from cdpr.cables.tables import chain_table, line_table
from cdpr.mechanics.clearance import clearance
from cdpr.mechanics.curves import cable_curves
from cdpr.model.rotations import matrix
from cdpr.model.shapes import Box, Cylinder, Mesh, Obstacle, Sphere

SAME = 3e-6  # m: the stated error of the clearance, 1e-6, and that of interpolation and minimisation
DIAMETER = 0.01
LEVEL = (1.0, 0.0, 0.0, 0.0)  # attitude


def robot_of(**changes):
    robot = cdpr.load_robot("cogiro_sagging")
    return replace(robot, cables=tuple(replace(cable, **changes) for cable in robot.cables))


def pose_of(rng):
    turn = np.array([1.0, *rng.uniform(-0.1, 0.1, 3)])
    return np.concatenate([rng.uniform([-3.0, -2.0, 1.0], [3.0, 2.0, 3.0]), turn / np.linalg.norm(turn)])


def lengths_of(robot, pose, slack, rng):
    tips = pose[:3] + robot.anchors[:, 3:] @ matrix(pose[3:]).T
    return np.linalg.norm(robot.anchors[:, :3] - tips, axis=1) * rng.uniform(0.999, 1.0 + slack, robot.m)


def least_between(first, second):
    """Return the least distance of two curves: from all local minima of a grid."""
    (s, a), (t, b) = first, second
    one, other = CubicSpline(s, a), CubicSpline(t, b)
    u, v = np.linspace(0.0, s[-1], 151), np.linspace(0.0, t[-1], 151)
    grid = np.linalg.norm(one(u)[:, None] - other(v)[None], axis=-1)
    padded = np.pad(grid, 1, constant_values=np.inf)
    around = [padded[1 + i : 152 + i, 1 + j : 152 + j] for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
    best = np.inf
    for i, j in np.argwhere(grid <= np.min(around, axis=0)):
        if grid[i, j] < best + 0.2:
            result = minimize(
                lambda x: ((one(x[0]) - other(x[1])) ** 2).sum(),
                [u[i], v[j]],
                bounds=[(0.0, s[-1]), (0.0, t[-1])],
                options={"ftol": 1e-15, "gtol": 1e-12},
            )
            best = min(best, np.sqrt(result.fun))
    return best


def least_from(shape, middle, curve):
    s, points = curve
    path = CubicSpline(s, points)

    def away(x):
        return outside(shape, np.atleast_2d(path(x)) - middle)

    u = np.linspace(0.0, s[-1], 1001)
    values = away(u)
    k = int(np.argmin(values))
    span = u[max(k - 1, 0)], u[min(k + 1, 1000)]
    found = minimize_scalar(lambda x: away(x)[0], bounds=span, method="bounded", options={"xatol": 1e-12})
    return min(found.fun, values.min())


def only(among, *cables):
    return among.without(set(range(among.robot.m)) - set(cables))


@pytest.mark.parametrize(("slack", "seed"), [(0.002, 1), (0.02, 2), (0.3, 3)])
def test_clearances_of_two_cables(slack, seed):
    rng, robot = np.random.default_rng(seed), robot_of()
    among = clearance(robot, diameter=DIAMETER, gravity=GRAVITY)
    assert not among.sharing
    pose = pose_of(rng)
    unwound = lengths_of(robot, pose, slack, rng)
    curves = integrated(robot, pose, unwound)
    straight = []
    for i, j in [(0, 1), (0, 4), (2, 3), (5, 6), (1, 6), (3, 7)]:
        pair = only(among, i, j)
        (found,), _ = pair.at(pose[None], unwound=unwound[None])
        assert found == pytest.approx(least_between(curves[i], curves[j]) - DIAMETER, abs=SAME)
        straight.append(abs(pair.at(pose[None])[0][0] - found))
    assert max(straight) > 1e-3  # the sag matters


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_clearances_of_many_cables(seed):
    rng = np.random.default_rng(100 + seed)
    robot = robot_of(linear_density=float(10.0 ** rng.uniform(-2.0, 1.0)))
    among = clearance(robot, diameter=DIAMETER, gravity=GRAVITY)
    pose = pose_of(rng)
    unwound = lengths_of(robot, pose, float(10.0 ** rng.uniform(-4.0, -0.5)), rng)
    curves = integrated(robot, pose, unwound)
    pairs = [(i, j) for i in range(8) for j in range(i)]
    expected = np.array([least_between(curves[i], curves[j]) for i, j in pairs]) - DIAMETER
    (found,), (which,) = among.at(pose[None], unwound=unwound[None])
    assert found == pytest.approx(expected.min(), abs=SAME)
    i, j = pairs[int(np.argmin(expected))]
    assert among.name(int(which)) == f"cable_{j + 1} and cable_{i + 1}"


@pytest.mark.parametrize(
    "shape", [Sphere(0.5), Box((1.0, 0.6, 0.4)), Cylinder(0.4, 0.9), Mesh("", (-0.2,) * 3, (0.2,) * 3)]
)
def test_clearances_from_obstacles(shape):
    rng, robot = np.random.default_rng(7), robot_of()
    pose = pose_of(rng)
    unwound = lengths_of(robot, pose, 0.02, rng)
    curves = integrated(robot, pose, unwound)
    for i in (0, 3, 6):
        points = curves[i][1]
        for away in (0.0, 0.3, 2.0):  # through it, near it and far below
            middle = points[PIECES // 3] - [0.0, 0.0, away]
            among = only(clearance(robot, [Obstacle("block", shape, middle, LEVEL)], DIAMETER, GRAVITY), i)
            (found,), _ = among.at(pose[None], unwound=unwound[None])
            assert found == pytest.approx(least_from(shape, middle, curves[i]) - 0.5 * DIAMETER, abs=SAME)


def test_cables_that_share_an_anchor():
    """The other end of each counts, from the curve of the other cable."""
    rng, robot = np.random.default_rng(5), robot_of()
    cables = (robot.cables[0], replace(robot.cables[1], frame=robot.cables[0].frame), *robot.cables[2:])
    robot = replace(robot, cables=cables)
    among = clearance(robot, diameter=DIAMETER, gravity=GRAVITY)
    assert among.sharing == (("cable_1", "cable_2"),)
    pose = pose_of(rng)
    unwound = lengths_of(robot, pose, 0.02, rng)
    curves = integrated(robot, pose, unwound)
    expected = min(least_from(Sphere(1.0), curves[i][1][0], curves[j]) + 1.0 - DIAMETER for i, j in ((0, 1), (1, 0)))
    (found,), _ = only(among, 0, 1).at(pose[None], unwound=unwound[None])
    assert found == pytest.approx(expected, abs=SAME)


def test_weightless_cables_have_the_bits_of_straight_ones():
    rng, robot = np.random.default_rng(4), robot_of(linear_density=0.0)
    obstacles = [
        Obstacle("ball", Sphere(0.5), (1.0, 1.0, 1.0), LEVEL),
        Obstacle("post", Box((0.5, 0.5, 2.0)), (-2.0, 0.0, 1.0), LEVEL),
    ]
    robot = replace(robot, platform=replace(robot.platform, shape=Box((0.6, 0.6, 0.6))))
    among = clearance(robot, obstacles, DIAMETER, GRAVITY)
    poses = np.array([pose_of(rng) for _ in range(200)])
    unwound = np.array([lengths_of(robot, pose, 0.01, rng) for pose in poses])
    for got, straight in zip(among.at(poses, unwound=unwound), among.at(poses), strict=True):
        np.testing.assert_array_equal(got, straight)
    assert len(set(among.at(poses)[1].tolist())) > 3


def test_a_broken_cable_touches_nothing():
    rng, robot = np.random.default_rng(9), robot_of()
    pose = pose_of(rng)
    among = clearance(robot, diameter=DIAMETER, gravity=GRAVITY).without(range(robot.m))
    (gap,), (which,) = among.at(pose[None], unwound=lengths_of(robot, pose, 0.1, rng)[None])
    assert gap == np.inf
    assert which == -1


# Anchor on a platform of 6 x 1 x 0.5 m, exit, unwound length per chord: a tangent into the top face, one over its edge,
# one below the bottom that rises around the platform although its chord passes through, one that rises into the bottom.
@pytest.mark.parametrize(
    ("anchor", "exit_", "stretch", "through", "chord_through"),
    [
        ((0.0, 0.0, 0.25), (8.0, 0.0, 0.6), 1.02, True, False),
        ((3.0, 0.0, 0.25), (8.0, 0.0, 0.6), 1.02, False, False),
        ((0.0, 0.0, -0.25), (0.0, 9.0, 1.0), 1.05, False, True),
        ((0.0, 0.0, -0.25), (8.0, 0.0, 0.5), 1.001, True, True),
        ((0.0, 0.0, -0.25), (8.0, 0.0, 0.5), 1.02, False, True),
        ((0.0, 0.0, -0.25), (8.0, 0.0, 0.5), 1.0025, True, True),
        ((0.0, 0.0, 0.25), (8.0, 0.0, 6.0), 1.02, False, False),
    ],
)
def test_passing_through_the_platform(anchor, exit_, stretch, through, chord_through):
    shape = Box((6.0, 1.0, 0.5))
    robot = robot_of(linear_density=1.0)
    cable = replace(robot.cables[0], platform=anchor, frame=exit_)
    robot = replace(robot, cables=(cable,), platform=replace(robot.platform, shape=shape))
    pose = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    unwound = stretch * np.linalg.norm(np.subtract(exit_, anchor)) * np.ones(1)
    ((_, points),) = integrated(robot, pose, unwound)
    assert bool(outside(shape, points).min() < -1e-4) is through  # the oracle
    among = clearance(robot, diameter=DIAMETER, gravity=GRAVITY)
    assert bool(among.at(pose[None], unwound=unwound[None])[0][0] < 0.0) is through
    assert bool(among.at(pose[None])[0][0] < 0.0) is chord_through


def test_curves_for_drawings():
    """They lead from the frame to the platform; without an equilibrium, they are straight."""
    rng, robot = np.random.default_rng(11), robot_of()
    pose = pose_of(rng)
    unwound = lengths_of(robot, pose, 0.3, rng)
    expected = [points for _, points in integrated(robot, pose, unwound)]
    unwound[5] = -1.0
    given = line_table(robot), chain_table(robot), GRAVITY, pose[None]
    (found,) = cable_curves(*given, unwound[None], 26)
    for i in (0, 1, 2, 3, 4, 6, 7):
        np.testing.assert_allclose(found[i], expected[i][:: -PIECES // 25], atol=REACHED)
    straight = np.linspace(expected[5][-1], expected[5][0], 26)
    np.testing.assert_allclose(found[5], straight, atol=REACHED)
