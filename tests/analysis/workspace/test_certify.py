"""Boxes that are proved: against other means at positions within them, by the million and in rational arithmetic."""

from __future__ import annotations

import dataclasses
import json
import os
from fractions import Fraction
from functools import cache

import exact
import numpy as np
import pytest
from workspace_cases import cli, robot_of

from cdpr.analysis.distribution import distribute
from cdpr.analysis.workspace.answers import free, margin
from cdpr.analysis.workspace.certify import INSIDE, NEITHER, OUTSIDE
from cdpr.analysis.workspace.oracle import compare
from cdpr.analysis.workspace.question import Question
from cdpr.analysis.workspace.regions import region
from cdpr.analysis.workspace.required import box, ellipsoid
from cdpr.analysis.workspace.result import load_workspace, workspace
from cdpr.base.errors import CdprError
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state

CASES = int(os.environ.get("CDPR_WORKSPACE_CASES", "1"))
SAMPLES = 25_000 * CASES  # of each robot
BOX = box([20, 20, 20, 2, 2, 2])
# Allowed round-off between margin and proof: margins are exact to 1e-9 of what they are differences of.
ROUNDING = 1e-9


@cache  # several tests use the same proofs, which take seconds
def certified(name, kind="static", undecided=0.2, robot=None, **asked):
    robot = robot or robot_of(name)
    found = workspace(robot, kind, region(robot, cells=12), method="certify", undecided=undecided, **asked)
    return found, robot


def samples(found, count, seed=1, verdict=None):
    """Positions in decided boxes, of any size alike, a few on their corners; and what is proved of them."""
    rng = np.random.default_rng(seed)
    known = np.flatnonzero(found.proofs.proved != NEITHER if verdict is None else found.proofs.proved == verdict)
    chosen = rng.choice(known, size=count)
    low, high = found.proofs.corners()
    share = rng.random((count, 3))
    share[::5] = rng.integers(0, 2, (len(share[::5]), 3))
    return low[chosen] + share * (high - low)[chosen], found.proofs.proved[chosen]


def poses(found, positions):
    return np.concatenate([positions, np.repeat(found.region.orientations, len(positions), axis=0)], axis=1)


def contradicted(found, robot, positions, proved):
    """How many proofs the margins are against."""
    measured = margin(robot, poses(found, positions), found.question)
    off = ROUNDING * measured.scale
    return int(
        ((proved == INSIDE) & (measured.value < -off)).sum() + ((proved == OUTSIDE) & (measured.value > off)).sum()
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["cogiro", "caroca", "ipanema_1", "planar", "point_mass", "planar_point_mass", "seven"]
)
def test_nothing_is_proved_that_is_not_so(name):
    found, robot = certified(name, "static")
    assert set(np.unique(found.proofs.proved)) >= {INSIDE, OUTSIDE} or name in ("caroca", "planar_point_mass")
    assert contradicted(found, robot, *samples(found, 20_000)) == 0
    shares = found.proofs.shares()
    assert shares["undecided"] <= 0.2
    assert sum(shares.values()) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.slow
def test_wrenches_at_all_corners_and_accelerations():
    for kind, required in (("wrench-feasible", BOX), ("dynamic", box([1, 1, 1, 0.5, 0.5, 0.5], accelerations=True))):
        found, robot = certified("cogiro", kind, required=required)
        assert found.proofs.shares()["proved_inside"] > 0.3
        assert contradicted(found, robot, *samples(found, 20_000)) == 0


@pytest.mark.slow
def test_more_is_not_inside_than_with_less_required():
    some, _ = certified("cogiro", "static")
    more, _ = certified("cogiro", "wrench-feasible", required=BOX)
    assert more.volume < some.volume
    grid = workspace(robot_of("cogiro"), "wrench-feasible", region(robot_of("cogiro"), cells=60), required=BOX)
    whole = grid.region.cell * grid.region.cells
    assert more.volume < grid.volume < more.volume + more.proofs.shares()["undecided"] * whole


