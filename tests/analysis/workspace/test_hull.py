"""Boundaries seen from a point, and free stretches of rays: against grids, closed forms and dense sampling."""

from __future__ import annotations

import dataclasses
import json
from collections import Counter

import numpy as np
import pytest
from spread import sampled
from workspace_cases import cli, robot_of

from cdpr.analysis.workspace import hull as hulls
from cdpr.analysis.workspace.answers import free, margin
from cdpr.analysis.workspace.hull import hull
from cdpr.analysis.workspace.octree import CellResults
from cdpr.analysis.workspace.regions import Region, region
from cdpr.analysis.workspace.required import box
from cdpr.analysis.workspace.result import load_workspace, workspace
from cdpr.analysis.workspace.surface import surface
from cdpr.base.errors import CdprError

BOX = box([50, 50, 50, 5, 5, 5])


def quiet(done, total):
    assert 0 <= done <= total


def shape_of(value, region_, home=(0.0, 0.0, 0.0), rays=642):
    """The hull of {value > 0}."""

    def ask(positions):
        found = value(positions)
        return CellResults(found, np.zeros(len(found), int), found > 0.0, np.zeros(len(found), bool))

    return hull(ask, region_, 0.0, np.array(home), ask(region_.positions(np.arange(region_.cells))), rays, quiet)


def cube(cells=20):
    return Region(np.full(3, -2.0), np.full(3, 2.0), (cells,) * 3, np.array([[1.0, 0, 0, 0]]))


def test_a_ball_to_the_last_triangle():
    found = shape_of(lambda p: 1.5 - np.linalg.norm(p, axis=1), cube(), rays=10_000)
    assert len(found.corners) == 10 * 32**2 + 2
    assert np.linalg.norm(found.corners, axis=1) == pytest.approx(1.5, abs=hulls.ENOUGH * np.linalg.norm([4, 4, 4]))
    assert found.volume == pytest.approx(4.0 / 3.0 * np.pi * 1.5**3, rel=2e-3)
    assert found.seen == 1.0
    edges = Counter(
        tuple(sorted(e)) for t in found.triangles.tolist() for e in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0]))
    )
    assert set(edges.values()) == {2}


def test_boxes_are_cut_at_the_border_of_the_region():
    found = shape_of(lambda p: np.full(len(p), 1.0), cube(), rays=10_000)
    assert found.volume == pytest.approx(64.0, rel=5e-3)
    assert found.corners.min() == -2.0
    assert found.corners.max() == 2.0


def test_non_star_shaped_regions_are_reported():
    found = shape_of(lambda p: 0.3 - np.abs(np.linalg.norm(p[:, :2], axis=1) - 1.2), cube(), home=(1.2, 0.0, 0.0))
    assert found.seen < 0.7
    ring = shape_of(lambda p: 0.3 - np.abs(np.linalg.norm(p[:, :2], axis=1) - 1.2), cube())
    assert np.linalg.norm(ring.centre[:2]) == pytest.approx(1.2, abs=0.1)  # the home is in the hole


def test_of_nothing_there_is_none():
    found = shape_of(lambda p: np.full(len(p), np.nan), cube(4))
    assert (found.volume, len(found.corners), found.seen) == (0.0, 0, 0.0)


@sampled(1, "name", ["cogiro", pytest.param("caroca", marks=pytest.mark.slow), "ipanema_1"])
def test_volumes_are_those_of_fine_grids(name):
    robot = robot_of(name)
    grid = workspace(robot, "wrench-feasible", region(robot, cells=100), method="octree", required=BOX)
    found = workspace(robot, "wrench-feasible", region(robot, cells=20), method="hull", required=BOX, n_rays=10_000)
    assert found.volume == pytest.approx(grid.volume, rel=5e-3)
    assert found.detail.evaluated < 130_000
    assert found.detail.seen == 1.0
    corners = found.detail.corners
    there = margin(robot, np.hstack([corners, np.tile(found.region.orientations, (len(corners), 1))]), found.question)
    off = np.minimum(corners - found.region.lower, found.region.upper - corners)
    within = (off > 1e-9).all(axis=1)
    assert np.abs(there.value[within]).max() < 0.02 * found.value[found.inside].max()


@sampled(1, ("name", "ends"), [("planar", 2), ("planar_point_mass", 2), ("carriage", None)])
def test_in_a_plane(name, ends):
    robot = robot_of(name)
    place = region(robot, cells=300)
    grid, found = workspace(robot, "static", place), workspace(robot, "static", place, method="hull")
    assert found.volume == pytest.approx(grid.volume, rel=1e-2)
    if ends:
        assert found.detail.triangles.shape[1] == ends


def test_the_surface_is_the_hull_and_the_file_holds_it(tmp_path):
    robot = robot_of("cogiro")
    found = workspace(robot, "static", region(robot, cells=8), method="hull", n_rays=100)
    corners, triangles = surface(found)
    assert np.array_equal(corners, found.detail.corners)
    found.save(tmp_path / "w.npz")
    read = load_workspace(tmp_path / "w.npz")
    assert read.summary() == found.summary()
    assert np.array_equal(read.detail.triangles, triangles)


