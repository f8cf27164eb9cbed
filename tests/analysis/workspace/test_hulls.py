"""Convex meshes in the way of cables: hulls against another program's, distances against other ways to find them."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from conftest import ROOT
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls
from scipy.spatial import ConvexHull
from workspace_cases import cli

from cdpr import load_scenario
from cdpr.analysis.workspace.question import Question
from cdpr.base.errors import ScenarioError
from cdpr.mechanics import solids
from cdpr.mechanics.clearance import clearance
from cdpr.mechanics.distances import solid_distances
from cdpr.model import hull, rotations
from cdpr.model.hull import convex_hull
from cdpr.model.shapes import Box, Hull, Obstacle

SAME = 1e-9  # m
CAROCA = ROOT / "scenarios" / "robots" / "caroca.yaml"


def box(count=2):
    """Points (k, 3) of a unit box, also on its faces and within, where `count` is more than 2."""
    steps = np.linspace(-0.5, 0.5, count)
    return np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)


def prism(corners, height):
    angle = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    flat = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.concatenate([np.column_stack([flat, np.full(corners, z)]) for z in np.linspace(0.0, height, 3)])


def points_of(kind, rng):
    points = {
        "any": lambda: rng.standard_normal((rng.integers(4, 60), 3)),
        "thin": lambda: rng.standard_normal((30, 3)) * [1.0, 1.0, 1e-3],
        "box": lambda: box(int(rng.integers(2, 6))) * rng.uniform(0.1, 3.0, 3),
        "prism": lambda: prism(int(rng.integers(3, 20)), rng.uniform(0.05, 2.0)),
        "two": lambda: np.concatenate([box(3), box(4) + np.array([0.4, 0.3, 0.2])]),
    }[kind]()
    q = rng.standard_normal(4)
    turned = points @ rotations.matrix(q / np.linalg.norm(q)).T + rng.uniform(-2.0, 2.0, 3)
    return turned.astype(np.float32).astype(float) if rng.random() < 0.5 else turned  # as in STL


KINDS = st.sampled_from(["any", "thin", "box", "prism", "two"])


def outside_distance(corners, a, b):
    """Of a segment from a hull: the point of least norm of their differences, by Lawson and Hanson's NNLS."""
    points = np.concatenate([corners - a, corners - b])
    size = np.abs(points).max()
    found, _ = nnls(np.vstack([points.T / size, np.ones(len(points))]), np.array([0.0, 0.0, 0.0, 1.0]))
    return float(np.linalg.norm(points.T @ (found / found.sum())))


