"""Rank decisions on robots whose wrench matrix lacks rank, against a linear program and the optimality conditions.

CDPR_RANK=N tries N problems in place of a few.
"""

from __future__ import annotations

import os

import numpy as np
import pytest

import cdpr
from cdpr.analysis.workspace import workspace
from cdpr.analysis.workspace.oracle import compare
from cdpr.analysis.workspace.regions import region
from cdpr.mechanics.kinematics import make_state, wrench_matrix
from cdpr.model.rank import rank
from cdpr.model.rotations import from_axis_angle, matrix
from cdpr.plugins.registry import registry
from cdpr.tension import Status
from cdpr.testing.samples import make_robot

linprog = pytest.importorskip("scipy.optimize").linprog

COUNT = int(os.environ.get("CDPR_RANK", "16"))
SOLVERS = ("qp", "exact", "lp", "highs", "daqp", "clarabel", "piqp")  # that answer whatever can be answered
NORMS = {"qp", "exact", "daqp", "clarabel", "piqp"}  # that minimise the 2-norm

# A platform of which the cables cannot turn one axis: opposite corners, as in a box without crossing.
POINT = np.array([[x, y, z, x / 8, y / 8, (z - 1.5) / 12] for x in (-1, 1) for y in (-3, 3) for z in (0.0, 3.0)])


def problems(seed):
    """W (6, m) of rank 3 to 5 but for rounding, t with W t = wrench, and limits around it."""
    rng = np.random.default_rng(seed)
    span = float(10.0 ** rng.uniform(-3, 3))
    turn = matrix(from_axis_angle(rng.normal(size=3) / 2.0, float(rng.uniform(0, 3))))
    kind = seed % 3
    if kind == 0:  # all cables meet in one point: no moments about it
        anchors = np.hstack([rng.normal(size=(8, 3)), np.zeros((8, 3))])
        moved = rng.normal(size=3)
    elif kind == 1:  # all in one plane, turned anyhow
        anchors = np.hstack([rng.normal(size=(6, 3)), 0.1 * rng.normal(size=(6, 3))]) * [1, 1, 0, 1, 1, 0]
        moved = np.array([*rng.uniform(-0.2, 0.2, 2), 0.0])
    else:  # one axis that nothing turns
        anchors, moved = POINT.copy(), np.array([*rng.uniform(-0.3, 0.3, 2), 1.5])
        anchors[:, 5] = 0.0
        anchors[:, 3:5] = anchors[:, :2] / 8
    frame, platform = anchors[:, :3] @ turn.T * span, anchors[:, 3:] @ turn.T * span
    robot = make_robot(np.hstack([frame, platform]))
    W = np.ascontiguousarray(wrench_matrix(robot, make_state(turn @ moved * span, np.array([1.0, 0, 0, 0]))))
    force = float(10.0 ** rng.uniform(-6, 8))
    inside = force * rng.uniform(0.5, 1.0, robot.m)
    return robot, W, W @ inside, np.full(robot.m, 0.2 * force), np.full(robot.m, 1.5 * force), force, span


def optimal(W, t, low, high, force):
    """Return True if t is the shortest: t + multipliers is in the row space, multipliers only at active limits."""
    _, sizes, V = np.linalg.svd(W)
    N = V[int((sizes > 1e-9 * sizes[0]).sum()) :]
    at_low, at_high = t < low + 1e-6 * force, t > high - 1e-6 * force
    # The gradient along any feasible direction d = N^T x is not negative: min t.d subject to the active limits.
    inequality = np.concatenate([-N.T[at_low], N.T[at_high]])
    gain = (
        linprog(N @ t / force, inequality, np.zeros(len(inequality)), bounds=[(-1, 1)] * len(N))
        if len(inequality)
        else None
    )
    least = gain.fun if gain is not None else -np.abs(N @ t / force).sum()
    return least > -1e-5