@pytest.mark.slow
def test_clearances_are_kept_throughout_boxes():
    found, robot = certified("cogiro", "ifcow", diameter=0.3)
    positions, proved = samples(found, 20_000)
    value = free(robot, poses(found, positions), found.question).value
    assert {INSIDE, OUTSIDE} == set(np.unique(proved).tolist())
    assert np.array_equal(value > 0.0, proved == INSIDE)


@pytest.mark.slow
@pytest.mark.parametrize("over", [pytest.param("all", marks=pytest.mark.slow), "any"])
def test_several_attitudes(over):
    robot = robot_of("cogiro")
    turned = np.array([[1.0, 0, 0, 0], [np.cos(0.1), 0, 0, np.sin(0.1)]])
    place = region(robot, cells=12, orientations=turned)
    found = workspace(robot, "static", place, method="certify", undecided=0.2, over=over)
    positions, proved = samples(found, 5000)
    each = [margin(robot, np.hstack([positions, np.tile(q, (5000, 1))]), found.question).value >= 0 for q in turned]
    both = np.logical_and(*each) if over == "all" else np.logical_or(*each)
    assert np.array_equal(both, proved == INSIDE)


@pytest.mark.slow
def test_cells_show_the_boxes_and_the_file_holds_them(tmp_path):
    found, _ = certified("cogiro", "static")
    at = found.proofs.at(found.region.positions(np.arange(found.region.cells))).reshape(found.inside.shape)
    assert np.array_equal(at == INSIDE, found.inside)
    assert np.array_equal(at == NEITHER, found.boundary)
    positions, proved = samples(found, 2000, verdict=INSIDE)
    middle = np.clip(positions, found.region.lower + 1e-9, found.region.upper - 1e-9)
    assert (found.proofs.at(middle) == proved).mean() > 0.8  # the others are on corners, where boxes of others begin
    found.save(tmp_path / "w.npz")
    read = load_workspace(tmp_path / "w.npz")
    assert read.summary() == found.summary()
    assert read.volume == found.volume
    for a, b in zip(read.proofs.corners(), found.proofs.corners(), strict=True):
        assert np.array_equal(a, b)


@pytest.mark.slow
def test_threads_and_programs_agree():
    found, robot = certified("planar", "static")
    alone = workspace(robot, "static", found.region, method="certify", undecided=0.2, jobs=1)
    assert np.array_equal(alone.proofs.proved, found.proofs.proved)
    agreement = compare(found, robot, 200)
    assert agreement.poses == 200
    assert agreement.different == []


@pytest.mark.parametrize(
    ("name", "kind", "asked", "message"),
    [
        ("cogiro_pulleys", "static", {}, "something else than a point, as 'cable_1' does"),
        ("cogiro", "closure", {}, "certify supports static.*, not closure"),
        ("cogiro", "static", {"at_least": 5.0}, "margins above 0 only"),
        ("cogiro", "wrench-feasible", {"required": ellipsoid([9, 9, 9, 1, 1, 1])}, "use a box around it"),
        ("cogiro", "static", {"undecided": 1.0}, "a share from 0 to below 1"),
    ],
)
def test_unprovable_requests_are_rejected(name, kind, asked, message):
    robot = robot_of(name)
    with pytest.raises(CdprError, match=message):
        workspace(robot, kind, region(robot, cells=4), method="certify", **asked)


@pytest.mark.slow
def test_a_robot_that_holds_nothing_ends_soon():
    robot = robot_of("cogiro")
    weak = tuple(dataclasses.replace(cable, tension_min=100.0, tension_max=100.5) for cable in robot.cables)
    robot = dataclasses.replace(robot, cables=weak)
    found, _ = certified("", robot=robot, undecided=0.1)
    assert found.volume == 0.0
    assert found.proofs.shares()["proved_outside"] >= 0.9


