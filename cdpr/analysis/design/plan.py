"""Design plan: robot, variables, goals, and construction of candidates."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.analysis.design.evaluate import Figure, Place, Value, evaluate
from cdpr.analysis.design.schema import DesignFile
from cdpr.base.files import seen_from
from cdpr.base.problems import Path, dotted
from cdpr.config.document import Document
from cdpr.config.overrides import Change, apply
from cdpr.config.problems import Problems
from cdpr.config.yaml_text import dump
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.scenario.loader import load_robot
from cdpr.scenario.source import open_document, stem

SHAPE_FILE: Path = ("platform", "shape", "mesh")


@dataclass(frozen=True)
class Target:
    """Key that a variable sets."""

    change: Change  # path and position in the file; its value is unused
    factor: float
    offset: float


@dataclass(frozen=True, eq=False)
class Design:
    """Checked design.

    Attributes:
        name: name of the design.
        source: path of the study file, for messages.
        section: content of the study file.
        robot_file, robot_text: robot file and its content.
        robot: unchanged robot.
        targets: keys of each variable.
        figures: figures by name.
        place: poses at which they are evaluated.
        start: (n,), values of the variables in the unchanged robot, within the bounds.
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
        """Search algorithm."""
        usual = "nsga2" if len(self.section.wanted) > 1 else "differential_evolution"
        return self.section.optimizer.type or usual

    @property
    def digest(self) -> str:
        """Hash of the design, which identifies it."""
        given = self.section.model_dump(mode="json", by_alias=True) | {"name": ""}
        return hashlib.sha256(json.dumps([given, self.robot_text], sort_keys=True).encode()).hexdigest()

    def changes(self, values: Array | None) -> list[Change]:
        """Return the changes of the robot file for values (n,) of the variables; none for None, the unchanged robot."""
        if values is None:
            return []
        pairs = zip(self.targets, values.tolist(), strict=True)
        return [
            Change(target.change.path, target.factor * value + target.offset, target.change.mark)
            for targets, value in pairs
            for target in targets
        ]

    def candidate(self, values: Array | None) -> Robot:
        """Return the robot for values (n,).

        Raises:
            ScenarioError: if the robot is invalid.
        """
        return load_robot(self.robot_file, text=self.robot_text, overrides=self.changes(values))

    def measure(self, values: Array | None) -> dict[str, Value]:
        """Return all figures of a candidate.

        Raises:
            CdprError: if they cannot be computed.
        """
        robot = self.candidate(values)
        return {name: self._figure(each, robot, values) for name, each in self.figures.items()}

    def _figure(self, figure: Figure, robot: Robot, values: Array | None) -> Value:
        if figure.section.key is None:
            return evaluate(figure, robot, self.place)
        return Value(float(document_of(self, values).get(figure.path)))

    def robot_yaml(self, values: Array | None, folder: str, comment: str) -> str:
        """Return the robot file of a candidate, for use in another folder."""
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


def keys_text(keys: Sequence[Target]) -> str:
    """Return the keys that a variable sets, in words."""
    return ", ".join(("-" if each.factor < 0.0 else "") + dotted(each.change.path) for each in keys)
