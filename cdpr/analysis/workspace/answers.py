"""Measures of the kinds of workspaces; each function evaluates poses (K, 7) of a robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.distribution.sagging import static_tensions
from cdpr.analysis.workspace.measure import Measured, Mode, measure
from cdpr.analysis.workspace.question import Question, directions
from cdpr.base.errors import CdprError
from cdpr.cables import bends, chain_of
from cdpr.mechanics.assumed_diameters import assumption, with_diameters
from cdpr.mechanics.clearance import Clearance, clearance
from cdpr.mechanics.exit_friction import friction_note
from cdpr.mechanics.sag import CHORD
from cdpr.mechanics.stiffness import SLACK, inertia, stiffness
from cdpr.model import Robot
from cdpr.model.rank import RANK_TOLERANCE, significant
from cdpr.model.robot import Array


def margin(robot: Robot, poses: Array, question: Question, jobs: int | None = None) -> Measured:
    """Return the capacity margin, N."""
    return _exerted(robot, poses, question, jobs, "margin")


def closure(robot: Robot, poses: Array, question: Question, jobs: int | None = None) -> Measured:
    """Return the closure measure: the ability of the cables to pull against each other in all directions."""
    return _exerted(robot, poses, question, jobs, "closure")


def payload(robot: Robot, poses: Array, question: Question, jobs: int | None = None) -> Measured:
    """Return the largest additional mass, kg."""
    return _exerted(robot, poses, question, jobs, "payload")


def bodies_of(robot: Robot, question: Question) -> Clearance:
    """Return the bodies that cables may touch; cables without a diameter have the assumed one, rigid legs do not."""
    assume = question.diameter is None and robot.unilateral
    return clearance(with_diameters(robot) if assume else robot, question.obstacles, question.diameter)


def free(robot: Robot, poses: Array, question: Question, jobs: int | None = None) -> Measured:
    """Return the smallest clearance of cables, m."""
    value, which = bodies_of(robot, question).at(poses, jobs)
    return Measured(value, _ones(value), _no(value), which)


def dexterity(robot: Robot, poses: Array, question: Question, jobs: int | None = None) -> Measured:
    """Return the ratio of the smallest to the largest singular value of W, moments divided by the length."""
    _, W = stiffness(robot, poses, np.zeros((len(poses), robot.m)), gravity=question.gravity, jobs=jobs)
    sizes = np.linalg.svd(W[:, robot.rows] * question.weights(robot)[:, None], compute_uv=False)
    value = np.zeros(len(poses)) if robot.m < robot.n else sizes[:, -1] / sizes[:, 0]
    return Measured(value, _ones(value), _no(value), _nothing(value))


def stiff(robot: Robot, poses: Array, question: Question, jobs: int | None = None) -> Measured:
    """Return the smallest stiffness, or that in one direction with all else free.

    The unit is N/m, with moments divided by the length.
    """
    K, _, held = _stiffness(robot, poses, question, jobs, needed=True)
    if question.direction is None:
        return _least(K * np.outer(question.weights(robot), question.weights(robot)), held)
    at = robot.dof.index(question.direction)
    value = np.full(len(K), np.nan)
    regular = held & (np.linalg.cond(K) < 1.0 / RANK_TOLERANCE)
    value[regular] = 1.0 / np.linalg.inv(K[regular])[:, at, at]
    least = _least(K * np.outer(question.weights(robot), question.weights(robot)), held).value
    value[least <= 0.0] = -np.abs(value[least <= 0.0])  # unstable in some other direction
    return Measured(value, np.abs(K).max(axis=(1, 2)), _no(value), _nothing(value))


def stable(robot: Robot, poses: Array, question: Question, jobs: int | None = None) -> Measured:
    """Return the smallest stiffness with which the platform returns, N/m with moments divided by the length.

    Cables of unknown axial stiffness have constant length: only motions that stretch no taut such cable count. The
    result is infinite if there is no such motion, since a platform held by taut rigid cables is stable.
    """
    K, W, held = _stiffness(robot, poses, question, jobs, needed=False)
    weights = question.weights(robot)
    K = K * np.outer(weights, weights)
    if not _rigid(robot, question).any():
        return _least(K, held)
    tension = static_tensions(robot, poses, gravity=question.gravity, jobs=jobs).tension
    value, scale = np.full(len(K), np.nan), np.ones(len(K))
    for k in np.flatnonzero(held):
        taut = _rigid(robot, question) & (tension[k] > SLACK * tension[k].max())
        _, sizes, motions = np.linalg.svd((W[k][robot.rows] * weights[:, None])[:, taut].T)
        kept = motions[significant(sizes) :]  # motions that stretch no cable
        left = np.linalg.eigvalsh(_symmetric(kept @ K[k] @ kept.T))
        value[k] = left[0] if len(left) else np.inf
        scale[k] = np.abs(left).max(initial=1.0)
    return Measured(value, scale, _no(value), _nothing(value))


def frequency(robot: Robot, poses: Array, question: Question, jobs: int | None = None) -> Measured:
    """Return the lowest natural frequency, Hz, with locked drums and without damping; negative if unstable."""
    K, _, held = _stiffness(robot, poses, question, jobs, needed=True)
    rows = np.ix_(robot.rows, robot.rows)
    mass = np.array([each[rows] for each in inertia(robot, poses)])
    root = np.linalg.inv(np.linalg.cholesky(mass))
    squares = np.full((len(K), robot.n), np.nan)
    squares[held] = np.linalg.eigvalsh(_symmetric(root[held] @ K[held] @ np.swapaxes(root[held], 1, 2)))
    value = np.copysign(np.sqrt(np.abs(squares[:, 0])), squares[:, 0]) / (2.0 * np.pi)
    scale = np.sqrt(np.abs(squares[:, -1])) / (2.0 * np.pi)
    return Measured(value, scale, _no(value), _nothing(value))


def limits(robot: Robot, question: Question, numbers: list[int], *, bodies: bool) -> dict[str, str]:
    """Return the names of the limiting bodies or directions by number."""
    if bodies:
        among = bodies_of(robot, question)
        return {str(number): among.name(number) for number in numbers}
    names = directions(robot)
    return {str(number): names[number] for number in numbers if number >= 0}


def notes(robot: Robot, question: Question, *, bodies: bool) -> list[str]:
    """Return remarks on an answer."""
    texts = [f"cables sag: {CHORD}"] if bends(robot) else []
    if note := friction_note(robot):
        texts.append(note)
    if not bodies and robot.m < robot.n:
        few = f"{robot.m} cable{'s' * (robot.m != 1)} for {robot.n} degrees of freedom"
        texts.append(f"{few}: the wrench matrix is rank-deficient at every pose")
    if not bodies:
        return texts
    among = bodies_of(robot, question)
    if question.diameter is None and (assumed := assumption(robot)):
        texts.append(assumed.removeprefix(", "))
    if among.sharing:
        pairs = ", ".join(f"{first} and {second}" for first, second in among.sharing)
        texts.append(f"share an anchor, so their other ends count: {pairs}")
    if robot.platform.shape is None:
        texts.append("the platform has no shape that a cable could touch")
    elif among.unjudged:
        texts.append(f"anchored inside the platform's shape, so not judged against it: {', '.join(among.unjudged)}")
    return texts


def _exerted(robot: Robot, poses: Array, question: Question, jobs: int | None, mode: Mode) -> Measured:
    required, gravity, length = question.required, question.gravity, question.length
    return measure(robot, poses, mode, required, gravity=gravity, length=length, jobs=jobs)


def _rigid(robot: Robot, question: Question) -> NDArray[np.bool_]:
    """Return True for cables without axial stiffness, (m,)."""
    given = question.axial_stiffness is not None
    return np.array([not given and not chain_of(robot, cable).span.stiffest(cable) for cable in robot.cables])


def _stiffness(
    robot: Robot, poses: Array, question: Question, jobs: int | None, *, needed: bool
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return K (K, n, n) and W (K, 6, m) at the static tensions, and True for poses where these exist."""
    rigid = _rigid(robot, question)
    if needed and rigid.any():
        name = robot.cables[int(np.argmax(rigid))].name
        raise CdprError(
            f"cable '{name}' has no axial_stiffness: give the robot cable.axial_stiffness, or set --axial-stiffness (N)"
        )
    tensions = static_tensions(robot, poses, gravity=question.gravity, jobs=jobs)
    K, W = stiffness(
        robot,
        poses,
        tensions.tension,
        axial_stiffness=question.axial_stiffness,
        gravity=question.gravity,
        jobs=jobs,
    )
    K[np.isnan(K).any(axis=(1, 2))] = np.eye(6)  # ignored: these poses have no tensions, and NaN has no eigenvalues
    return K[:, robot.rows][:, :, robot.rows], W, np.asarray(tensions.feasible, dtype=bool)


def _least(K: Array, held: NDArray[np.bool_]) -> Measured:
    """Return the smallest eigenvalue of K (K, n, n); NaN if the cables do not hold the platform."""
    found = np.linalg.eigvalsh(_symmetric(K))
    value = np.where(held, found[:, 0], np.nan)
    return Measured(value, np.abs(found).max(axis=1), _no(value), _nothing(value))


def _symmetric(K: Array) -> Array:
    return np.asarray(0.5 * (K + np.swapaxes(K, -1, -2)))


def _ones(value: Array) -> Array:
    return np.ones(len(value))


def _no(value: Array) -> NDArray[np.bool_]:
    return np.zeros(len(value), dtype=bool)


def _nothing(value: Array) -> NDArray[np.int64]:
    return np.full(len(value), -1, dtype=np.int64)
