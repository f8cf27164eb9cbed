"""Assembly of a document from files and overrides: a scenario with its robot, or a robot."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from typing import Any, Literal

from cdpr.base.files import UnreadableError, read, seen_from
from cdpr.base.problems import Mark, Path, shown
from cdpr.config.document import Document
from cdpr.config.overrides import Change, Overrides, apply, read_overrides
from cdpr.config.problems import Problems
from cdpr.config.yaml_nodes import parse
from cdpr.log.files import name_from
from cdpr.plugins.registry import Registry
from cdpr.scenario import examples, nominal
from cdpr.scenario.choices import with_choices
from cdpr.scenario.initial_from_home import INITIAL, begin_at_home, forget
from cdpr.scenario.named_files import files_of_scenario
from cdpr.scenario.option_migration import Replacement
from cdpr.scenario.robot_schema import RobotSection

Kind = Literal["robot", "scenario", "study", "design"]

ROBOT_KEYS = {"cables", "platform"}
SCENARIO_KEYS = {"robot", "simulation", "initial", "trajectory"}
STUDY_KEYS = {"axes", "blocks"}
DESIGN_KEYS = {"vary", "goal", "goals"}
HINTS = {
    "robot": "use it in a scenario by 'robot: FILE': 'cdpr new scenario --robot FILE' writes one",
    "study": "cdpr study runs it",
    "design": "cdpr design runs it",
}
NAMED = {
    ("study", "scenario"): "use it in a study by 'scenario: FILE'",
    ("design", "robot"): "use it in a design by 'robot: FILE'",
    ("study", "design"): "cdpr design runs it; a study has 'axes', not 'vary'",
    ("design", "study"): "cdpr study runs it; a design has 'vary', not 'axes'",
}


def open_document(path: str, kind: Kind | None, problems: Problems, *, text: str | None = None) -> Document:
    """Read and parse a file, or `text`, and check its kind.

    A bare name that is not a file refers to an example.

    Raises:
        ScenarioError: if it cannot be used as this kind of file.
    """
    if text is None:
        path = examples.resolve(path, kind)
    try:
        document = parse(read(path) if text is None else text, path, problems)
    except UnreadableError as error:
        missing = "" if os.path.lexists(path) else examples.hint(path, kind)
        problems.add(Mark(path), (), f"{error}{missing}")
        document = None
    if document is None:
        problems.raise_any()
        raise AssertionError("a file without document has a problem")
    check_kind(document, kind, problems)
    return document


def check_kind(document: Document, kind: Kind | None, problems: Problems) -> None:
    """Raise ScenarioError if a document is of another kind."""
    found = kind_of(document)
    if found and found != kind and (kind or found in ("study", "design")):
        hint = NAMED.get((kind or "", found)) or HINTS.get(found, f"expected a {kind} file")
        problems.add(Mark(document.source), (), f"this is a {found} file; {hint}")
        problems.raise_any()


def kind_of(document: Document) -> Kind | None:
    """Return the kind of a file by its top-level keys, or None."""
    keys = set(document.data)
    if keys & DESIGN_KEYS:
        return "design"
    if keys & STUDY_KEYS:
        return "study"
    if keys & SCENARIO_KEYS:
        return "scenario"
    return "robot" if keys & ROBOT_KEYS else None


def change(
    document: Document, overrides: Overrides, chosen: list[Change], plugins: Registry, problems: Problems
) -> None:
    """Apply `chosen` plugins and `overrides` to the document of a scenario, and insert its robot file."""
    forget(document)
    nominal.rename_alternative(document, problems)
    document.data.setdefault("name", stem(document.source))
    replacement = Replacement(document, plugins)
    for given in with_choices([*chosen, *read_overrides(overrides, problems)], problems):
        each = replace(given, path=nominal.renamed(given.path))
        if each.path[0] == nominal.KEY:
            nominal.change_nominal(document, each, problems)
            continue
        if each.path[0] == "robot" and len(each.path) > 1:
            _include_robot(document, problems)
        if each.path[0] == INITIAL[0] and len(each.path) > 2:  # part of a value that may come from the home
            _include_robot(document, problems)
            begin_at_home(document, problems)
            document.filled.clear()
        apply(document, each, problems)
    replacement.settle()
    accept_absolute(document, list(files_of_scenario(document.data, plugins)))
    _include_robot(document, problems)
    begin_at_home(document, problems)


def accept_absolute(document: Document, names: Iterable[tuple[Path, str]]) -> None:
    """Make absolute file names that are given in Python relative to the document's folder; files must not have any."""
    for path, name in names:
        mark = document.mark(path)
        if os.path.isabs(name) and not mark.line and not mark.source.startswith("--"):
            document.own(path[:-1])[path[-1]] = seen_from(document.folder, name)


def _include_robot(document: Document, problems: Problems) -> None:
    """Replace the reference to a robot file by its content."""
    name: Any = document.data.get("robot")
    if name is None or isinstance(name, dict):
        return
    if isinstance(name, str):
        accept_absolute(document, [(("robot",), name)])
        name = document.data["robot"]
    other = Problems()
    robot = _read_robot(name, document, other)
    for problem in other.items:
        problems.add(problem.mark, ("robot", *problem.path), problem.text)
    problems.unreadable |= {("robot", *path) for path in other.unreadable}
    if robot is None:
        problems.unreadable.add(("robot",))
        document.put(("robot",), {}, document.mark(("robot",)))
    else:
        robot.data.setdefault("name", stem(robot.source))
        shape: Any = robot.get(("platform", "shape"))
        if isinstance(shape, dict) and isinstance(shape.get("mesh"), str):  # from now on relative to the scenario
            robot.own(("platform", "shape"))["mesh"] = os.path.join(os.path.dirname(name), shape["mesh"])
        document.graft(("robot",), robot)


def _read_robot(name: Any, document: Document, problems: Problems) -> Document | None:
    mark = document.mark(("robot",))
    if not isinstance(name, str) or not name:
        keys = ", ".join(RobotSection.model_fields)
        problems.add(mark, (), f"expected a file name or a mapping of {keys}, got {shown(name)}")
        return None
    if os.path.isabs(name):
        problems.add(mark, (), f"expected a file name relative to this file, got the absolute {shown(name)}")
        return None
    file = os.path.join(document.folder, name)
    try:
        given = document.files.get(os.path.abspath(file))
        robot = _parsed(read(file) if given is None else given.encode(), file, problems)
    except UnreadableError as error:
        problems.add(mark, (), str(error))
        return None
    if robot and kind_of(robot) == "scenario":
        problems.add(mark, (), f"'{file}' is a scenario; expected a robot file")
        return None
    return robot


def _parsed(content: bytes, file: str, problems: Problems) -> Document | None:
    """Parse a robot file; cached, because cases of a study use few of them."""
    document, found = _parse(content, file)
    problems.include(found)
    return document and document.copy()


@lru_cache(maxsize=64)
def _parse(content: bytes, file: str) -> tuple[Document | None, Problems]:
    problems = Problems()
    return parse(content, file, problems), problems


def stem(path: str) -> str:
    """Return a valid name from a file name."""
    return name_from(os.path.splitext(os.path.basename(path))[0])
