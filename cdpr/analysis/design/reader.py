"""Reader of a design's study file; all errors are reported at their position in the file."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.analysis.design.evaluate import Figure, Place, evaluate, question_of
from cdpr.analysis.design.plan import Design, Target, document_of
from cdpr.analysis.design.schema import MAX_CELLS, MAX_EVALUATIONS, DesignFile, FigureSection, Variable
from cdpr.analysis.workspace import Region, region
from cdpr.base.errors import CdprError
from cdpr.base.files import UnreadableError, read
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import Path, shown
from cdpr.config.document import Document
from cdpr.config.overrides import marked_changes
from cdpr.config.problems import Problems
from cdpr.config.validation import report_nulls, validate
from cdpr.config.yaml_text import dump
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.model.robot import Array, read_only
from cdpr.model.rotations import held_upright
from cdpr.model.shapes import Obstacle
from cdpr.scenario import examples
from cdpr.scenario.from_python import data_for
from cdpr.scenario.loader import Source, load_robot, open_with
from cdpr.scenario.source import stem

COLUMNS = ("number", "feasible", "violation", "refused", "goal")  # columns of the table, reserved names
# Command options in messages, and the corresponding keys of a figure.
OPTIONS = {"set --axial-stiffness": "set the figure axial_stiffness", "set --cable-diameter": "set the figure diameter"}


def load_design(path: Source, *, evaluations: int | None = None) -> Design:
    """Load a design's study file and check all of it.

    Args:
        path: the design's file, name of an example, or data with the keys of such a file, whose robot may be a Robot or
            a dict.
        evaluations: number of evaluations instead of the file's.

    Returns:
        The validated design.

    Raises:
        ScenarioError: with all errors of the file.
        CdprError: if `evaluations` is out of range.

    Example:
        >>> from cdpr.analysis.design import load_design
        >>> design = load_design("design_box", evaluations=20)
        >>> design
        <Design design_box: 8 variables, 1 goals>
    """
    if evaluations is not None and not 1 <= evaluations <= MAX_EVALUATIONS:
        raise CdprError(f"evaluations: expected a whole number from 1 to {MAX_EVALUATIONS}, got {shown(evaluations)}")
    problems = Problems()
    document, robot = open_with(path, "design", "robot", load_robot, problems)
    section = validate(DesignFile, document.data, document, problems)
    report_nulls(document.data, (), document, problems)
    problems.raise_any()
    assert section is not None
    if evaluations is not None:
        optimizer = section.optimizer.model_copy(update={"evaluations": evaluations})
        section = section.model_copy(update={"optimizer": optimizer})
    return _Reader(document, section, problems, robot).design()


@dataclass(frozen=True)
class _Reader:
    """Reader of one file; errors are collected in `problems`."""

    document: Document
    section: DesignFile
    problems: Problems
    robot: Robot | None  # given in Python

    def design(self) -> Design:
        section, problems = self.section, self.problems
        file, text = self._robot_file()
        self._names()
        targets = tuple(self._targets(i, variable) for i, variable in enumerate(section.vary))
        self._optimizer()
        problems.raise_any()
        robot = load_robot(file, text=text)
        place, obstacles = self._place(robot), self._obstacles()
        figures = {name: self._figure(name, each, obstacles) for name, each in section.figures.items()}
        problems.raise_any()
        known = {name: each for name, each in figures.items() if each is not None}
        assert place is not None
        name, source = section.name or stem(self.document.source), self.document.source
        start = np.zeros(len(targets))
        design = Design(name, source, section, file, text, robot, targets, known, place, start)
        start[:] = _start(design)
        design.candidate(read_only(start))  # reports each error at the varied key
        self._evaluate_once(design)
        problems.raise_any()
        return design

    def _add(self, path: Path, text: str) -> None:
        self.problems.add(self.document.mark(path), path, text)

    def _robot_file(self) -> tuple[str, str]:
        name = self.section.robot
        if self.robot is not None:
            file = os.path.join(self.document.folder, f"{name}.yaml")
            return file, dump(data_for(self.robot, self.document.folder))
        file = examples.beside(self.document.folder, name, "robot")
        if os.path.isabs(name) and self.document.source:  # a design in Python may give any
            self._add(("robot",), "expected a file name relative to this file")
            return file, ""
        try:
            return file, read(file).decode()
        except UnicodeDecodeError:
            self._add(("robot",), f"'{file}' is not text in UTF-8")
        except UnreadableError as error:
            self._add(("robot",), str(error))
        return file, ""

    def _names(self) -> None:
        """Check that names are unique and references exist."""
        section = self.section
        labels: list[tuple[Path, str]] = [(("vary", i), each.label) for i, each in enumerate(section.vary)]
        labels += [(("figures", name), name) for name in section.figures]
        seen: set[str] = set()
        for path, label in labels:
            if label in COLUMNS:
                self._add(path, f"cannot be named {label}: the table already has this column")
            elif label in seen:
                self._add(path, f"two variables or figures are named {shown(label)}: rename one")
            seen.add(label)
        used: list[tuple[Path, str]] = []
        for i, goal in enumerate(section.wanted):
            place: Path = (*(("goals", i) if section.goals else ("goal",)), goal.way)
            summed = isinstance(self.document.get(place), list)
            used += [((*place, k, "figure") if summed else place, term.figure) for k, term in enumerate(goal.terms)]
        used += [(("constraints", i, "figure"), limit.figure) for i, limit in enumerate(section.constraints)]
        for path, name in used:
            if name not in section.figures:
                hint = did_you_mean(name, section.figures)
                self._add(path, f"unknown figure {shown(name)}: {hint}allowed: {', '.join(section.figures)}")

    def _targets(self, number: int, variable: Variable) -> tuple[Target, ...]:
        path: Path = ("vary", number)
        before = {moved.key for other in self.section.vary[:number] for moved in other.moved}
        found = []
        for k, moved in enumerate(variable.moved):
            place: Path = (*path, "keys", k, "key") if variable.keys else (*path, "key")
            if moved.key in before:
                self._add(place, f"{moved.key} is set twice")
            before.add(moved.key)
            changes = marked_changes([(moved.key, 0.0, self.document.mark(place))], self.problems)
            found += [Target(change, moved.factor, moved.offset) for change in changes]
        return tuple(found)

    def _optimizer(self) -> None:
        section = self.section
        kind = section.optimizer.type
        path: Path = ("optimizer", "type")
        if len(section.wanted) > 1 and kind in ("differential_evolution", "cma"):
            self._add(path, f"{kind} supports one goal; nsga2 and random support several")
        if kind == "cma" and len(section.vary) < 2:
            self._add(path, "cma requires at least two variables; differential_evolution accepts one")

    def _place(self, robot: Robot) -> Place | None:
        given = self.section.region
        if given is None:
            return self._poses(robot)
        turned = [each.quaternion() for each in given.orientations or []]
        try:
            found = region(
                robot, lower=given.lower, upper=given.upper, cells=given.cells, orientations=turned if turned else None
            )
        except CdprError as error:
            self._add(("region",), str(error))
            return None
        count = found.cells * len(found.orientations)
        if count > MAX_CELLS:
            self._add(("region", "cells"), f"{count} poses a candidate; at most {MAX_CELLS} are allowed")
            return None
        return Place.of_region(found)

    def _poses(self, robot: Robot) -> Place:
        home = home_pose(robot)[0]
        rows = []
        for i, pose in enumerate(self.section.poses or []):
            q = home[3:] if pose.orientation is None else pose.orientation.quaternion()
            if not held_upright(robot.dof, q):
                moves = ", ".join(robot.dof)
                path: Path = ("poses", i, "orientation")
                self._add(path, f"the robot moves along {moves} only, so it cannot rotate about the other axes")
            rows.append([*pose.position, *q])
        return Place(None, read_only(np.array(rows)))

    def _obstacles(self) -> tuple[Obstacle, ...]:
        """Return the obstacles without those whose file is unreadable."""
        found = []
        for i, each in enumerate(self.section.obstacles):
            try:
                found.append(each.build(i + 1, self.document.folder))
            except UnreadableError as error:
                self._add(("obstacles", i, "mesh"), str(error))
        return tuple(found)

    def _figure(self, name: str, section: FigureSection, obstacles: tuple[Obstacle, ...]) -> Figure | None:
        path: Path = ("figures", name)
        if section.key is not None:
            changes = marked_changes([(section.key, 0.0, self.document.mark((*path, "key")))], self.problems)
            return Figure(section, path=changes[0].path) if changes else None
        if section.extent:
            return Figure(section)
        if section.volume and self.section.region is None:
            self._add((*path, "volume"), "a volume requires a region, not poses; with poses, use least or mean")
            return None
        try:
            return Figure(section, question_of(section, np.array(self.section.gravity), obstacles))
        except CdprError as error:
            self._add((*path, section.source), str(error))
        return None

    def _evaluate_once(self, design: Design) -> None:
        """Evaluate each figure at one pose, and report missing robot data at the figure."""
        place = design.place
        whole = place.region
        one = None if whole is None else Region(whole.lower, whole.upper, (1, 1, 1), whole.orientations[:1])
        small = Place(one, place.poses[:1])
        document, robot = document_of(design, design.start), design.candidate(design.start)
        for name, figure in design.figures.items():
            path: Path = ("figures", name)
            if figure.section.key is not None:
                if not _is_number(document.get(figure.path)):
                    self._add((*path, "key"), "the robot file has no number there")
                continue
            try:
                evaluate(figure, robot, small)
            except CdprError as error:
                text = str(error)
                for option, key in OPTIONS.items():
                    text = text.replace(option, key)
                self._add(path, text)


def _start(design: Design) -> Array:
    """Return the robot's values of the variables, clipped to the bounds; the centre if the file has no number."""
    document = document_of(design, None)
    low, high = design.bounds
    found = 0.5 * (low + high)
    for i, targets in enumerate(design.targets):
        now: Any = document.get(targets[0].change.path)
        if _is_number(now):
            found[i] = (now - targets[0].offset) / targets[0].factor
    return np.asarray(np.clip(found, low, high))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
