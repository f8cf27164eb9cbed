"""Check of a workspace by linear programs: independent evaluation of poses, at random and on the boundary."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace.certify import INSIDE
from cdpr.analysis.workspace.evaluate import BOUNDARY
from cdpr.analysis.workspace.kinds import KINDS
from cdpr.analysis.workspace.result import Workspace, verdicts
from cdpr.base.errors import CdprError, LogError, MissingPackageError
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state, wrench_matrix
from cdpr.model import Robot
from cdpr.model.rank import rank
from cdpr.model.robot import Array
from cdpr.model.rotations import from_axis_angle, multiply

try:
    from scipy.optimize import linprog
except ImportError as error:
    raise MissingPackageError(f"the linear programs need scipy ({error}): pip install 'cdpr[solvers]'") from error

# Smallest tolerance that HiGHS accepts; problems are scaled to tensions near 1.
OPTIONS = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
# Share of the largest limit: closer to zero, the program's own tolerance decides.
UNDECIDED = 1e-7
# m or rad: closer to the boundary both answers are acceptable, because anchors and poses are rounded.
NEAR = 1e-9
HALVINGS = 48  # bisections between two cells, to full precision
SOLVED, IMPOSSIBLE = 0, 2  # status codes of linprog


@dataclass(frozen=True)
class Agreement:
    """Agreement of a workspace with the linear programs.

    Attributes:
        poses: number of evaluated poses.
        bisected: number of poses on the boundary among them.
        undecided: number of poses within either tolerance of the boundary.
        different: contradictions: position, quaternion, value, and the program's margin.
        near: contradictions within 1e-9 m or rad of the boundary, likewise.
        told: number of interpolated cells among them, in one attitude.
        told_wrong: number of those whose evaluation differs.
    """

    poses: int
    bisected: int
    undecided: int
    different: list[dict[str, Any]] = field(default_factory=list)
    near: list[dict[str, Any]] = field(default_factory=list)
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
    """Compare `count` poses of a workspace with a linear program, half of them on its boundary if it has one.

    For certified workspaces, poses are drawn from the decided boxes and compared with the proofs.

    Args:
        found: the workspace.
        robot: its robot.
        count: number of poses.
        seed: seed of the poses.
        progress: called with the number of finished poses and their total.

    Raises:
        CdprError: if no linear program applies to the kind, the required set has too many corners, or a margin above 0
            was required.
        LogError: if the workspace contradicts its own evaluation.
    """
    if not found.kind.programs:
        known = ", ".join(kind.name for kind in KINDS.values() if kind.programs)
        raise CdprError(f"{found.kind.name}: not supported by the oracle of linear programs; allowed: {known}")
    if found.question.at_least is not None:
        raise CdprError("at_least: linear programs only verify the sign of margins, not their size")
    found.question.required.corners()  # reject a set with too many corners
    rng = np.random.default_rng(seed)
    if found.proofs is not None and len(found.region.orientations) == 1:
        positions, proved = found.proofs.drawn(rng, count)
        poses = _poses(found, rng, positions)
        return _agreement(found, robot, poses, proved == INSIDE, progress)
    edges = _on_boundary(found, robot, rng, count // 2)
    cells = rng.integers(found.region.cells, size=count - len(edges))
    poses = np.concatenate([edges, _poses(found, rng, found.region.positions(cells))])
    inside = verdicts(found, robot, poses)[0]
    agreement = _agreement(found, robot, poses, inside, progress)
    single = len(found.region.orientations) == 1
    other = single & (inside[len(edges) :] != found.inside.ravel()[cells])
    evaluated = found.evaluated.ravel()[cells]
    alone, wrong = ~evaluated & single, other & ~evaluated
    if (other & evaluated).any():
        k = len(edges) + int(np.argmax(other & evaluated))
        raise LogError(
            f"the cell at {poses[k, :3].tolist()} m is {'not ' * bool(inside[k])}inside by the file, but a new "
            "evaluation of its robot disagrees: the file was changed, or written by another version"
        )
    return replace(agreement, bisected=len(edges), told=int(alone.sum()), told_wrong=int(wrong.sum()))


def _poses(found: Workspace, rng: np.random.Generator, positions: Array) -> Array:
    """Return poses (n, 7) at positions (n, 3), each in a random attitude of the workspace."""
    attitudes = found.region.orientations
    return np.concatenate([positions, attitudes[rng.integers(len(attitudes), size=len(positions))]], axis=1)


def _agreement(
    found: Workspace, robot: Robot, poses: Array, inside: NDArray[np.bool_], progress: Callable[[int, int], None]
) -> Agreement:
    """Return the agreement for poses with expected verdicts `inside` (n,)."""
    _, value, scale = verdicts(found, robot, poses)
    undecided = 0
    different: list[dict[str, Any]] = []
    near: list[dict[str, Any]] = []
    for k, pose in enumerate(poses):
        margin = _margin(found, robot, pose)
        close = abs(margin) <= UNDECIDED or (np.isfinite(value[k]) and abs(value[k]) <= BOUNDARY * scale[k])
        undecided += bool(close)
        if not close and (margin > 0.0) != bool(inside[k]):
            where = {"position": pose[:3].tolist(), "quaternion": pose[3:].tolist()}
            ends = (verdicts(found, robot, _around(robot, pose))[0] != inside[k]).any()
            (near if ends else different).append(where | {"value": float(value[k]), "program": margin})
        progress(k + 1, len(poses))
    return Agreement(len(poses), 0, undecided, different, near)


def _around(robot: Robot, pose: Array) -> Array:
    """Return poses (2 n, 7) at the distance NEAR from a pose, in each of the robot's n degrees of freedom."""
    poses = []
    for row in robot.rows:
        for sign in (-NEAR, NEAR):
            moved = np.zeros(6)
            moved[row] = sign
            turned = multiply(from_axis_angle(np.eye(3)[row - 3], sign), pose[3:]) if row >= 3 else pose[3:]
            poses.append(np.concatenate([pose[:3] + moved[:3], turned]))
    return np.array(poses)


