"""Properties of a robot at a pose that do not depend on tensions. See `cdpr.model` for the conventions."""

from __future__ import annotations

import numpy as np

from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.mechanics.kinematics import lengths, make_state, wrench_matrix
from cdpr.model import rotations
from cdpr.model.home import home_pose as home_pose
from cdpr.model.rank import significant
from cdpr.model.robot import Array, Robot

# Components of a direction below this share of its largest component are round-off: the rank is determined with
# RANK_TOLERANCE only.
ROUNDED = 1e-6


def check_lengths(robot: Robot, pose: Array) -> None:
    """Raise CdprError if a cable has no length, and thus no direction, at a pose (7,)."""
    tips = pose[:3] + robot.anchors[:, 3:] @ rotations.matrix(pose[3:]).T
    for cable, tip, length in zip(robot.cables, tips, lengths(robot, make_state(pose[:3], pose[3:])), strict=True):
        if not length >= tolerances.LENGTH:
            where = f"position {pose[:3].tolist()} m"
            why = cable.exit.obstacle(cable.frame.tolist(), tip.tolist()) if cable.exit else ""
            why = f", for {why}" if why else ""
            raise CdprError(f"cable '{cable.name}' has no length at {where}{why}: choose another pose")


def free_wrench_matrix(robot: Robot, state: Array) -> Array:
    """Return the rows of W that belong to the degrees of freedom, (n, m), at a state (13,).

    Rows of moments are divided by the characteristic length, so that all entries are dimensionless.
    """
    weights = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)
    return np.asarray((weights[:, None] * wrench_matrix(robot, state))[robot.rows])


def conditioning(W: Array) -> tuple[int, float]:
    """Return the rank and the condition number of W (n, m), the matrix of `free_wrench_matrix`.

    The condition number is the ratio of the largest to the smallest singular value, infinite if W is rank-deficient.
    """
    values = np.asarray(np.linalg.svd(W, compute_uv=False))
    rank = significant(values)
    return rank, float(values[0] / values[-1]) if rank == min(W.shape) else np.inf


def unresisted(W: Array, robot: Robot) -> list[Array]:
    """Return a basis of the twists (6,) of the platform that change no cable length, for W of `free_wrench_matrix`.

    Each twist contains the velocity of the origin and the angular velocity, in world axes. Its largest component is 1
    [m/s or rad/s]. Each twist has a non-zero component that is zero in all other twists.
    """
    U, values, _ = np.linalg.svd(W)
    rank = significant(values)
    basis = U[:, rank:].T.copy()
    pivots: list[int] = []
    for i in range(len(basis)):  # reduced row echelon form with the largest entry as pivot
        block = np.abs(basis[i:])
        block[:, pivots] = 0.0
        row, pivot = (int(index) for index in np.unravel_index(int(np.argmax(block)), block.shape))
        basis[[i, i + row]] = basis[[i + row, i]]
        basis[i] /= basis[i, pivot]
        others = np.arange(len(basis)) != i
        basis[others] -= np.outer(basis[others, pivot], basis[i])
        pivots.append(pivot)
    basis = basis[np.argsort(pivots)]
    twists = np.zeros((len(basis), 6))
    twists[:, robot.rows] = basis
    twists[:, 3:] /= robot.characteristic_length
    twists[np.abs(twists) < ROUNDED * np.abs(twists).max(axis=1, keepdims=True, initial=0.0)] = 0.0
    return [twist / np.abs(twist).max() for twist in twists]
