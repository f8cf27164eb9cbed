"""Workspaces that evaluate only the deciding cells."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from spread import sampled
from workspace_cases import cli, robot_of

from cdpr.analysis.workspace.octree import CellResults, octree
from cdpr.analysis.workspace.oracle import compare
from cdpr.analysis.workspace.regions import Region, region
from cdpr.analysis.workspace.required import box
from cdpr.analysis.workspace.result import load_workspace, workspace
from cdpr.base.errors import CdprError

BOX = box([50, 50, 50, 5, 5, 5])
# Share of the cells inside that may be wrong: 1 in 2500 of Caroca's at 160 cells, twice as many at half of them.
WRONG = 1e-3


def both(name, kind, cells, **asked):
    robot = robot_of(name)
    place = region(robot, cells=cells)
    return workspace(robot, kind, place, **asked), workspace(robot, kind, place, method="octree", **asked)


@sampled(1, "name", ["cogiro", "caroca", "ipanema_1"])
def test_it_is_the_grid_at_a_fifth_of_the_poses(name):
    grid, tree = both(name, "wrench-feasible", 80, required=BOX)
    asked = tree.evaluated
    assert asked.sum() < 0.2 * asked.size
    for one, other in ((grid.value, tree.value), (grid.inside, tree.inside), (grid.limit, tree.limit)):
        assert np.array_equal(one[asked], other[asked], equal_nan=one.dtype.kind == "f")
    assert np.count_nonzero(grid.inside != tree.inside) <= WRONG * grid.inside.sum()
    assert np.isfinite(tree.value[np.isfinite(grid.value)]).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cogiro", "caroca", "ipanema_1"])
def test_volumes_of_fine_grids_at_80_000_poses(name):
    grid, tree = both(name, "wrench-feasible", (160, 160, 160), required=BOX)
    assert tree.evaluated.sum() <= 80_000
    assert tree.volume == pytest.approx(grid.volume, rel=2e-3)


@pytest.mark.parametrize("name", ["cogiro", "caroca"])
def test_clearances_are_never_reported_wrongly(name):
    """They change by no more than a metre per metre: what is thin is found as well."""
    grid, tree = both(name, "ifcow", 60, diameter=0.02)
    assert np.array_equal(grid.inside, tree.inside)
    assert not tree.evaluated.all()


@sampled(1, "kind", ["payload", "stable", "stiffness", "dexterity"])
def test_values_may_be_missing_or_infinite(kind):
    asked = {"axial_stiffness": 1e5} if kind in ("stable", "stiffness") else {}
    grid, tree = both("caroca", kind, 40, at_least={"dexterity": 0.1}.get(kind), **asked)
    assert np.array_equal(grid.inside, tree.inside)
    assert np.array_equal(np.isnan(grid.value), np.isnan(tree.value))


def plain(shape, upper=(1.0, 1.0, 1.0)):
    return Region(np.zeros(3), np.array(upper), shape, np.array([[1.0, 0.0, 0.0, 0.0]]))


def asked_of(place, value):
    """Answer cells by a function of their middles, and count."""
    calls = []

    def ask(cells):
        calls.append(len(cells))
        found = value(place.positions(cells))
        return CellResults(found, np.zeros(len(cells), dtype=np.int64), found >= 0.0, found == 0.0)

    return ask, calls


@given(
    shape=st.tuples(*[st.integers(1, 70)] * 3),
    normal=st.tuples(*[st.floats(-1, 1)] * 3),
    offset=st.floats(-1, 1),
)
def test_planes_are_exact_for_any_cells(shape, normal, offset):
    place = plain(shape)
    ask, calls = asked_of(place, lambda at: at @ np.array(normal) - offset)
    found, asked = octree(ask, place, 0.0, None, lambda done, of: None)
    exact = place.positions(np.arange(place.cells)) @ np.array(normal) - offset
    assert np.allclose(found.value, exact, rtol=0, atol=1e-12)
    assert np.array_equal(found.inside[abs(exact) > 1e-12], exact[abs(exact) > 1e-12] >= 0.0)
    assert sum(calls) == asked.sum()  # none twice


@given(
    shape=st.tuples(*[st.integers(1, 40)] * 3),
    centre=st.tuples(*[st.floats(0, 1)] * 3),
    radius=st.floats(0.01, 0.5),
)
def test_known_slopes_detect_small_regions(shape, centre, radius):
    place = plain(shape)

    def away(at):
        return np.linalg.norm(at - np.array(centre), axis=1) - radius

    ask, _ = asked_of(place, away)
    found, _ = octree(ask, place, 0.0, 1.0, lambda done, of: None)
    assert np.array_equal(found.inside, away(place.positions(np.arange(place.cells))) >= 0.0)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_the_same_everywhere_needs_the_first_corners_alone(value):
    place = plain((64, 64, 64))
    ask, calls = asked_of(place, lambda at: np.full(len(at), value))
    found, _ = octree(ask, place, 0.0, None, lambda done, of: None)
    assert np.array_equal(found.value, np.full(place.cells, value), equal_nan=True)
    assert sum(calls) == 17**3


def test_progress_ends_with_all_cells():
    place, told = plain((30, 20, 10)), []
    ask, _ = asked_of(place, lambda at: at[:, 0] - 0.5)
    octree(ask, place, 0.0, None, lambda done, of: told.append((done, of)))
    assert told[-1] == (place.cells, place.cells)


def test_an_unknown_method_is_reported():
    robot = robot_of("caroca")
    with pytest.raises(CdprError, match="method: expected one of grid, octree"):
        workspace(robot, "static", region(robot, cells=4), method="tree")


@pytest.mark.slow
def test_output_of_the_command_and_wrong_cells_in_compare(tmp_path):
    file = tmp_path / "w.npz"
    command = "workspace", "static", "caroca", "--cells", "40", "--method", "octree", "--out", str(file)
    told = cli(*command)
    assert "of them evaluated" in told.stdout
    found = load_workspace(file)
    assert found.about["method"] == "octree"
    assert not found.evaluated.all()
    told = json.loads(cli("workspace", "compare", str(file), "--count", "40", "--json").stdout)
    assert told["told"] > 0
    assert told["told_wrong"] == 0


def test_a_cell_that_is_reported_wrongly_is_counted():
    robot = robot_of("caroca")
    found = workspace(robot, "static", region(robot, cells=40), method="octree")
    found.inside[~found.evaluated] ^= True
    agreement = compare(found, robot, 40)
    assert agreement.told_wrong == agreement.told > 0
    assert not agreement.different
