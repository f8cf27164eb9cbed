"""Distances along rays against casters that intersect faces, triangles and quadrics by numpy."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.model.shapes import Box, Cylinder, Hull, Obstacle, Sphere
from cdpr.sensing.rays import ray_distances

CLOSE = 1e-12  # m, round-off at distances of a few metres
GRAZING = 1e-3  # sine of the angle to a surface below which its intersection is ill-conditioned
REACH = 50.0


def plane_hits(x, d, normal, height, within):
    slope = normal @ d
    if slope == 0.0:
        return []
    s = (height - normal @ x) / slope
    return [(s, abs(slope))] if within(x + s * d) else []


def box_hits(x, d, half):
    found = []
    for axis in range(3):
        others = [i for i in range(3) if i != axis]
        for sign in (-1.0, 1.0):
            normal = sign * np.eye(3)[axis]
            found += plane_hits(x, d, normal, half[axis], lambda p, o=others: (np.abs(p[o]) <= half[o] + 1e-13).all())
    return found


def quadric_hits(x, d, radius, axes):
    a, b, c = d[axes] @ d[axes], 2.0 * x[axes] @ d[axes], x[axes] @ x[axes] - radius**2
    roots = np.roots([a, b, c]) if a > 0.0 else np.array([])
    found = []
    for s in roots[np.isreal(roots)].real:
        normal = np.zeros(3)
        normal[axes] = (x + s * d)[axes] / radius
        found.append((s, abs(normal @ d)))
    return found


def cylinder_hits(x, d, radius, half):
    side = [(s, sine) for s, sine in quadric_hits(x, d, radius, [0, 1]) if abs((x + s * d)[2]) <= half]
    for sign in (-1.0, 1.0):
        side += plane_hits(x, d, np.array([0.0, 0.0, sign]), half, lambda p: np.hypot(p[0], p[1]) <= radius)
    return side


def triangle_hits(x, d, corners):
    found = []
    for a, b, c in corners:
        system = np.column_stack([b - a, c - a, -d])
        if abs(np.linalg.det(system)) < 1e-14:
            continue
        u, v, s = np.linalg.solve(system, x - a)
        if u >= -1e-13 and v >= -1e-13 and u + v <= 1.0 + 1e-13:
            normal = np.cross(b - a, c - a)
            found.append((s, abs(normal @ d) / np.linalg.norm(normal)))
    return found


def random_obstacle(rng):
    kind, place, turn = rng.integers(4), rng.normal(size=3), Rotation.from_quat(rng.normal(size=4))
    if kind == 0:
        size = rng.uniform(0.1, 1.5, 3)
        shape, hits = Box(tuple(size)), lambda x, d: box_hits(x, d, size / 2)
    elif kind == 1:
        radius = rng.uniform(0.1, 1.0)
        shape, hits = Sphere(radius), lambda x, d: quadric_hits(x, d, radius, [0, 1, 2])
    elif kind == 2:
        radius, height = rng.uniform(0.1, 1.0), rng.uniform(0.1, 2.0)
        shape, hits = Cylinder(radius, height), lambda x, d: cylinder_hits(x, d, radius, height / 2)
    else:
        points = rng.normal(size=(10, 3))
        corners = points[ConvexHull(points).simplices]
        shape, hits = Hull("hull.stl", tuple(map(tuple, points.tolist()))), lambda x, d: triangle_hits(x, d, corners)
    obstacle = Obstacle(f"o{rng.integers(1 << 30)}", shape, place, turn.as_quat(scalar_first=True))
    return obstacle, lambda x, d: hits(turn.inv().apply(x - place), turn.inv().apply(d))


@pytest.mark.parametrize("count", [300, pytest.param(5_000, marks=pytest.mark.slow)])
def test_distances_are_those_of_independent_casters(count):
    rng = np.random.default_rng(0)
    met = 0
    for _ in range(count):
        obstacle, hits = random_obstacle(rng)
        start = 4.0 * rng.normal(size=3)
        direction = obstacle.position + 0.5 * rng.normal(size=3) - start
        direction /= np.linalg.norm(direction)
        (found,) = ray_distances([obstacle], start, [direction], REACH)
        surface = sorted(hits(start, direction))
        ahead = [(s, sine) for s, sine in surface if s > 0.0]
        if any(sine < GRAZING for _, sine in ahead):
            continue
        inside = len(ahead) == 1
        expected = 0.0 if inside else ahead[0][0] if ahead else REACH
        sine = ahead[0][1] if ahead and not inside else 1.0
        assert abs(found - expected) < CLOSE / sine, (found, expected)
        met += 0.0 < found < REACH
    assert met > 0.2 * count


def test_the_nearest_of_several_obstacles_counts():
    balls = [
        Obstacle(f"b{i}", Sphere(0.5), [x, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]) for i, x in enumerate((5.0, 3.0, -2.0))
    ]
    assert ray_distances(balls, [0.0, 0.0, 0.0], [[2.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], 9.0).tolist() == [2.5, 1.5]
    assert ray_distances([], [0.0, 0.0, 0.0], [[1.0, 0.0, 0.0]], 9.0).tolist() == [9.0]


@pytest.mark.parametrize("ray", [[0.0, 0.0, 0.0], [np.nan, 0.0, 0.0]])
def test_directions_without_length_are_rejected(ray):
    with pytest.raises(cdpr.CdprError, match="directions: expected finite vectors that are not 0"):
        ray_distances([], [0.0, 0.0, 0.0], [ray], 1.0)
    with pytest.raises(cdpr.CdprError, match="expected a start"):
        ray_distances([], [0.0, 0.0], [[1.0, 0.0, 0.0]], 1.0)


def test_a_robot_measures_floor_and_walls():
    floor = {"name": "floor", "box": [20, 20, 0.2], "position": [0, 0, -0.1]}
    wall = {"name": "wall", "box": [0.2, 20, 20], "position": [4.1, 0, 0]}
    sensors = [
        {"type": "range", "name": "height", "direction": [0, 0, -2], "point": [0.1, 0, -0.2]},
        {"type": "scan", "first": -0.4, "last": 0.4, "rays": 4, "distance": {"bias": 0.5}},
    ]
    overrides = {"simulation.duration": 0.3, "world.obstacles": [floor, wall], "sensors": sensors}
    run = cdpr.simulate(str(ROOT / "scenarios" / "caroca.yaml"), overrides=overrides)
    attitude = Rotation.from_quat(run.orientation, scalar_first=True)
    start = run.position + attitude.apply([0.1, 0.0, -0.2])
    down = attitude.apply([0.0, 0.0, -1.0])
    assert np.abs(run["height_distance"] - start[:, 2] / -down[:, 2]).max() < CLOSE
    for i, angle in enumerate(np.linspace(-0.4, 0.4, 4)):
        ray = attitude.apply([np.cos(angle), np.sin(angle), 0.0])
        expected = (4.0 - run.position[:, 0]) / ray[:, 0] + 0.5
        assert np.abs(run["scan_distance"][:, i] - expected).max() < CLOSE
