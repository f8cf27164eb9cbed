"""All poses at rest that a search from many starts finds, unstable ones included."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from cdpr.mechanics.descent import seek
from cdpr.mechanics.equilibrium import TOLERANCE, Equilibrium, describe, find_equilibrium
from cdpr.mechanics.inextensible import polish
from cdpr.mechanics.potential import Potential
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array

SAME = 1e-6  # distance of equal poses, as a share of the size
SOFT = (
    1e-2,
    1e-4,
)  # stretches of penalised cables under the load, as shares of the size, from which a search continues


@np.errstate(all="ignore")
def find_equilibria(
    robot: Robot, unwound: Array, tension: Array, start: Array, gravity: ArrayLike, *, starts: int, seed: int
) -> list[Equilibrium]:
    """Return the different equilibria found from `start` and from random poses, stable ones first, lowest first.

    From each pose, one search descends to a stable equilibrium, and one seeks a stationary point of any kind.
    """
    found: list[Equilibrium] = []
    for pose in _starts(Potential(robot, gravity, unwound, tension), start, starts, np.random.default_rng(seed)):
        potential = Potential(robot, gravity, unwound, tension)
        if not potential.defined(pose):
            continue
        _add(found, find_equilibrium(robot, unwound, tension, pose, gravity), potential)
        other = _stationary(potential, pose)
        if other is not None:
            _add(found, other, potential)
    order = {"stable": 0, "neutral": 1, "unstable": 2, "unknown": 3}
    return sorted(found, key=lambda one: (order[one.stability], *one.pose[[2, 0, 1]].round(6)))


def _starts(potential: Potential, start: Array, count: int, rng: np.random.Generator) -> Iterator[Array]:
    yield start
    robot = potential.robot
    anchors, rows = robot.anchors[:, :3], [row for row in robot.rows if row < 3]
    lower, upper = anchors.min(axis=0) - potential.size, anchors.max(axis=0) + 0.2 * potential.size
    turns = [row - 3 for row in robot.rows if row >= 3]
    for _ in range(count):
        pose = start.copy()
        pose[rows] = rng.uniform(lower, upper)[rows]
        if len(turns) == 3:
            q = rng.normal(size=4)
            pose[3:] = q / np.linalg.norm(q)
        elif len(turns) == 1:
            pose[3:] = rotations.from_axis_angle(np.eye(3)[turns[0]], float(rng.uniform(-np.pi, np.pi)))
        yield pose


def _stationary(potential: Potential, start: Array) -> Equilibrium | None:
    """Return a stationary point of any kind, None if none is found or a cable would have to push."""
    spring, held = potential.spring.copy(), potential.spring.astype(bool) | potential.rigid
    pose = start
    if held.any():
        load = potential.weight or 1.0
        potential.spring[:] = 0
        for stretch in SOFT:  # soft cables first, so that the search begins well
            potential.penalty[held] = load / (stretch * potential.size)
            pose, done = seek(potential, pose, 1e-6)
            if not done:
                return None
        potential.spring[:], potential.penalty[:] = spring, 0.0
        potential.force[potential.rigid] = potential.tension[potential.rigid]
    if potential.rigid.any():
        pose, done = polish(potential, pose, TOLERANCE)
    else:
        pose, done = seek(potential, pose, TOLERANCE)
    return describe(potential, pose) if done else None


def _add(found: list[Equilibrium], one: Equilibrium, potential: Potential) -> None:
    """Add an equilibrium if it is valid and new; of a continuous family of them, keep the first."""
    if not one.converged:
        return
    near = SAME * potential.size
    for other in found:
        turn = rotations.between(one.pose[3:], other.pose[3:])
        apart = math.dist(one.pose[:3], other.pose[:3]) + potential.robot.characteristic_length * math.hypot(*turn)
        alike = np.abs(one.length - other.length).max() <= near and one.stability == other.stability == "neutral"
        if apart <= near or alike:
            return
    found.append(one)
