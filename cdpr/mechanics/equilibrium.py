"""Pose at which a platform comes to rest, for given unwound lengths or tensions of its cables.

The pose is a minimum of the potential energy: weight, taut cables, and nothing for slack ones. Cables that sag pull and
weigh, taut or slack. The pose is checked by the remaining force and, for cables that do not stretch, by their lengths.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.base.errors import CdprError
from cdpr.mechanics.descent import descend, flat, seek
from cdpr.mechanics.forward_kinematics import suspect_length
from cdpr.mechanics.inextensible import descend_inextensible, polish, violation
from cdpr.mechanics.potential import Potential, rest_lengths
from cdpr.mechanics.sag import too_loose
from cdpr.mechanics.stiffness import inertia
from cdpr.model import Robot
from cdpr.model.rank import significant
from cdpr.model.robot import Array

Mask = NDArray[np.bool_]

BALANCED = 1e-9  # largest remaining force, as a share of the load
CONSISTENT = 1e-9  # largest violation of lengths, as a share of the size
TOLERANCE = 1e-11  # force at which the search ends, as a share of the load


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Pose at rest of a robot with m cables and n degrees of freedom.

    Attributes:
        pose: (7,) position [m] and quaternion w, x, y, z, world frame.
        tension: (m,) tensions [N]; NaN for cables that do not stretch, if their lengths are impossible.
        length: (m,) lengths between winch exit and platform, with the cable on pulleys [m].
        unwound: (m,) unwound lengths of the unloaded cables [m].
        slack: (m,) True for cables without tension, and for cables that sag and whose tension grows with their length.
        residual: remaining force [N], moments divided by the characteristic length; NaN if lengths are impossible.
        load: weight, or largest tension if larger [N].
        misfit: norm of the violated lengths of cables that do not stretch [m].
        converged: True if the residual is below 1e-9 of the load and all lengths are possible.
        problem: reason, if not converged; else "".
        suspect: index of the cable whose length contradicts the others, None if there is none or several may be wrong.
        stability: "stable", "neutral" or "unstable"; "unknown" if lengths are impossible.
        eigenvalues: (k,) of the Hessian of the energy over the motions that the cables permit [N/m], ascending;
            rotations are multiplied by the characteristic length.
        frequencies: (k,) natural frequencies [Hz] of these motions with held drums, ascending; NaN if unstable.
        free_directions: (r, 6) twists that change the length of no taut cable to first order: swings.
        sensitivity: (6, m) change of position [m] and rotation vector [rad], world axes, with each unwound length [per
            m], or with each given tension [per N].
    """

    pose: Array
    tension: Array
    length: Array
    unwound: Array
    slack: Mask
    residual: float
    load: float
    misfit: float
    converged: bool
    problem: str
    suspect: int | None
    stability: str
    eigenvalues: Array
    frequencies: Array
    free_directions: Array
    sensitivity: Array

    def __repr__(self) -> str:
        x, y, z = (float(f"{value:.6g}") for value in self.pose[:3])
        found = self.stability if self.converged else "not converged"
        return f"<Equilibrium at ({x}, {y}, {z}) m: {found}, {int(self.slack.sum())} of {len(self.slack)} cables slack>"


@np.errstate(all="ignore")  # huge values end without convergence
def find_equilibrium(robot: Robot, unwound: Array, tension: Array, start: Array, gravity: ArrayLike) -> Equilibrium:
    """Return the pose at rest that is reached downhill from a start.

    Args:
        robot: geometry, mass and cables.
        unwound: (m,) unwound lengths [m], NaN for cables with a given tension.
        tension: (m,) tensions [N], NaN for cables with a given length.
        start: (7,) initial pose.
        gravity: (3,) gravity [m/s^2], world axes.

    Raises:
        CdprError: if a cable has no path at the start, or sags and has too little tension there.
    """
    potential = Potential(robot, gravity, unwound, tension)
    if not potential.defined(start):
        loose = too_loose(robot, start[:3], start[3:], potential.gravity, np.where(np.isnan(tension), np.inf, tension))
        text = "a cable has no length or no path over its pulley there: choose another start"
        raise CdprError(f"start: {loose or text}")
    hard = potential.rigid.any()
    pose, done = (descend_inextensible if hard else descend)(potential, start, TOLERANCE)
    if not done and potential.bent.any():  # on pulleys, the energy of cables that sag is approximate
        pose, _ = (polish if hard else seek)(potential, pose, TOLERANCE)
    return describe(potential, pose)


def describe(potential: Potential, pose: Array) -> Equilibrium:
    """Return the properties of a pose (7,) with the present forces of rigid cables."""
    robot, rigid = potential.robot, potential.rigid
    potential.penalty[:] = 0.0
    defined = potential.defined(pose)
    _, gradient, hessian = potential.evaluate(pose)
    wrong = violation(potential)
    residual, load, misfit = float(np.linalg.norm(gradient)), potential.load(), float(np.linalg.norm(wrong))
    possible = misfit <= CONSISTENT * potential.size
    converged = bool(defined and possible and residual <= BALANCED * load)
    suspect = None if possible or not defined else _suspect(potential, pose)
    tension, length = potential.tension.copy(), potential.length.copy()
    taut: Mask = tension > 0.0 if robot.unilateral else np.ones(robot.m, dtype=bool)
    taut &= ~(potential.bent & (potential.shift > 0.0))
    if not possible:
        residual, load, defined = np.nan, potential.weight, False
        tension[rigid], taut[rigid] = np.nan, wrong[rigid] != 0.0
    given = (potential.spring == 1) | rigid
    at_rest = rest_lengths(robot, pose[None], potential.tension[None], gravity=potential.gravity)[0]
    return Equilibrium(
        pose=pose,
        tension=tension,
        length=length,
        unwound=np.where(given, potential.unwound, at_rest),
        slack=~taut,
        residual=residual,
        load=load,
        misfit=misfit,
        converged=converged,
        problem="" if converged else _problem(potential, pose, wrong, suspect, possible),
        suspect=suspect,
        **_motions(potential, pose, hessian, taut, given, defined),
    )


