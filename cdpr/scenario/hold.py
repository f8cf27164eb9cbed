"""Whether cables can hold a platform at a pose: quick tests, right where they say that they can, or cannot."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr.model import DOF_NAMES, Robot, rotations
from cdpr.model.robot import Array

# Of the largest singular value: below it the cables leave a motion of the platform as good as free.
REGULAR = 1e-3
MARGIN = 1e-3  # of the range of tensions, by which they are pushed within their limits
STARTS = 8  # equal tensions between lowest and highest that are begun with
PROJECTIONS = 100  # of each, by turns onto the limits and onto the tensions that hold the weight
STEPS, LOOK = 2000, 20  # of a search, and how often it is looked at
NEAR = 0.999  # share of what is left that is proved, at which a search ends
ROUND_OFF = 1e-9  # of the weight


def wrench_matrix(robot: Robot, position: Array, attitude: Array) -> Array:
    """Rows of W that belong to the degrees of freedom, (n, m), for cables that leave the frame at their anchors.

    Moments are divided by the characteristic length.
    """
    arms = robot.anchors[:, 3:] @ rotations.matrix(attitude).T
    chords = robot.anchors[:, :3] - position - arms
    units = chords / np.linalg.norm(chords, axis=1)[:, None]
    moments = np.cross(arms, units) / robot.characteristic_length
    return np.asarray(np.hstack([units, moments]).T[[DOF_NAMES.index(name) for name in robot.dof]])


def weight(robot: Robot, attitude: Array, gravity: Array) -> Array:
    """What the cables must exert against gravity, (n,), in the rows of `wrench_matrix`."""
    force = -robot.platform.mass * gravity
    lever = rotations.matrix(attitude) @ robot.platform.center_of_mass
    wrench = np.concatenate([force, np.cross(lever, force) / robot.characteristic_length])
    return np.asarray(wrench[robot.rows])


def regular(W: Array) -> bool:
    """Whether no motion is left free."""
    values = np.linalg.svd(W, compute_uv=False)
    return bool(W.shape[1] >= W.shape[0] and values[-1] > REGULAR * values[0])


def holds(robot: Robot, position: Array, attitude: Array, gravity: Array) -> bool:
    """Whether tensions within the limits hold the weight, looked for by alternating projections from equal ones."""
    W, wanted = wrench_matrix(robot, position, attitude), weight(robot, attitude, gravity)
    if not regular(W):
        return False
    inverse, low, high = np.linalg.pinv(W), robot.tension_min, robot.tension_max
    for share in np.geomspace(1e-3, 0.9, STARTS):
        tension = low + share * (high - low)
        for _ in range(PROJECTIONS):
            tension = tension + inverse @ (wanted - W @ tension)
            if np.all(low <= tension) and np.all(tension <= high):
                return True
            tension = np.clip(tension, low + MARGIN * (high - low), high - MARGIN * (high - low))
    return False


def held(robot: Robot, positions: Array, attitude: Array, gravity: Array) -> NDArray[np.bool_]:
    """Return whether `holds` at each of many positions (K, 3), m, with one attitude: (K,), for all at once."""
    matrices = np.array([wrench_matrix(robot, position, attitude) for position in positions])
    wanted = weight(robot, attitude, gravity)[:, None]
    sizes = np.linalg.svd(matrices, compute_uv=False)
    sound = (sizes[:, -1] > REGULAR * sizes[:, 0]) & (robot.m >= robot.n)
    low, high = robot.tension_min[:, None], robot.tension_max[:, None]
    edge = MARGIN * (high - low)
    found = np.zeros(len(positions), dtype=bool)
    for share in np.geomspace(1e-3, 0.9, STARTS):
        left = np.flatnonzero(sound & ~found)
        W = matrices[left]
        inverse = np.linalg.pinv(W)
        tension = np.tile(low + share * (high - low), (len(left), 1, 1))
        for _ in range(PROJECTIONS):
            tension = tension + inverse @ (wanted - W @ tension)
            found[left] |= ((low <= tension) & (tension <= high)).all(axis=(1, 2))
            tension = np.clip(tension, low + edge, high - edge)
    return found


def unheld(robot: Robot, position: Array, attitude: Array, gravity: Array) -> float:
    """Return how much of the weight tensions within the limits leave at least, N (moments as in `wrench_matrix`).

    The nearest wrench is looked for by accelerated projected gradients (Beck and Teboulle 2009). What is left of the
    weight then is a direction y in which no tensions t within the limits pull enough: max y.W t over them, the sum of
    what each cable can do, is less than y.w. That is proved however near the search has come; else 0 is returned.
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
    """Whether the cables hold the platform against wrenches from all sides (wrench closure), by the tensions nearest
    to equal ones that exert nothing.
    """
    W = wrench_matrix(robot, position, attitude)
    equal = np.ones(robot.m)
    return regular(W) and bool(np.all(equal - np.linalg.pinv(W) @ (W @ equal) > REGULAR))
