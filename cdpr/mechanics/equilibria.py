"""All poses at rest that a search from many starts finds, unstable ones included."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.mechanics.descent import seek
from cdpr.mechanics.equilibrium import TOLERANCE, Equilibrium, describe, find_equilibrium
from cdpr.mechanics.inextensible import polish
from cdpr.mechanics.potential import Potential
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array

SAME = 1e-6  # distance of equal poses, as a share of the size
CHOICES = 6  # random choices of taut cables from each start
SOFT = (1e-2, 1e-4)  # stretches of soft cables under the load, as shares of the size
MOST_DAMPED = 60  # damped Newton steps
NEARLY = 1e-7  # error of forces and lengths after these, as a share of load and size
PUSH = 1e-6  # largest pushing force of a cable then, as a share of the load

Mask = NDArray[np.bool_]


@np.errstate(all="ignore")
def find_equilibria(
    robot: Robot, unwound: Array, tension: Array, start: Array, gravity: ArrayLike, *, starts: int, seed: int
) -> list[Equilibrium]:
    """Return the different equilibria found from `start` and from random poses, stable ones first, lowest first.

    From each pose, one search descends to a stable equilibrium, and others seek stationary points of any kind with
    random taut cables.
    """
    found: list[Equilibrium] = []
    rng = np.random.default_rng(seed)
    for pose in _starts(Potential(robot, gravity, unwound, tension), start, starts, rng):
        potential = Potential(robot, gravity, unwound, tension)
        if not potential.defined(pose):
            continue
        _add(found, find_equilibrium(robot, unwound, tension, pose, gravity), potential)
        for taut in (None, *_taut(robot, rng)):
            other = _stationary(Potential(robot, gravity, unwound, tension), pose, taut)
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


def _taut(robot: Robot, rng: np.random.Generator) -> Iterator[Mask]:
    """Yield choices of taut cables: as many as there may be, then random ones."""
    most = min(robot.m, robot.n) if robot.unilateral else robot.m
    for count in [most, *(rng.integers(1, most + 1, CHOICES - 1) if robot.unilateral else ())]:
        taut = np.zeros(robot.m, dtype=bool)
        taut[rng.permutation(robot.m)[:count]] = True
        yield taut


def _stationary(potential: Potential, start: Array, taut: Mask | None) -> Equilibrium | None:
    """Return a stationary point of any kind, None if none is found or a cable would push.

    The search first treats all cables as inextensible, of which those in `taut` (m,) are taut. Without a choice, it
    first treats them as soft.
    """
    held = (potential.spring == 1) | potential.rigid
    spring, rigid = potential.spring.copy(), potential.rigid.copy()
    potential.spring[:], potential.rigid = 0, held
    potential.penalty[:], potential.force[held] = 0.0, 0.0
    if taut is None:
        pose, done = _seek_softly(potential, start, held)
    else:
        pose, done = _seek_taut(potential, start, np.flatnonzero(taut & held))
    potential.spring[:], potential.rigid = spring, rigid
    if not done or (potential.robot.unilateral and potential.force[held].min(initial=0.0) < -PUSH * potential.load()):
        return None
    potential.force[held & ~rigid] = 0.0
    pose, done = (polish if rigid.any() else seek)(potential, pose, TOLERANCE)
    return describe(potential, pose) if done else None


def _seek_softly(potential: Potential, start: Array, held: Mask) -> tuple[Array, bool]:
    """Seek a stationary point (7,) with cables that stretch less and less; their tensions become `potential.force`."""
    pose, done = start, True
    for stretch in SOFT:
        potential.penalty[held] = (potential.weight or 1.0) / (stretch * potential.size)
        pose, done = seek(potential, pose, 1e-6) if done else (pose, False)
    potential.force[held], potential.penalty[:] = potential.tension[held], 0.0
    return pose, done


def _seek_taut(potential: Potential, start: Array, cables: NDArray[np.int64]) -> tuple[Array, bool]:
    """Solve for equilibrium with the lengths of taut cables by damped Newton steps (Marquardt, 1963).

    Forces are written into `potential.force`. Return the pose (7,), and whether the equations nearly hold.
    """
    n, pose, damping = len(potential.rows), start, 1e-3
    load = potential.weight or 1.0
    stiffness = load / potential.size
    potential.force[cables] = load / max(len(cables), 1)
    gradient, hessian, excess = _conditions(potential, pose, cables)
    for _ in range(MOST_DAMPED):
        right = -np.concatenate([gradient, stiffness * excess])
        error = float(right @ right)
        if not np.isfinite(hessian).all() or error <= (NEARLY * load) ** 2:
            break
        columns = stiffness * potential.columns()[:, cables]
        matrix = np.zeros((n + len(cables), n + len(cables)))
        matrix[:n, :n], matrix[:n, n:], matrix[n:, :n] = hessian, -columns, -columns.T
        normal, slope = matrix.T @ matrix, matrix.T @ right
        forces, accepted = potential.force[cables].copy(), False
        while not accepted and damping < 1e6:
            step = np.linalg.solve(normal + damping * stiffness**2 * np.eye(len(slope)), slope)
            step *= min(1.0, 0.2 * potential.size / max(float(np.linalg.norm(step[:n])), 1e-300))
            trial = potential.moved(pose, step[:n])
            potential.force[cables] = forces + stiffness * step[n:]
            values = _conditions(potential, trial, cables)
            then = float(values[0] @ values[0] + stiffness**2 * values[2] @ values[2])
            accepted, damping = then < error, damping * (0.2 if then < error else 5.0)
        if not accepted:
            potential.force[cables] = forces
            return pose, False
        pose, (gradient, hessian, excess) = trial, values
        damping = max(damping, 1e-12)
    return pose, bool(float(gradient @ gradient) + stiffness**2 * float(excess @ excess) <= (NEARLY * load) ** 2)


def _conditions(potential: Potential, pose: Array, cables: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    _, gradient, hessian = potential.evaluate(pose)
    return gradient, hessian, (potential.length - potential.unwound)[cables]


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
