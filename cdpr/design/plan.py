"""A design: a robot, what of it is varied, what for, and what a candidate of it is."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.design.evaluate import Figure, Place, Value, evaluate
from cdpr.design.schema import DesignFile
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.problems import Path, dotted
from cdpr.scenario.document import Document
from cdpr.scenario.files import seen_from
from cdpr.scenario.loader import load_robot
from cdpr.scenario.overrides import Change, apply
from cdpr.scenario.problems import Problems
from cdpr.scenario.source import open_document, stem
from cdpr.scenario.yaml_text import dump

SHAPE_FILE: Path = ("platform", "shape", "mesh")


@dataclass(frozen=True)
class Target:
    """A key that a variable sets."""

    change: Change  # its path, and where it stands; the value does not count
    factor: float
    offset: float


@dataclass(frozen=True, eq=False)
class Design:
    """A checked design.

    Attributes:
        name: of it.
        source: path of its file, for messages.
        section: what the file says.
        robot_file, robot_text: the robot file that it names, and what that holds.
        robot: as the file has it.
        targets: keys of each variable.
        figures: by their names.
        place: where they are looked at.
        start: (n,) values of the variables, of the robot as it is, within the bounds.
    """

    name: str
    source: str
    section: DesignFile
    robot_file: str
    robot_text: str
    robot: Robot
    targets: tuple[tuple[Target, ...], ...]
    figures: dict[str, Figure]
    place: Place
    start: Array

    def __repr__(self) -> str:
        return f"<Design {self.name}: {len(self.targets)} variables, {len(self.section.wanted)} goals>"

    @property
    def labels(self) -> list[str]:
        """Names of the variables."""
        return [variable.label for variable in self.section.vary]

    @property
    def bounds(self) -> Array:
        """Lowest and highest values of the variables, (2, n)."""
        return np.array([variable.bounds for variable in self.section.vary]).T

    @property
    def search(self) -> str:
        """What looks for candidates."""
        usual = "nsga2" if len(self.section.wanted) > 1 else "differential_evolution"
        return self.section.optimizer.type or usual

    @property
    def digest(self) -> str:
        """Identity of the design: what is computed."""
        given = self.section.model_dump(mode="json", by_alias=True) | {"name": ""}
        return hashlib.sha256(json.dumps([given, self.robot_text], sort_keys=True).encode()).hexdigest()

    def changes(self, values: Array | None) -> list[Change]:
        """Return what values (n,) of the variables set in the robot file; nothing of None, the robot as it is."""
        if values is None:
            return []
        pairs = zip(self.targets, values.tolist(), strict=True)
        return [
            Change(target.change.path, target.factor * value + target.offset, target.change.mark)
            for targets, value in pairs
            for target in targets
        ]

    def candidate(self, values: Array | None) -> Robot:
        """Return the robot of values (n,). Raises ScenarioError where there is no such robot."""
        return load_robot(self.robot_file, text=self.robot_text, overrides=self.changes(values))

    def measure(self, values: Array | None) -> dict[str, Value]:
        """Return all figures of a candidate. Raises CdprError where they cannot be told of it."""
        robot = self.candidate(values)
        return {name: self._figure(each, robot, values) for name, each in self.figures.items()}

    def _figure(self, figure: Figure, robot: Robot, values: Array | None) -> Value:
        if figure.section.key is None:
            return evaluate(figure, robot, self.place)
        return Value(float(document_of(self, values).get(figure.path)))

    def robot_yaml(self, values: Array | None, folder: str, comment: str) -> str:
        """Return the robot file of a candidate, to stand in another folder."""
        document = document_of(self, values)
        mesh = document.get(SHAPE_FILE)
        if isinstance(mesh, str):
            document.get(SHAPE_FILE[:-1])["mesh"] = seen_from(folder, os.path.join(document.folder, mesh))
        return f"# {comment}\n{dump(document.data)}"


def document_of(design: Design, values: Array | None) -> Document:
    """Return the robot file with the changes of a candidate."""
    problems = Problems()
    document = open_document(design.robot_file, "robot", problems, text=design.robot_text)
    document.data.setdefault("name", stem(document.source))
    for change in design.changes(values):
        apply(document, change, problems)
    problems.raise_any()
    return document


def told(keys: Sequence[Target]) -> str:
    """Return which keys a variable sets, in words."""
    return ", ".join(("-" if each.factor < 0.0 else "") + dotted(each.change.path) for each in keys)
