"""Computation of the figures of a candidate."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cdpr.analysis.design.schema import SETS, FigureSection
from cdpr.analysis.workspace import Question, Region, required, workspace
from cdpr.analysis.workspace.kinds import KINDS, kind_of
from cdpr.analysis.workspace.required import Required
from cdpr.base.errors import CdprError
from cdpr.base.problems import Path
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle


@dataclass(frozen=True, eq=False)
class Place:
    """Poses at which figures are evaluated.

    Attributes:
        region: the region; None if poses are given.
        poses: (K, 7), positions (m) and quaternions w, x, y, z; for a region, the centres of all cells in all
            attitudes.
    """

    region: Region | None
    poses: Array

    @classmethod
    def of_region(cls, region: Region) -> Place:
        """Return the poses of all cells of a region."""
        positions = region.positions(np.arange(region.cells))
        turned = np.repeat(region.orientations, len(positions), axis=0)
        return cls(region, np.hstack([np.tile(positions, (len(region.orientations), 1)), turned]))


@dataclass(frozen=True)
class Figure:
    """Figure that is ready for evaluation.

    Attributes:
        section: definition in the study file.
        question: parameters of its kind of workspace.
        path: key of a number in the robot file.
    """

    section: FigureSection
    question: Question = field(default_factory=Question)
    path: Path = ()

    @property
    def unit(self) -> str:
        """Unit of its values; empty if only the robot file defines it."""
        section = self.section
        if section.volume or section.key:
            return ""
        return "m" if section.extent else KINDS[section.kind].unit_of(self.question)


@dataclass(frozen=True)
class Value:
    """Value of a figure for one candidate.

    Attributes:
        value: the value; None if no pose has one.
        missing: share of the poses without a value: the cables cannot hold the platform, or W is rank-deficient.
    """

    value: float | None
    missing: float = 0.0


def question_of(section: FigureSection, gravity: Array, obstacles: tuple[Obstacle, ...]) -> Question:
    """Return the parameters of a figure for its kind of workspace.

    Raises:
        CdprError: if the kind does not support a parameter.
    """
    kind = kind_of(section.kind)
    given = _required(section)
    for part in ("diameter", "axial_stiffness", "direction"):
        if getattr(section, part) is not None and part not in kind.takes:
            raise CdprError(f"{kind.name} does not accept {part}")
    return Question(
        required=kind.required(given),
        gravity=gravity,
        length=section.length,
        at_least=section.at_least,
        obstacles=obstacles if "obstacles" in kind.takes else (),
        diameter=section.diameter,
        axial_stiffness=section.axial_stiffness,
        direction=section.direction,
    )


def evaluate(figure: Figure, robot: Robot, place: Place) -> Value:
    """Return a figure of a robot, computed in this thread.

    Volumes count cells that are inside in all attitudes.

    Raises:
        CdprError: if the robot lacks required data.
    """
    section = figure.section
    if section.extent:
        return Value(float(np.ptp(robot.anchors[:, "xyz".index(section.extent)])))
    if section.diameter is None and "diameter" in kind_of(section.kind).takes:
        for cable in robot.cables:
            if cable.diameter is None:  # the assumed one would depend on the candidate
                need = "give the robot cable.diameter, or the figure its diameter (m)"
                raise CdprError(f"cable '{cable.name}' has no diameter: {need}")
    if section.volume:
        assert place.region is not None
        return Value(workspace(robot, section.volume, place.region, figure.question, jobs=1).volume)
    figure.question.check(robot)
    found = kind_of(section.kind).answer(robot, place.poses, figure.question, 1).value
    known = found[np.isfinite(found)]
    missing = 1.0 - len(known) / len(found)
    if not len(known):
        return Value(None, missing)
    return Value(float(known.min() if section.least else known.mean()), missing)


def _required(section: FigureSection) -> Required | None:
    for name in SETS:
        half = getattr(section, name)
        if half is not None:
            make = required.box if name.endswith("box") else required.ellipsoid
            return make(np.array(half), accelerations=name.startswith("acceleration"))
    return None