@pytest.mark.parametrize(("name", "diameter"), [("caroca", 0.02), ("cogiro", 0.3)])
@pytest.mark.usual("cogiro-*")
def test_free_stretches_against_dense_sampling(name, diameter):
    robot = robot_of(name)
    place = region(robot, cells=(6, 5, 50))
    found = workspace(robot, "ifcow", place, method="rays", diameter=diameter)
    rays = found.detail
    z = np.linspace(place.lower[2], place.upper[2], 4001)
    xs, ys = place.axes[0], place.axes[1]
    checked = 0
    for number in range(len(xs) * len(ys)):
        i, j = divmod(number, len(ys))
        poses = np.zeros((len(z), 7))
        poses[:, 0], poses[:, 1], poses[:, 2], poses[:, 3:] = xs[i], ys[j], z, place.orientations[0]
        value = free(robot, poses, found.question).value
        stretches = rays.free[rays.number == number]
        within = ((z[:, None] > stretches[:, 0]) & (z[:, None] < stretches[:, 1])).any(axis=1)
        sure = np.abs(value) > 1e-9
        assert np.array_equal(within[sure & (z > z[0]) & (z < z[-1])], (value > 0)[sure & (z > z[0]) & (z < z[-1])])
        for end in stretches.ravel():
            if place.lower[2] < end < place.upper[2]:
                poses[0, 2] = end
                assert abs(free(robot, poses[:1], found.question).value[0]) < 1e-9
                checked += 1
    assert checked >= 8
    assert found.inside.ravel().tolist() == rays.at_cells().tolist()
    length = (rays.free[:, 1] - rays.free[:, 0]).sum()
    assert found.volume == pytest.approx(length * np.prod(place.spacing[:2]))


@pytest.mark.slow
@pytest.mark.parametrize("over", ["all", "any"])
def test_rays_of_several_attitudes_and_threads(over, tmp_path):
    robot = robot_of("cogiro")
    turned = np.array([[1.0, 0, 0, 0], [np.cos(0.2), 0, 0, np.sin(0.2)]])
    place = region(robot, cells=(20, 16, 10), orientations=turned)
    found = workspace(robot, "ifcow", place, method="rays", diameter=0.2, over=over)
    alone = workspace(robot, "ifcow", place, method="rays", diameter=0.2, over=over, jobs=1)
    assert np.array_equal(found.detail.free, alone.detail.free)
    grid = workspace(robot, "ifcow", place, diameter=0.2, over=over)
    assert np.array_equal(found.inside, grid.inside)
    found.save(tmp_path / "w.npz")
    read = load_workspace(tmp_path / "w.npz")
    assert read.summary() == found.summary()
    assert np.array_equal(read.detail.free, found.detail.free)


def test_unsupported_uses_of_rays_and_hulls():
    robot = robot_of("cogiro")
    place = region(robot, cells=3)
    with pytest.raises(CdprError, match="rays are for ifcow"):
        workspace(robot, "static", place, method="rays")
    pulleys = robot_of("cogiro_pulleys")
    with pytest.raises(CdprError, match="leave from points"):
        workspace(pulleys, "ifcow", region(pulleys, cells=3), method="rays", diameter=0.01)
    with pytest.raises(CdprError, match="a whole number from 4"):
        workspace(robot, "static", place, method="hull", n_rays=2)


def test_pulleys_have_no_slope():
    pulleys = workspace(robot_of("cogiro_pulleys"), "ifcow", region(robot_of("cogiro_pulleys"), cells=3), diameter=0.01)
    assert pulleys.kind.slope_of(robot_of("cogiro")) == 1.0
    assert pulleys.kind.slope_of(robot_of("cogiro_pulleys")) is None


@pytest.mark.slow
def test_the_commands(tmp_path):
    told = cli("workspace", "static", "scenarios/robots/cogiro.yaml", "--method", "hull", "--json", "--cells", "10")
    assert json.loads(told.stdout)["found"]["star_shaped"] == 1.0
    told = cli("workspace", "static", "scenarios/robots/cogiro.yaml", "--method", "hull", "--cells", "10")
    assert "2562 rays from 0, 0, 2 m, from where 100 % of what is inside is seen" in told.stdout
    asked = ("workspace", "ifcow", "scenarios/robots/cogiro.yaml", "--cable-diameter", "0.02", "--method", "rays")
    told = cli(*asked, "--cells", "10", "--out", tmp_path / "w.npz")
    assert "along z" in told.stdout
    assert cli("workspace", "plot", tmp_path / "w.npz").returncode == 0
    told = cli("workspace", "static", "scenarios/robots/cogiro.yaml", "--rays", "100")
    assert (told.returncode, "--method hull" in told.stderr) == (2, True)


def test_a_robot_that_holds_nothing_has_an_empty_hull():
    robot = robot_of("cogiro")
    weak = tuple(dataclasses.replace(cable, tension_min=100.0, tension_max=100.5) for cable in robot.cables)
    robot = dataclasses.replace(robot, cables=weak)
    found = workspace(robot, "static", region(robot, cells=5), method="hull")
    assert found.volume == 0.0
    assert found.summary()["found"]["rays"] == 0