def _motions(
    potential: Potential, pose: Array, hessian: Array, taut: Mask, given: Mask, defined: bool
) -> dict[str, Any]:
    """Return stability, frequencies, free directions and sensitivities at the last evaluated pose."""
    robot, scale = potential.robot, potential.scale
    sensitivity = np.zeros((6, robot.m))
    if not defined:
        sensitivity[potential.rows] = np.nan
        nothing = {"eigenvalues": np.empty(0), "frequencies": np.empty(0), "free_directions": np.empty((0, 6))}
        return {"stability": "unknown", "sensitivity": sensitivity, **nothing}
    columns = potential.columns()
    hard = columns[:, potential.rigid & taut]
    basis = _null_space(hard) if hard.size else np.eye(robot.n)
    stiffness = basis.T @ hessian @ basis
    values = np.asarray(np.linalg.eigvalsh(stiffness), dtype=float)
    mass = inertia(robot, pose[None])[0][potential.rows][:, potential.rows] / np.outer(scale, scale)
    sensitivity[potential.rows] = _sensitivity(potential, hessian, columns, taut) / scale[:, None]
    return {
        "stability": _stability(values, flat(np.asarray(np.linalg.eigvalsh(hessian), dtype=float), potential)),
        "eigenvalues": values,
        "frequencies": _frequencies(stiffness, basis.T @ mass @ basis),
        "free_directions": _twists(_null_space(columns[:, taut & given]), potential),
        "sensitivity": sensitivity,
    }


def _null_space(columns: Array) -> Array:
    """Return an orthonormal basis (n, r) of the scaled motions that change no length, for columns (n, k)."""
    U, values, _ = np.linalg.svd(columns)
    return np.asarray(U[:, significant(values) :])


def _twists(basis: Array, potential: Potential) -> Array:
    twists = np.zeros((basis.shape[1], 6))
    twists[:, potential.rows] = (basis / potential.scale[:, None]).T
    return twists


def _stability(values: Array, round_off: float) -> str:
    if not len(values) or values[0] > round_off:
        return "stable"
    return "neutral" if values[0] >= -round_off else "unstable"


def _frequencies(stiffness: Array, mass: Array) -> Array:
    """Return natural frequencies [Hz], NaN for motions that grow."""
    if not len(mass):
        return np.empty(0)
    inverse = np.linalg.inv(np.linalg.cholesky(mass))
    squares = np.linalg.eigvalsh(inverse @ stiffness @ inverse.T)
    squares[np.abs(squares) <= 1e-12 * np.abs(squares).max()] = 0.0
    return np.asarray(np.sqrt(np.where(squares < 0.0, np.nan, squares)) / (2.0 * np.pi))


def _sensitivity(potential: Potential, hessian: Array, columns: Array, taut: Mask) -> Array:
    """Return the scaled motion (n, m) per unwound length or tension, by the implicit function theorem."""
    n, m = columns.shape
    hard = np.flatnonzero(potential.rigid & taut)
    stiffness = float(np.abs(hessian).max()) or 1.0
    side = stiffness * columns[:, hard]
    matrix = np.zeros((n + len(hard), n + len(hard)))
    matrix[:n, :n], matrix[:n, n:], matrix[n:, :n] = hessian, -side, -side.T
    right = np.zeros((n + len(hard), m))
    right[:n] = np.where(potential.rigid, 0.0, potential.response[potential.rows] / potential.scale[:, None])
    right[n + np.arange(len(hard)), hard] = stiffness
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=1e-12)[0][:n])


def _suspect(potential: Potential, pose: Array) -> int | None:
    """Return the rigid cable without which the lengths of the others fit a pose."""
    robot, rigid = potential.robot, np.flatnonzero(potential.rigid)
    found = suspect_length(robot.replace(cables=[robot.cables[i] for i in rigid]), potential.unwound[rigid], pose)
    return None if found is None else int(rigid[found])


def _problem(potential: Potential, pose: Array, wrong: Array, suspect: int | None, possible: bool) -> str:
    robot = potential.robot
    if not possible:
        worst = int(np.abs(wrong).argmax())
        name = robot.cables[worst].name
        text = f"no pose near the start has these lengths: cable '{name}' lacks {abs(wrong[worst]):.4g} m"
        if suspect is not None:
            text += f"; without cable '{robot.cables[suspect].name}', the other lengths fit: check its length"
        return text
    if np.abs(pose[:3] - robot.anchors[:, :3].mean(axis=0)).max() > 10.0 * potential.size:
        return "the platform moves away: no cable holds it"
    short = int(np.argmin(np.where(np.isfinite(potential.length), potential.length, -1.0)))
    if not potential.length[short] > 1e-6 * potential.size:
        return f"cable '{robot.cables[short].name}' pulls the platform into its exit: reduce its tension or lengthen it"
    return "no equilibrium was found from this start: choose another start"
