"""Evaluation of positions in all attitudes of a region."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.distribution import distribute
from cdpr.analysis.workspace.kinds import KINDS, WorkspaceKind
from cdpr.analysis.workspace.measure import Measured
from cdpr.analysis.workspace.octree import CellResults
from cdpr.analysis.workspace.question import Question
from cdpr.analysis.workspace.regions import PIECE, Region
from cdpr.analysis.workspace.required import NOTHING
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array

Over = Literal["all", "any"]

# Share of a value's scale below which its sign is round-off: MARGIN_ROUNDING of facets.hpp.
BOUNDARY = 1e-9


def evaluate_positions(
    robot: Robot,
    kind: WorkspaceKind,
    question: Question,
    region: Region,
    over: Over,
    positions: Array,
    jobs: int | None,
) -> CellResults:
    """Return the results for positions (n, 3) in all attitudes of a region."""
    value, limit = np.full(len(positions), np.nan), np.full(len(positions), -1, dtype=np.int64)
    boundary, inside = np.zeros(len(positions), dtype=bool), np.full(len(positions), over == "all")
    for first in range(0, len(positions), PIECE):
        cut = slice(first, first + PIECE)
        poses = np.empty((len(positions[cut]), 7))
        poses[:, :3] = positions[cut]
        lost = np.zeros(len(poses), dtype=bool)  # True if an attitude has no value, so that there is no minimum
        for q in region.orientations:
            poses[:, 3:] = q
            found = kind.answer(robot, poses, question, jobs)
            here = inside_of(robot, kind, question, found, poses)
            before = value[cut]
            with np.errstate(invalid="ignore"):
                better = found.value < before if over == "all" else found.value > before
            better |= np.isnan(before) & ~np.isnan(found.value)
            value[cut], limit[cut] = np.where(better, found.value, before), np.where(better, found.limit, limit[cut])
            lost |= np.isnan(found.value)
            inside[cut] = inside[cut] & here if over == "all" else inside[cut] | here
            boundary[cut] |= np.abs(found.value - (question.at_least or 0.0)) <= BOUNDARY * found.scale
        if over == "all":
            value[cut][lost] = np.nan
    return CellResults(value, limit, inside, boundary)


def inside_of(
    robot: Robot, kind: WorkspaceKind, question: Question, found: Measured, poses: Array
) -> NDArray[np.bool_]:
    """Return True for poses inside, (K,); where W is rank-deficient, a solver decides if possible."""
    rounding = BOUNDARY * found.scale
    with np.errstate(invalid="ignore"):
        if question.at_least is not None:
            inside = found.value >= question.at_least - rounding
        else:
            inside = found.value >= -rounding if kind.at_zero else found.value > rounding
    lost = found.singular
    least = question.at_least or 0.0
    if lost.any() and kind.held and (kind.mass or least <= 0.0):
        platform = robot.platform
        loaded = replace(robot, platform=replace(platform, mass=platform.mass + least)) if kind.mass else robot
        inside[lost] = _held(loaded, poses[lost], question)
    return np.asarray(inside)


def _held(robot: Robot, poses: Array, question: Question) -> NDArray[np.bool_]:
    """Return True if tensions within the limits provide all corners of the required set in addition to the weight."""
    required, held = question.required, np.ones(len(poses), dtype=bool)
    if required.form == "ellipsoid" and len(required.vectors):
        return ~held  # unknown for flat ellipsoids; others do not fit a rank-deficient W
    for corner in required.corners():
        moved = (corner[:3], corner[3:]) if required.accelerations else ()
        wrenches = [required_wrench(robot, make_state(p[:3], p[3:]), question.gravity, *moved) for p in poses]
        beyond = np.array(wrenches) + (0.0 if required.accelerations else corner)
        held &= np.asarray(distribute(robot, poses, beyond, gravity=question.gravity).feasible, dtype=bool)
    return held


def checked_question(
    kind: WorkspaceKind, robot: Robot, question: Question | None, over: Over, options: dict[str, Any]
) -> Question:
    """Return the complete question, including the parts given by name.

    Raises:
        CdprError: if it is invalid.
    """
    if over not in ("all", "any"):
        raise CdprError(f"over: expected all or any of the orientations, got {shown(over)}")
    known = [each.name for each in fields(Question)]
    for name in options:
        if name not in known:
            raise CdprError(f"{name}: unknown argument; allowed: {', '.join(known)}")
    if "gravity" in options:
        options["gravity"] = checked(options["gravity"], (3,), "gravity", finite=True)
    given = replace(question or Question(), **options)
    given.check(robot)
    for name in ("obstacles", "diameter", "axial_stiffness", "direction"):
        if getattr(given, name) not in (None, ()) and name not in kind.takes:
            raise CdprError(f"{kind.name}: does not accept {name}; only {_takers(name)} accept it")
    required = None if given.required is NOTHING else given.required
    return replace(given, required=kind.required(required))


def _takers(name: str) -> str:
    return " and ".join(kind.name for kind in KINDS.values() if name in kind.takes)
