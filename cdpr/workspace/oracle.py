"""A workspace against a linear program: the same poses asked by other means, at random and on the boundary."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cdpr.errors import CdprError, PluginError
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state, wrench_matrix
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.workspace.kinds import KINDS
from cdpr.workspace.required import Required
from cdpr.workspace.result import BOUNDARY, Workspace, verdicts

try:
    from scipy.optimize import linprog
except ImportError as error:
    raise PluginError(f"the linear programs need scipy ({error}): pip install 'cdpr[solvers]'") from error

# The smallest that HiGHS takes; problems are scaled to tensions near 1.
OPTIONS = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
# Share of the largest limit: closer to zero, the program's own tolerance decides.
UNDECIDED = 1e-7
MOST_CORNERS = 64  # of a required set, each a program
HALVINGS = 48  # of the way between two cells: to the last digits
SOLVED, IMPOSSIBLE = 0, 2  # linprog's status


@dataclass(frozen=True)
class Agreement:
    """How a workspace and the programs agree.

    Attributes:
        poses: how many were asked, `bisected` of them on the boundary.
        undecided: those where the one or the other is within its tolerance of the boundary.
        different: those where both are certain, and differ: position, quaternion, value, and the program's margin.
        told: cells among them, in one attitude, whose answer in the file was told from that of others.
        told_wrong: those of them that are another when they are asked.
    """

    poses: int
    bisected: int
    undecided: int
    different: list[dict[str, Any]] = field(default_factory=list)
    told: int = 0
    told_wrong: int = 0


def compare(
    found: Workspace,
    robot: Robot,
    count: int = 200,
    *,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Agreement:
    """Ask a linear program about `count` poses of a workspace, half of them on its boundary where it has one.

    Raises CdprError for kinds that no linear program answers, for sets with more corners than can be asked one by one,
    and where more than 0 was wanted of the margin.
    """
    if not found.kind.programs:
        known = ", ".join(kind.name for kind in KINDS.values() if kind.programs)
        raise CdprError(f"{found.kind.name}: is nothing that linear programs answer; they do {known}")
    if found.question.at_least is not None:
        raise CdprError("at_least: linear programs tell margins of 0 alone, not how large others are")
    required, gravity = found.question.required, found.question.gravity
    rng = np.random.default_rng(seed)
    edges = _on_boundary(found, robot, rng, count // 2)
    cells = rng.integers(found.region.cells, size=count - len(edges))
    middles = found.region.positions(cells)
    turned = found.region.orientations[rng.integers(len(found.region.orientations), size=len(middles))]
    poses = np.concatenate([edges, np.concatenate([middles, turned], axis=1)])
    inside, value, scale = verdicts(found, robot, poses)
    undecided, different = 0, []
    for k, pose in enumerate(poses):
        margin = _margin(found, robot, pose, required, gravity)
        close = abs(margin) <= UNDECIDED or (np.isfinite(value[k]) and abs(value[k]) <= BOUNDARY * scale[k])
        undecided += bool(close)
        if not close and (margin > 0.0) != bool(inside[k]):
            told = {"position": pose[:3].tolist(), "quaternion": pose[3:].tolist()}
            different.append(told | {"value": float(value[k]), "program": margin})
        progress(k + 1, len(poses))
    alone = ~found.evaluated.ravel()[cells] & (len(found.region.orientations) == 1)
    wrong = alone & (inside[len(edges) :] != found.inside.ravel()[cells])
    return Agreement(len(poses), len(edges), undecided, different, int(alone.sum()), int(wrong.sum()))


def _on_boundary(found: Workspace, robot: Robot, rng: np.random.Generator, count: int) -> Array:
    """Poses (n, 7), n <= count, bisected between cells of which one is inside and its neighbour is not."""
    pairs = []
    for axis in range(3):
        index = np.argwhere(np.diff(found.inside.astype(np.int8), axis=axis) != 0)
        pairs += [(tuple(at), axis) for at in index.tolist()]
    if not pairs or len(found.region.orientations) > 1:
        return np.empty((0, 7))
    chosen = [pairs[i] for i in rng.permutation(len(pairs))[:count].tolist()]
    axes = found.region.axes
    low = np.array([[axes[i][at[i]] for i in range(3)] for at, _ in chosen])
    high = low.copy()
    for row, (at, axis) in zip(high, chosen, strict=True):
        row[axis] = axes[axis][at[axis] + 1]
    turned = np.repeat(found.region.orientations, len(low), axis=0)
    first = np.array([found.inside[at] for at, _ in chosen])
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        same = verdicts(found, robot, np.concatenate([middle, turned], axis=1))[0] == first
        low[same], high[~same] = middle[same], middle[~same]
    ends = np.where(rng.random(len(low))[:, None] < 0.5, low, high)
    return np.concatenate([ends, turned], axis=1)


def _margin(found: Workspace, robot: Robot, pose: Array, required: Required, gravity: Array) -> float:
    """How far all tensions can be from their limits whatever is required, as a share of the largest limit."""
    state = make_state(pose[:3], pose[3:])
    weights = found.question.weights(robot)
    W = weights[:, None] * wrench_matrix(robot, state)[robot.rows]
    largest = float(np.abs([robot.tension_min, robot.tension_max]).max())
    low, high = robot.tension_min / largest, robot.tension_max / largest
    if not found.kind.at_zero:
        # t = 0 always is there: beside 1, the largest s is 0 where there is no other.
        return _roomiest(W, np.zeros(robot.n), np.zeros(robot.m), np.full(robot.m, np.inf), most=1.0) - 2 * UNDECIDED
    carried = required_wrench(robot, state, gravity)
    margins = []
    for corner in _corners(required):
        wrench = carried + corner
        if required.accelerations:
            wrench = required_wrench(robot, state, gravity, corner[:3], corner[3:])
        margins.append(_roomiest(W, weights * wrench[robot.rows] / largest, low, high))
    return min(margins)


def _corners(required: Required) -> Array:
    """Corners (k, 6) of a required set, at least the origin."""
    vectors = required.vectors
    if required.form == "vertices":
        return vectors
    if required.form == "ellipsoid" and len(vectors):
        raise CdprError("an ellipsoid has no corners that could be asked one by one: compare with a box")
    if 2 ** len(vectors) > MOST_CORNERS:
        raise CdprError(
            f"the required set has {2 ** len(vectors)} corners, at most {MOST_CORNERS} are asked one by one"
        )
    return np.array([np.array(signs) @ vectors for signs in itertools.product((-1.0, 1.0), repeat=len(vectors))])


def _roomiest(W: Array, wrench: Array, low: Array, high: Array, most: float = np.inf) -> float:
    """The largest s <= most with W t = wrench, low + s <= t <= high - s; -inf where W t = wrench has no solution."""
    n, m = W.shape
    eye, one = np.eye(m), np.ones((m, 1))
    bounded = np.isfinite(high)
    within = np.concatenate([np.hstack([-eye, one]), np.hstack([eye, one])[bounded]])
    limits = np.concatenate([-low, high[bounded]])
    equal = np.hstack([W, np.zeros((n, 1))])
    cost = np.append(np.zeros(m), -1.0)
    bounds = [(None, None)] * m + [(None, most)]
    answer = linprog(cost, within, limits, equal, wrench, bounds, options=OPTIONS)
    if answer.status == IMPOSSIBLE:
        return -np.inf
    return float(answer.x[m]) if answer.status == SOLVED else 0.0