def inside_distance(corners, a, b):
    """The least height above the highest face: at an end, or where any two of the faces are as high."""
    planes = np.unique(ConvexHull(corners).equations.round(13), axis=0)
    low, up = planes[:, :3] @ a + planes[:, 3], planes[:, :3] @ (b - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        meet = (low[:, None] - low) / (up - up[:, None])
    where = np.concatenate([[0.0, 1.0], meet[(meet > 0.0) & (meet < 1.0)]])
    return float((low + where[:, None] * up).max(axis=1).min())


@given(seed=st.integers(0, 10**6), kind=KINDS)
def test_a_hull_is_that_of_another_program(seed, kind):
    points = points_of(kind, np.random.default_rng(seed))
    corners, triangles = convex_hull(points)
    known = ConvexHull(points)
    size = np.ptp(points, axis=0).max()
    assert {tuple(each) for each in corners.tolist()} <= {tuple(each) for each in points.tolist()}
    a, b, c = (corners[triangles[:, i]] - corners[0] for i in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    assert volume == pytest.approx(known.volume, abs=hull.FLAT * size * known.area)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    above = points @ normals.T - np.einsum("ij,ij->i", normals, corners[triangles[:, 0]])
    assert above.max() <= 1.001 * hull.FLAT * size


def test_points_on_faces_and_inside_are_omitted():
    corners, triangles = convex_hull(box(7) * [2.0, 1.0, 0.5])
    assert len(corners) == 8
    assert len(triangles) == 12


@pytest.mark.parametrize(
    ("points", "said"),
    [
        (np.zeros((0, 3)), "it has no volume"),
        (np.ones((50, 3)), "it has no volume"),
        (np.linspace(0.0, 1.0, 30)[:, None] * [1.0, 2.0, 3.0], "it has no volume"),
        (box(5)[:25] * [1.0, 0.0, 1.0], "it has no volume"),
        (prism(200, 1.0), "more than 256 corners"),
    ],
)
def test_invalid_hulls_are_reported(points, said):
    with pytest.raises(ValueError, match=said):
        convex_hull(points)


def test_the_largest_hull_that_is_taken():
    corners, _ = convex_hull(prism(hull.MOST_CORNERS // 2, 1.0))
    assert len(corners) == hull.MOST_CORNERS


@given(seed=st.integers(0, 10**6), kind=KINDS, near=st.sampled_from(["any", "through", "end in", "grazing"]))
def test_distance_of_a_cable(seed, kind, near):
    rng = np.random.default_rng(seed)
    corners, _ = convex_hull(points_of(kind, rng))
    middle, size = corners.mean(axis=0), np.ptp(corners, axis=0).max()
    a, b = middle + size * rng.uniform(-1.5, 1.5, (2, 3))
    if near == "through":
        b = 2.0 * (corners.T @ rng.dirichlet(np.ones(len(corners)))) - a
    elif near == "end in":
        b = corners.T @ rng.dirichlet(np.ones(len(corners)))
    elif near == "grazing":  # an edge or a face, by less than is round-off of metres
        i, j = rng.choice(len(corners), 2, replace=False)
        b = 2.0 * (0.5 * (corners[i] + corners[j])) - a + 1e-10 * rng.standard_normal(3)
    attitude = rng.standard_normal(4)
    attitude /= np.linalg.norm(attitude)
    position = rng.uniform(-3.0, 3.0, 3)
    row = solids.row(Hull("", tuple(map(tuple, corners.tolist()))), position, tuple(attitude.tolist()))
    (found,) = solid_distances(row, [np.concatenate([rotations.matrix(attitude) @ x + position for x in (a, b)])])
    inside = inside_distance(corners, a, b)
    assert found == pytest.approx(inside if inside < -SAME else outside_distance(corners, a, b), abs=SAME)


@given(seed=st.integers(0, 10**6))
def test_a_box_of_triangles_is_a_box(seed):
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.1, 2.0, 3)
    mesh = solids.row(Hull("", tuple(map(tuple, (box() * size).tolist()))))
    solid = solids.row(Box(tuple(size.tolist())))
    segments = rng.uniform(-1.5, 1.5, (1, 6))
    np.testing.assert_allclose(solid_distances(mesh, segments), solid_distances(solid, segments), atol=SAME)


def test_a_row_too_short_for_its_triangles_has_no_distance():
    row = solids.row(Hull("", tuple(map(tuple, box().tolist()))))
    for changed in (
        row[:-1],
        np.concatenate([row[:8], [1e300], row[9:]]),
        np.concatenate([row[:8], [np.nan], row[9:]]),
    ):
        assert np.isnan(solid_distances(changed, np.ones((1, 6)))).all()


def stl(points):
    """Binary STL of all faces of a hull."""
    triangles = ConvexHull(points).simplices
    rows = [struct.pack("<12fH", 0.0, 0.0, 0.0, *points[each].ravel(), 0) for each in triangles]
    return bytes(80) + struct.pack("<I", len(rows)) + b"".join(rows)


SCENARIO = """robot: caroca.yaml
simulation: {duration: 0.1}
world:
  obstacles:
  - {mesh: parts/tool.stl, position: [1.2, 0.4, 2.0], orientation: {rpy_deg: [0, 20, 30]}}
  - {box: [0.2, 0.2, 0.2], position: [-1, -1, 3]}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "caroca.yaml").write_text(CAROCA.read_text())
    (tmp_path / "s.yaml").write_text(SCENARIO)
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "tool.stl").write_bytes(stl(box() * [1.0, 0.5, 0.25]))
    return tmp_path


def test_a_mesh_of_a_scenario_is_in_the_way(folder):
    loaded = load_scenario(folder / "s.yaml", overrides={"robot.cable.diameter": 0.01})
    first, second = loaded.obstacles
    boxes = [Obstacle(first.name, Box((1.0, 0.5, 0.25)), first.position, first.attitude), second]
    rng = np.random.default_rng(1)
    poses = np.concatenate([rng.uniform([-2, -1, 0.5], [2, 1, 3], (200, 3)), np.tile([1.0, 0, 0, 0], (200, 1))], axis=1)
    values, which = clearance(loaded.robot, loaded.obstacles).at(poses)
    expected, of = clearance(loaded.robot, boxes).at(poses)
    np.testing.assert_allclose(values, expected, rtol=0.0, atol=SAME)
    assert np.array_equal(which, of)
    assert (which >= loaded.robot.m * (loaded.robot.m + 1)).any()
    kept = Question.from_plain(json.loads(json.dumps(Question(obstacles=loaded.obstacles).to_dict(loaded.robot))))
    np.testing.assert_array_equal(clearance(loaded.robot, kept.obstacles).at(poses)[0], values)


def test_it_is_found_from_other_folders(folder):
    (folder / "else").mkdir()
    loaded = load_scenario(folder / "s.yaml")
    text = loaded.yaml_in(str(folder / "else"))
    assert 'mesh: "../parts/tool.stl"' in text
    (folder / "else" / "s.yaml").write_text(text)
    again = load_scenario(folder / "else" / "s.yaml")
    assert again.obstacles[0].shape.corners == loaded.obstacles[0].shape.corners


def test_a_workspace_requires_it(folder):
    words = ("workspace", "ifcow", folder / "s.yaml", "--cable-diameter", "0.01", "--cells", "6", "--json")
    told = json.loads(cli(*words).stdout)
    assert any(name.endswith("and obstacle 1") for name in told["outside_by"])


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("none.stl", None, r"world.obstacles\[0\].mesh: there is no file"),
        ("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n", "is not an obstacle: it has no volume"),
        ("fine.obj", "".join(f"v {x} {y} {z}\n" for x, y, z in prism(150, 1.0).tolist()), "has more than 256 corners"),
        ("a.ply", "ply\n", "expected a mesh file that ends with .stl or .obj"),
        ("bad.obj", "v 0 0\n", "expected three numbers"),
    ],
)
def test_invalid_obstacles_are_reported_with_their_position(folder, name, content, said):
    if content is not None:
        (folder / "parts" / name).write_text(content)
    (folder / "s.yaml").write_text(SCENARIO.replace("tool.stl", name))
    with pytest.raises(ScenarioError, match=said) as told:
        load_scenario(folder / "s.yaml")
    assert "s.yaml:5:12: world.obstacles[0].mesh: " in str(told.value)