@pytest.mark.parametrize("name", SOLVERS)
def test_solvers_with_rank_deficiency(name):
    entry = registry().get("solver", name)
    if entry.missing:
        pytest.skip(entry.remedy)
    for seed in range(COUNT):
        robot, W, wrench, low, high, force, span = problems(seed)
        t = np.full(robot.m, np.nan)
        status = entry.make(robot, entry.read_options({})).solve(W, wrench, low, high, t)
        assert status == Status.OK, (name, seed, span, force)
        missed = np.abs(W @ t - wrench) / (force * max(1.0, np.abs(W).max()))
        assert missed.max() < 1e-6, (name, seed, missed)
        assert (t >= low - 1e-6 * force).all(), (name, seed)
        assert (t <= high + 1e-6 * force).all(), (name, seed)
        if name in NORMS:
            assert optimal(W, t, low, high, force), (name, seed, span, force)


def test_exact_takes_no_rounding_for_a_constraint():
    """It was 0.6 % above the optimum of `qp`."""
    anchors = POINT.copy()
    anchors[:, 5] = [-0.125, -0.125, 0.125, -0.125, -0.125, -0.125, 0.125, -0.125]
    robot = make_robot(anchors, mass=14.0, limits=(4.0, 330.0))
    pose = [-0.15190494009958272, 0.008674599980632301, 1.3682486564336551]
    W = np.ascontiguousarray(wrench_matrix(robot, make_state(np.array(pose), np.array([1.0, 0, 0, 0]))))
    assert rank(W) == 5
    found = {}
    for name in ("qp", "exact"):
        entry, t = registry().get("solver", name), np.full(8, np.nan)
        solver = entry.make(robot, entry.read_options({}))
        wrench = np.array([0, 0, 14 * 9.81, 0, 0, 0.0])
        assert solver.solve(W, wrench, robot.tension_min.copy(), robot.tension_max.copy(), t) == Status.OK
        found[name] = np.linalg.norm(t)
    assert found["exact"] == pytest.approx(found["qp"], rel=1e-9)
    assert found["qp"] == pytest.approx(148.871, abs=1e-3)


FLAT = np.array([[-2, 0, -1, 0, 0, 0], [-2, 0, 1, 0, 0, 0], [2, 0, -1, 0, 0, 0], [2, 0, 1, 0, 0, 0.0]])


@pytest.mark.slow
def test_closure_and_proofs_where_rank_is_lost():
    robot = make_robot(FLAT, mass=3.0, limits=(1.0, 200.0), dof=("x", "z", "ry"))
    box = region(robot, cells=8)
    closure = workspace(robot, "closure", box)
    assert not closure.inside.any()
    assert compare(closure, robot, 20).different == []
    proved = workspace(robot, "static", box, method="certify")
    assert proved.proofs.evaluated < 1000
    assert "no proof anywhere in the box: the wrench matrix is rank-deficient" in proved.summary()["notes"][0]


def test_a_flat_frame_has_a_workspace():
    """Three cables from one height, which hang the platform below."""
    anchors = np.array([[-0.89, 0.85, 0, 0, 0, 0], [0.89, 0.85, 0, 0, 0, 0], [0, -0.85, 0, 0, 0, 0]])
    robot = make_robot(anchors, mass=2.94, limits=(5.0, 200.0), dof=("x", "y", "z"))
    found = workspace(robot, "static", region(robot, cells=10))
    assert (found.region.lower[2], found.region.upper[2]) == (-0.89, 0.89)
    assert found.inside.any()
    assert not found.inside[:, :, 5:].any()


def test_forward_kinematics_converges_only_to_the_lengths():
    robot = make_robot(np.hstack([POINT[:, :3], POINT[:, 3:]]))
    start = np.array([0, 0, 1.5, 1, 0, 0, 0.0])
    fit = cdpr.mechanics.forward_kinematics.forward_kinematics(robot, np.array([1.0, 5, 1, 5, 5, 1, 5, 1]), start)
    assert fit.residual > 0.5
    assert not fit.converged