@pytest.mark.slow
def test_the_command_proves(tmp_path):
    told = cli("workspace", "static", "scenarios/robots/cogiro.yaml", "--method", "certify", "--undecided", "0.3")
    assert told.returncode == 0
    assert "% inside" in told.stdout
    assert "at most" in told.stdout
    out = tmp_path / "w.npz"
    told = cli(
        *("workspace", "static", "scenarios/robots/cogiro.yaml", "--method", "certify", "--undecided", "0.3"),
        *("--json", "--cells", "10", "--out", str(out)),
    )
    figures = json.loads(told.stdout)
    assert figures["found"]["shares"]["proved_inside"] + figures["found"]["shares"]["proved_outside"] >= 0.7
    assert out.exists()
    told = cli("workspace", "static", "scenarios/robots/cogiro.yaml", "--undecided", "0.3")
    assert told.returncode == 2
    assert "--method certify" in told.stderr


@pytest.mark.slow
@pytest.mark.parametrize(("name", "undecided"), [("cogiro", 0.04), ("caroca", 0.06)])
def test_no_proof_of_a_large_share_is_against_many_samples(name, undecided):
    found, robot = certified(name, undecided=undecided)
    assert found.proofs.shares()["undecided"] <= undecided
    assert contradicted(found, robot, *samples(found, SAMPLES)) == 0


CHECKED = 15 * CASES  # boxes of each kind, in rational arithmetic


@pytest.mark.slow
@pytest.mark.parametrize("verdict", [INSIDE, OUTSIDE])
@pytest.mark.parametrize(("kind", "asked"), [("static", {}), ("wrench-feasible", {"required": BOX})])
def test_forces_in_rational_arithmetic(kind, asked, verdict):
    found, robot = certified("cogiro", kind, 0.1, **asked)
    positions, _ = samples(found, CHECKED, verdict=verdict)
    at, q = poses(found, positions), found.region.orientations[0]
    carried = required_wrench(robot, make_state((0, 0, 0), q), found.question.gravity)
    corners = found.question.required.corners()
    rng = np.random.default_rng(2)
    which = rng.integers(len(corners), size=CHECKED)
    normals = margin(robot, at, found.question).direction
    wrenches = carried + corners[which]
    if verdict == OUTSIDE:
        arm = np.repeat([1.0, found.question.arm(robot)], 3)
        normals = normals / arm  # of wrenches whose moments are not divided
        wrenches = carried + corners[np.argmax(corners @ normals.T, axis=0)]
    tensions = distribute(robot, at, wrenches, solver="maximin").tension if verdict == INSIDE else None
    failed = 0
    for k in range(CHECKED):
        position, wrench = list(map(Fraction, positions[k].tolist())), list(map(Fraction, wrenches[k].tolist()))
        if verdict == INSIDE:
            failed += not exact.holds(robot, position, q, wrench, tensions[k])
        else:
            failed += not exact.beyond(robot, position, q, wrench, normals[k])
    assert failed == 0


@cache
def bare_robot():
    """A robot whose platform has no shape, so that only cables can touch."""
    robot = robot_of("cogiro")
    return dataclasses.replace(robot, platform=dataclasses.replace(robot.platform, shape=None))


@pytest.mark.slow
@pytest.mark.parametrize("verdict", [INSIDE, OUTSIDE])
def test_clearances_in_rational_arithmetic(verdict):
    robot = bare_robot()
    found, _ = certified("", "ifcow", 0.2, robot=robot, diameter=0.3)
    positions, _ = samples(found, CHECKED, verdict=verdict)
    thick, q, failed = Fraction(0.3) ** 2, found.region.orientations[0], 0
    for position in positions.tolist():
        ends = exact.cables(robot, list(map(Fraction, position)), q)
        gaps = (exact.gap(*ends[i], *ends[j]) for i in range(robot.m) for j in range(i))
        failed += any(gap <= thick for gap in gaps) == (verdict == INSIDE)
    assert failed == 0


@pytest.mark.slow
def test_questions_without_anything_are_those_of_the_weight():
    robot = robot_of("cogiro")
    place = region(robot, cells=4)
    assert workspace(robot, "static", place, Question(), method="certify", undecided=0.5).volume > 0.0
