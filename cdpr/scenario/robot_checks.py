"""Validation of a robot across sections: missing values, names, coincident cables and inconsistent limits."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from cdpr.base import tolerances
from cdpr.base.files import UnreadableError
from cdpr.base.problems import Path, shown
from cdpr.cables import MODELS, TORQUE, WINCH_TYPES, composed
from cdpr.cables.drum import RADIUS
from cdpr.cables.transmission import EFFICIENCY, GROWTH
from cdpr.config.document import Document
from cdpr.config.problems import Problems, exact
from cdpr.model.rotations import held_upright, multiply
from cdpr.scenario.appearance import AT_ORIGIN, FrameSection, ShapeSection
from cdpr.scenario.checks import Checks
from cdpr.scenario.limits_schema import COMMON_TENSION, TensionSection, limits
from cdpr.scenario.mesh import box_around
from cdpr.scenario.robot_schema import (
    CableSection,
    CablesSection,
    Home,
    PlatformSection,
    WinchSection,
    cable_name,
    moments_about,
    names_of_exports,
    of_a_body,
)
from cdpr.scenario.winch_kinds import Kind, kind_of, winch_path, wrong_brake, wrong_motor

EXAMPLES = {"winch": "{drum_radius: 0.05, inertia: 0.01}"}  # m, kg m^2; examples of required sections


def _needs(*kinds: Kind) -> dict[str, str]:
    """Return the required values of these cables (default: all), with descriptions."""
    needed = {}
    every = product(MODELS, WINCH_TYPES, (False, True))
    for chain in (composed(*kind) for kind in kinds or every):
        for number in (*chain.winch.required, *chain.span.numbers):
            reported = False
            if number.owner == "winch":
                needed["winch"] = "the winch"
                reported = WinchSection.model_fields[number.key].is_required()  # reported by that section
            if number.default is None and not reported:
                needed[f"{number.owner}.{number.file_key}"] = (
                    f"the {number.text.partition(',')[0]}{number.unit and f' ({number.unit})'}"
                )
    return needed


def _title(kind: Kind) -> str:
    model, winch, _ = kind
    return f"cable.model {model}" if winch == TORQUE else f"cable.model {model} with winch.type {winch}"


class RobotChecks(Checks):
    """Checks of the robot section at `root`; with `nominal`, of a robot with the values of another one."""

    def __init__(self, document: Document, problems: Problems, *, nominal: bool = False) -> None:
        super().__init__(document, problems)
        self._nominal = nominal

    def run(self, root: Path) -> None:
        """Report all problems."""
        self.root = root
        self._mesh()
        self.do(self._guide, self._model, self._winches, self._names, self._coincident, self._tensions)

    def _guide(self) -> None:
        """Check the inertia of a rotating platform, and the home pose against the guide."""
        dof = self.directions((*self.root, "dof"))
        if not dof:
            return
        platform, inertia = (*self.root, "platform"), (*self.root, "platform", "inertia")
        turns = [name for name in dof if name.startswith("r")]
        given = self.document.get(platform)
        if turns and isinstance(given, dict) and given.get("inertia") is None and not self.problems.has(inertia):
            self.add_problem(
                inertia, "required but not given: [ixx, iyy, izz, ixy, ixz, iyz] (kg m^2), because the platform rotates"
            )
        section = self.section(PlatformSection, platform)
        moments = section.inertia if section else None
        if moments is not None and not set(turns) <= set(moments_about(moments)):  # a zero moment is required
            try:
                of_a_body(moments)
            except ValueError as error:
                self.add_problem(inertia, f"{error} where it turns about {', '.join(turns)}")
        home = self.section(Home, (*self.root, "home"))
        base = self.section(FrameSection, (*self.root, "frame")) or AT_ORIGIN
        if home and not held_upright(dof, multiply(base.attitude, home.orientation.quaternion())):
            text = f"may differ from upright only about the free directions, {', '.join(dof)}"
            self.add_problem((*self.root, "home", "orientation"), text)

    def _mesh(self) -> None:
        """Check that the mesh file is readable."""
        path = (*self.root, "platform", "shape", "mesh")
        name = self.document.get(path)
        if self.section(ShapeSection, path[:-1]) is None or not isinstance(name, str):
            return
        if os.path.isabs(name):
            self.add_problem(path, f"expected a file name relative to this file, got the absolute {shown(name)}")
            return
        try:
            box_around(os.path.join(self.document.folder, name))
        except UnreadableError as error:
            self.add_problem(path, str(error))

    def _model(self) -> None:
        """Check that all values required by the cable models are present; sections check their values."""
        at = (*self.root, "cable")
        given = self.document.get((*self.root, "cables"))
        wrong = self.document.get(at) is not None and self.section(CablesSection, at) is None
        if wrong or not isinstance(given, list):
            return
        for need, words in _needs().items():
            shared = need.split(".")
            name = need.removeprefix("cable.")
            lacking: dict[str, list[int]] = {}
            for i, cable in enumerate(given):
                if isinstance(cable, dict) and self._lacks(cable, *shared):
                    kind = kind_of(self.document, self.root, cable)
                    if kind is not None and need in _needs(kind):
                        lacking.setdefault(_title(kind), []).append(i)
            for model, places in lacking.items():
                names = [str(given[i].get("name") or f"cable_{i + 1}") for i in places]
                listed = ", ".join([*names[:5], *(["..."] if len(names) > 5 else [])])
                such = f", such as {need}: {EXAMPLES[need]}" if need in EXAMPLES else ""
                text = f"{model} needs {words} of each cable: give {need} for all{such}, or {name} of cable {listed}"
                self.problems.add(self.document.key_mark(at), self.root, text)
        for i, cable in enumerate(given):
            kind = kind_of(self.document, self.root, cable)
            if kind is not None and kind[1] != TORQUE and not composed(*kind).stretches:
                self.add_problem(
                    (*winch_path(self.root, cable, i), "type"),
                    f"{kind[1]} needs a cable that stretches, got cable.model {kind[0]}: its length would be held "
                    "exactly, whatever the tension; set cable.model: elastic and cable.axial_stiffness, or "
                    "type: torque",
                )
                return
        self._transmissions(given)

    def _transmissions(self, given: list[Any]) -> None:
        """Check the numbers of winches that depend on others."""
        pushes = self.document.get((*self.root, "unilateral")) is False
        for i, cable in enumerate(given):
            if pushes and self._rubs(cable, i):
                return
            if kind_of(self.document, self.root, cable) is None:
                continue
            path = winch_path(self.root, cable, i)
            winch = self.document.get(path)
            if not isinstance(winch, dict):
                continue
            if winch.get(GROWTH.key) and winch.get(RADIUS.key) is None:
                text = f"needs {RADIUS.name}, the radius (m) with the platform at the home pose"
                self.add_problem((*path, GROWTH.key), text)
                return
            if pushes and winch.get(EFFICIENCY.key, 1.0) != 1.0:
                text = "not supported for rigid legs, which push (unilateral: false): remove one of both"
                self.add_problem((*path, EFFICIENCY.key), text)
                return

    def _rubs(self, cable: Any, i: int) -> bool:
        """Report friction on the exit of a leg that pushes; return True if there is any."""
        own = isinstance(cable, dict) and isinstance(cable.get("exit"), dict)
        path = (*self.root, *(("cables", i) if own else ("cable",)), "exit")
        leads = self.document.get(path)
        for key in ("friction", "bearing_friction") if isinstance(leads, dict) else ():
            if leads.get(key):
                text = "not supported for rigid legs, which push (unilateral: false): remove one of both"
                self.add_problem((*path, key), text)
                return True
        return False

    def _winches(self) -> None:
        """Check brakes and motors of the winches."""
        given = self.document.get((*self.root, "cables"))
        if not isinstance(given, list):
            return
        users: dict[Path, list[Kind]] = {}
        for i, cable in enumerate(given):
            if (kind := kind_of(self.document, self.root, cable)) is not None:
                users.setdefault(winch_path(self.root, cable, i), []).append(kind)
        for path, kinds in users.items():
            winch = self.document.get(path)
            if isinstance(winch, dict):
                for key, text in (*wrong_brake(winch, kinds), *wrong_motor(winch)):
                    self.problems.add(self.document.key_mark((*path, key)), (*path, key), text)

    def _lacks(self, cable: dict[str, Any], owner: str, key: str = "") -> bool:
        """Return True if a cable has this value or section neither itself nor from the common section."""
        common = self.document.get((*self.root, owner))
        if owner == "winch":
            winch = common if cable.get(owner) is None else cable[owner]
            return winch is None if not key else isinstance(winch, dict) and winch.get(key) is None
        return cable.get(key) is None and (common or {}).get(key) is None

    def _names(self) -> None:
        first: dict[str, int] = {}
        for i, cable in self.cables(self.root):
            name = cable_name(cable, i)
            if name in first:
                text = f"'{name}' is the name of cables[{first[name]}] too; names must differ"
                self.add_problem((*self.root, "cables", i, "name"), text)
            first.setdefault(name, i)
        tools = self.document.get((*self.root, "platform", "tools"))
        platform = self.section(PlatformSection, (*self.root, "platform")) if tools else None
        reserved = names_of_exports(first)
        for name in platform.tools if platform else ():
            if name in reserved:
                text = "frames, links and sites of exports have this name already; choose another name"
                self.add_problem((*self.root, "platform", "tools", name), text)

    def _coincident(self) -> None:
        cables = list(self.cables(self.root))
        anchors = np.array([[cable.frame, cable.platform] for _, cable in cables]).reshape(-1, 2, 3)
        distances = np.linalg.norm(anchors[:, None] - anchors[None], axis=3)  # (m, m, 2), m
        same = np.all(distances < tolerances.LENGTH, axis=2)
        for b in range(1, len(cables)):
            if same[b, :b].any():
                other = f"cables[{cables[int(np.argmax(same[b, :b]))][0]}]"
                text = f"coincides with {other} at both ends, so they are one cable (sharing one end is fine)"
                self.add_problem((*self.root, "cables", cables[b][0]), text)

    def _tensions(self) -> None:
        common = self.section(TensionSection, (*self.root, "tension"))
        given = self.document.get((*self.root, "cables"))
        if common is None or not isinstance(given, list) or not self._one_per_cable(common, len(given)):
            return
        unilateral = self.document.get((*self.root, "unilateral")) is not False
        reported: set[Path] = set()  # a common limit is reported once
        for i, cable in self.cables(self.root):
            found = [*self._limits(common, cable, i, unilateral), *([] if unilateral else self._legs(cable))]
            for path, text in found:
                if path not in reported:
                    reported.add(path)
                    self.add_problem(path, text)

    def _one_per_cable(self, common: TensionSection, count: int) -> bool:
        right = True
        for name, value in (("min", common.min), ("max", common.max)):
            if isinstance(value, list) and len(value) != count:
                text = f"expected {count} numbers (N), one per cable, got {len(value)}"
                self.add_problem((*self.root, "tension", name), text)
                right = False
        return right

    def _limits(
        self, common: TensionSection, cable: CableSection, i: int, unilateral: bool
    ) -> Iterator[tuple[Path, str]]:
        low, high = limits(common, cable.tension, i)
        own = cable.tension or COMMON_TENSION
        at_min = self._written("min", common.min, own.min, i)
        at_max = self._written("max", common.max, own.max, i)
        if unilateral and low < 0:
            reason = "a cable cannot push (rigid legs: unilateral: false)"
            yield at_min, f"must be at least 0 (N), got {exact(low)}: {reason}"
        if high <= 0:
            yield at_max, f"must be greater than 0 (N), got {exact(high)}: a cable must be able to pull"
        elif low > high:
            yield at_min, f"must not exceed the highest tension of this cable, {exact(high)} (N), got {exact(low)}"

    def _legs(self, cable: CableSection) -> Iterator[tuple[Path, str]]:
        model = cable.model or self.document.get((*self.root, "cable", "model"))
        if isinstance(model, str) and model in MODELS and MODELS[model].span.bends:
            text = (
                f"rigid legs push, and cables of the model {model} cannot: remove unilateral, or choose another model"
            )
            yield (*self.root, "unilateral"), text

    def _written(self, name: str, common: float | list[float], own: float | None, i: int) -> Path:
        """Return the path at which a limit of cable i is given."""
        if own is not None:
            return (*self.root, "cables", i, "tension", name)
        return (*self.root, "tension", name, *([i] if isinstance(common, list) else []))