def _on_boundary(found: Workspace, robot: Robot, rng: np.random.Generator, count: int) -> Array:
    """Return poses (n, 7), n <= count, on the boundary, by bisection between neighbouring inside and outside cells."""
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


def _margin(found: Workspace, robot: Robot, pose: Array) -> float:
    """Return the largest margin of all tensions for all required wrenches, as a share of the largest limit."""
    required, gravity = found.question.required, found.question.gravity
    state = make_state(pose[:3], pose[3:])
    weights = found.question.weights(robot)
    W = weights[:, None] * wrench_matrix(robot, state)[robot.rows]
    largest = float(np.abs([robot.tension_min, robot.tension_max]).max())
    low, high = robot.tension_min / largest, robot.tension_max / largest
    if not found.kind.at_zero:
        if rank(W) < robot.n:  # the cables exert nothing in some direction
            return -np.inf
        # t = 0 is always a solution: without another, the largest s is 0
        return _roomiest(W, np.zeros(robot.n), np.zeros(robot.m), np.full(robot.m, np.inf), most=1.0) - 2 * UNDECIDED
    carried = required_wrench(robot, state, gravity)
    margins = []
    for corner in required.corners():
        wrench = carried + corner
        if required.accelerations:
            wrench = required_wrench(robot, state, gravity, corner[:3], corner[3:])
        margins.append(_roomiest(W, weights * wrench[robot.rows] / largest, low, high))
    return min(margins)


def _roomiest(W: Array, wrench: Array, low: Array, high: Array, most: float = np.inf) -> float:
    """Return the largest s <= most with W t = wrench, low + s <= t <= high - s; -inf if W t = wrench is unsolvable."""
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
