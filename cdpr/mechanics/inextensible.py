"""Minima of the potential energy with cables that do not stretch: lengths as one-sided constraints.

The method of multipliers (Hestenes, J. Optim. Theory Appl. 4, 1969) finds the taut cables; Newton steps on the
Karush-Kuhn-Tucker conditions then make lengths and forces exact. Rigid legs are constraints on both sides.
"""

from __future__ import annotations

import numpy as np

from cdpr.mechanics.descent import descend
from cdpr.mechanics.potential import Potential
from cdpr.model.robot import Array

STRETCH = 1e-3  # of a penalised cable under the load, as a share of the size
MOST_ROUNDS = 40
STIFFER, STIFFEST = 10.0, 1e6  # factors of the penalty: of a round, and in all
NEAR = 1e-6  # error of lengths, as a share of the size, from which Newton steps finish
EXACT = 1e-12  # error of exact lengths, as a share of the size
MOST_NEWTON = 30
SINGULAR = 1e-11  # share of the largest singular value below which constraints are redundant


def violation(potential: Potential) -> Array:
    """Return how much longer rigid cables (m,) are than unwound [m], or legs differ from it, at the last pose."""
    excess = potential.length - potential.unwound
    if potential.robot.unilateral:
        excess = np.maximum(excess, 0.0)
    return np.where(potential.rigid, excess, 0.0)


def descend_inextensible(potential: Potential, start: Array, tolerance: float) -> tuple[Array, bool]:
    """Return a local minimum (7,), and whether it converged; `potential.force` then has the tensions of rigid cables.

    Without convergence, lengths are violated as little as possible near the last pose (least squares).
    """
    rigid = potential.rigid
    pose, before, first = start, np.inf, _penalise(potential)
    limits = potential.weight, float(np.abs(potential.force).max(initial=0.0))
    for _ in range(MOST_ROUNDS):
        pose, _ = descend(potential, pose, 1e-8)
        potential.force[rigid] = potential.tension[rigid]
        error = float(np.linalg.norm(violation(potential)))
        if not np.isfinite(error):
            return pose, False
        if error <= NEAR * potential.size:
            penalty = potential.penalty.copy()
            exact, done = polish(potential, pose, tolerance)
            if done:
                return exact, True
            potential.penalty[:] = penalty
        if error > 0.25 * before and potential.penalty.max() < STIFFEST * first:
            potential.penalty[rigid] *= STIFFER
        elif error > 0.9 * before and np.abs(potential.force[rigid]).max() > 1e4 * max(*limits, first * STRETCH):
            break
        before = error
    return fit_lengths(potential, pose), False


def _penalise(potential: Potential) -> float:
    """Set penalties for rigid cables, and return their stiffness [N/m]."""
    load = potential.weight or float(np.abs(potential.force).max(initial=0.0)) or 1.0
    stiffness = load / (STRETCH * potential.size)
    potential.penalty[potential.rigid] = stiffness
    return stiffness


def fit_lengths(potential: Potential, start: Array) -> Array:
    """Return the pose (7,) near the start at which the sum of squared violations of lengths is least."""
    kept = potential.force.copy(), potential.gravity.copy(), potential.spring.copy()
    potential.force[:], potential.gravity[:], potential.spring[:] = 0.0, 0.0, 0
    potential.penalty[:] = np.where(potential.rigid, 1.0, 0.0)
    pose, _ = descend(potential, start, 1e-12)
    potential.force[:], potential.gravity[:], potential.spring[:] = kept
    potential.evaluate(pose)
    return pose


def polish(potential: Potential, start: Array, tolerance: float) -> tuple[Array, bool]:
    """Return a pose (7,) with exact lengths and forces by Newton steps on the active set, and whether it converged."""
    rigid, one_sided = potential.rigid, potential.robot.unilateral
    kept = potential.force.copy()
    potential.penalty[:] = 0.0
    active = rigid & (potential.force > 1e-9 * potential.force.max(initial=0.0)) if one_sided else rigid.copy()
    for _ in range(2 * len(rigid) + 1):
        potential.force[rigid & ~active] = 0.0
        pose, done = newton(potential, start, active, tolerance)
        if not done:
            break
        excess = np.where(rigid & ~active, potential.length - potential.unwound, -1.0)
        lowest = np.where(active, potential.force, np.inf)
        if one_sided and lowest.min() < -1e-9 * potential.load():
            active[lowest.argmin()] = False
        elif one_sided and excess.max() > EXACT * potential.size:
            active[excess.argmax()] = True
        else:
            potential.force[rigid] = np.maximum(potential.force[rigid], 0.0) if one_sided else potential.force[rigid]
            return pose, True
    potential.force[:] = kept
    potential.evaluate(start)
    return start, False


def newton(potential: Potential, start: Array, active: Array, tolerance: float) -> tuple[Array, bool]:
    """Solve for equilibrium with the lengths of the active cables (m,); their forces are in `potential.force`."""
    pose, n = start, len(potential.rows)
    cables = np.flatnonzero(active)
    for _ in range(MOST_NEWTON):
        _, gradient, hessian = potential.evaluate(pose)
        if not np.isfinite(hessian).all():
            return pose, False
        excess = (potential.length - potential.unwound)[cables]
        load = potential.load()
        far = float(np.abs(excess).max(initial=0.0))
        if np.linalg.norm(gradient) <= tolerance * load and far <= EXACT * potential.size:
            return pose, True
        stiffness = load / potential.size or 1.0
        columns = stiffness * potential.columns()[:, cables]
        matrix = np.zeros((n + len(cables), n + len(cables)))
        matrix[:n, :n], matrix[:n, n:], matrix[n:, :n] = hessian, -columns, -columns.T
        right = -np.concatenate([gradient, stiffness * excess])
        step = np.linalg.lstsq(matrix, right, rcond=SINGULAR)[0]
        size = float(np.linalg.norm(step[:n]))
        if size > 0.1 * potential.size:
            return pose, False
        pose = potential.moved(pose, step[:n])
        potential.force[cables] += stiffness * step[n:]
    return pose, False
