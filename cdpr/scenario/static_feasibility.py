"""Static feasibility of a pose: fast sufficient tests whether the cables can, or cannot, support the platform."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr.model import DOF_NAMES, Robot, rotations
from cdpr.model.robot import Array

# Relative to the largest singular value: below this, a motion is practically uncontrolled.
REGULAR = 1e-3
MARGIN = 1e-3  # relative to the tension range; distance to the limits after projection
STARTS = 8  # initial guesses: equal tensions between the limits
PROJECTIONS = 100  # per initial guess, alternately onto the limits and onto the tensions that balance the weight
STEPS, LOOK = 2000, 20  # largest number of iterations, and iterations between convergence checks
SEPARATED = 5  # projections between searches for a separating plane
NEAR = 0.999  # proved fraction of the residual at which the search ends
ROUND_OFF = 1e-9  # relative to the weight


def wrench_matrix(robot: Robot, position: Array, attitude: Array) -> Array:
    """Return the rows (n, m) of the wrench matrix W of the degrees of freedom, for cables that leave at their anchors.

    Moments are divided by the characteristic length.
    """
    return np.asarray(wrench_matrices(robot, position[None], attitude)[0])


def wrench_matrices(robot: Robot, positions: Array, attitude: Array) -> Array:
    """Return `wrench_matrix` (K, n, m) at positions (K, 3), m, with one attitude."""
    arms = robot.anchors[:, 3:] @ rotations.matrix(attitude).T
    chords = robot.anchors[:, :3] - positions[:, None] - arms
    units = chords / np.linalg.norm(chords, axis=2)[:, :, None]
    moments = np.cross(arms, units) / robot.characteristic_length
    rows = np.concatenate([units, moments], axis=2).transpose(0, 2, 1)
    return np.asarray(rows[:, [DOF_NAMES.index(name) for name in robot.dof]])


def weight(robot: Robot, attitude: Array, gravity: Array) -> Array:
    """Return the wrench (n,) that balances gravity, in the rows of `wrench_matrix`."""
    force = -robot.platform.mass * gravity
    lever = rotations.matrix(attitude) @ robot.platform.center_of_mass
    wrench = np.concatenate([force, np.cross(lever, force) / robot.characteristic_length])
    return np.asarray(wrench[robot.rows])


def regular(W: Array) -> bool:
    """Return True if W has full rank and is well-conditioned."""
    values = np.linalg.svd(W, compute_uv=False)
    return bool(W.shape[1] >= W.shape[0] and values[-1] > REGULAR * values[0])


def holds(robot: Robot, position: Array, attitude: Array, gravity: Array) -> bool:
    """Return True if tensions within the limits that balance the weight were found, by alternating projections."""
    return bool(held(robot, position[None], attitude, gravity)[0])


def held(robot: Robot, positions: Array, attitude: Array, gravity: Array) -> NDArray[np.bool_]:
    """Return the result (K,) of `holds` at positions (K, 3), m, with one attitude, computed together.

    A position whose correction d of the tensions separates the limits from all tensions that balance the weight
    (d.t of those is larger than that of any tensions within the limits) is left out of further projections.
    """
    matrices = wrench_matrices(robot, positions, attitude)
    wanted = weight(robot, attitude, gravity)[:, None]
    sizes = np.linalg.svd(matrices, compute_uv=False)
    sound = (sizes[:, -1] > REGULAR * sizes[:, 0]) & (robot.m >= robot.n)
    low, high = robot.tension_min[:, None], robot.tension_max[:, None]
    edge = MARGIN * (high - low)
    found = np.zeros(len(positions), dtype=bool)
    left = np.flatnonzero(sound)
    inverses = np.linalg.pinv(matrices[left])
    for share in np.geomspace(1e-3, 0.9, STARTS):
        tension = np.tile(low + share * (high - low), (len(left), 1, 1))
        running = np.arange(len(left))  # indices into `left`
        impossible = np.zeros(len(left), dtype=bool)
        for k in range(1, PROJECTIONS + 1):
            correction = inverses[running] @ (wanted - matrices[left[running]] @ tension)
            tension = tension + correction
            done = ((low <= tension) & (tension <= high)).all(axis=(1, 2))
            found[left[running[done]]] = True
            if k % SEPARATED == 0:
                most = np.maximum(correction * low, correction * high)
                proved = (correction * tension - most).sum(axis=(1, 2)) > ROUND_OFF * np.abs(most).sum(axis=(1, 2))
                impossible[running[proved & ~done]] = True
                done |= proved
            running, tension = running[~done], np.clip(tension[~done], low + edge, high - edge)
        left, inverses = left[going := ~found[left] & ~impossible], inverses[going]
    return found


def unheld(robot: Robot, position: Array, attitude: Array, gravity: Array) -> float:
    """Return a lower bound of the unbalanced weight for tensions within the limits, N (moments as in `wrench_matrix`).

    Accelerated projected gradients (Beck and Teboulle 2009) search the nearest wrench. The residual y of the weight w
    proves the bound: no tensions t within the limits have y.W t larger than the sum of the cables' maxima. If that sum
    is less than y.w, the difference over |y| remains. The proof does not depend on convergence. 0 means that nothing
    was proved.
    """
    W, wanted = wrench_matrix(robot, position, attitude), weight(robot, attitude, gravity)
    low, high = robot.tension_min, robot.tension_max
    slope = float(np.linalg.norm(W, 2)) ** 2
    tension = ahead = low.copy()
    best, momentum = 0.0, 1.0
    for k in range(1, STEPS + 1):
        before, tension = tension, np.clip(ahead + W.T @ (wanted - W @ ahead) / slope, low, high)
        following = 0.5 * (1.0 + math.sqrt(1.0 + 4.0 * momentum**2))
        ahead, momentum = tension + (momentum - 1.0) / following * (tension - before), following
        if k % LOOK == 0:
            left = wanted - W @ tension
            size, pulls = float(np.linalg.norm(left)), W.T @ left
            if size <= ROUND_OFF * float(np.linalg.norm(wanted)):
                return 0.0
            proved = (float(left @ wanted) - float(np.maximum(pulls * low, pulls * high).sum())) / size
            best = max(best, proved)
            if best >= NEAR * size:
                break
    return best


def pulls_against_itself(robot: Robot, position: Array, attitude: Array) -> bool:
    """Return True if the pose has wrench closure, judged by the null-space tensions nearest to equal ones."""
    W = wrench_matrix(robot, position, attitude)
    equal = np.ones(robot.m)
    return regular(W) and bool(np.all(equal - np.linalg.pinv(W) @ (W @ equal) > REGULAR))
