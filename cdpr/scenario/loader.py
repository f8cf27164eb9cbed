"""From files to checked scenarios and robots, with every problem of every phase in one error."""

from __future__ import annotations

import os
import re
from functools import lru_cache
from typing import Any, Literal

from cdpr.errors import ScenarioError
from cdpr.model import Robot
from cdpr.plugins.registry import Registry, registry
from cdpr.scenario import examples
from cdpr.scenario.build import build_robot, build_scenario
from cdpr.scenario.document import Document
from cdpr.scenario.files import UnreadableError, read
from cdpr.scenario.overrides import Change, Overrides, apply, choices, read_overrides
from cdpr.scenario.problems import Mark, Problems, shown
from cdpr.scenario.replaced import Replacement
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.scenario import Scenario
from cdpr.scenario.yaml_nodes import parse

Kind = Literal["robot", "scenario", "study"]

ROBOT_KEYS = {"cables", "platform"}
SCENARIO_KEYS = {"robot", "simulation", "initial", "trajectory"}
STUDY_KEYS = {"axes", "blocks"}
HINTS = {"robot": "a scenario names it with 'robot: FILE'", "study": "cdpr study runs it"}


def load_scenario(
    path: str | os.PathLike[str],
    *,
    text: str | None = None,
    overrides: Overrides = (),
    backend: str | None = None,
    solver: str | None = None,
    controller: str | None = None,
    plugins: Registry | None = None,
) -> Scenario:
    """Load and check a scenario.

    `overrides` maps dotted keys to values ({"robot.cables[0].frame[2]": 3.5}) or lists texts as typed after
    `--set` ("simulation.duration=2"). `backend`, `solver` and `controller` choose plugins; where that changes
    the type of the solver or controller, those options of the old one that the new one does not take are left
    out and listed in `Scenario.unused`; `Scenario.notes` says what was kept, and warns. With `text`, that is read
    in place of the file; `path` then only names it in messages, and its folder is where relative file names start.
    `plugins` are the installed ones unless given.

    Raises ScenarioError with all problems, or PluginError if nothing but plugins is missing.
    """
    problems = Problems()
    document = open_document(_name(path), "scenario", problems, text=text)
    chosen = choices({"backend": backend, "solver": solver, "controller": controller}, problems)
    return _scenario(document, overrides, chosen, plugins or registry(), problems)


def load_robot(path: str | os.PathLike[str], *, text: str | None = None, overrides: Overrides = ()) -> Robot:
    """Load and check a robot file; arguments and errors as for `load_scenario`."""
    problems = Problems()
    return _robot(open_document(_name(path), "robot", problems, text=text), overrides, problems)


def _name(path: object) -> str:
    """Return the name of a file."""
    if isinstance(path, (str, os.PathLike)):
        return os.fspath(path)
    text = f"a file name is expected, not {type(path).__name__}: content goes into `text`, as YAML; see load_scenario"
    raise ScenarioError([text])


def load_any(
    path: str | os.PathLike[str],
    *,
    overrides: Overrides = (),
    plugins: Registry | None = None,
    notes: list[str] | None = None,
) -> Scenario | Robot:
    """Load and check a file that may be a scenario or a robot; `notes` takes what `Scenario.notes` would hold."""
    problems = Problems()
    document = open_document(_name(path), None, problems)
    loaded: Scenario | Robot
    if _kind(document) == "robot":
        loaded = _robot(document, overrides, problems)
    else:
        loaded = _scenario(document, overrides, [], plugins or registry(), problems)
    if notes is not None:
        notes += [*document.notes, *document.warnings]
    return loaded


def change_scenario(
    scenario: Scenario,
    overrides: Overrides,
    backend: str | None,
    solver: str | None,
    controller: str | None,
    plugins: Registry,
) -> Scenario:
    """Return a copy with changes, checked like a file."""
    problems = Problems()
    chosen = choices({"backend": backend, "solver": solver, "controller": controller}, problems)
    return _scenario(scenario._document.copy(), overrides, chosen, plugins, problems)


def _scenario(
    document: Document, overrides: Overrides, chosen: list[Change], plugins: Registry, problems: Problems
) -> Scenario:
    document.data.setdefault("name", stem(document.source))
    replacement = Replacement(document, plugins)
    for change in [*chosen, *read_overrides(overrides, problems)]:
        if change.path[0] == "robot" and len(change.path) > 1:
            _include_robot(document, problems)
        apply(document, change, problems)
    replacement.settle()
    _include_robot(document, problems)
    return build_scenario(document, plugins, problems)


def _robot(document: Document, overrides: Overrides, problems: Problems) -> Robot:
    document.data.setdefault("name", stem(document.source))
    for change in read_overrides(overrides, problems):
        apply(document, change, problems)
    return build_robot(document, problems)


def open_document(path: str, kind: Kind | None, problems: Problems, *, text: str | None = None) -> Document:
    """Read and parse the file that the user named, or `text`; raises if it cannot be used as this kind of file.

    A bare name that is no file is that of an example.
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
    found = _kind(document)
    if found and found != kind and (kind or found == "study"):
        expected = "a study names it with 'scenario: FILE'" if kind == "study" else "a robot file is expected"
        problems.add(Mark(path), (), f"this is a {found} file; {HINTS.get(found, expected)}")
        problems.raise_any()
    return document


def _kind(document: Document) -> Kind | None:
    """Tell what a file is by its top-level keys; None where they do not tell."""
    keys = set(document.data)
    if keys & STUDY_KEYS:
        return "study"
    if keys & SCENARIO_KEYS:
        return "scenario"
    return "robot" if keys & ROBOT_KEYS else None


def _include_robot(document: Document, problems: Problems) -> None:
    """Replace the name of a robot file by what the file holds."""
    name: Any = document.data.get("robot")
    if name is None or isinstance(name, dict):
        return
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
        document.graft(("robot",), robot)


def _read_robot(name: Any, document: Document, problems: Problems) -> Document | None:
    mark = document.mark(("robot",))
    if not isinstance(name, str) or not name:
        keys = ", ".join(RobotSection.model_fields)
        problems.add(mark, (), f"a file name or a mapping of {keys} expected, got {shown(name)}")
        return None
    if os.path.isabs(name):
        problems.add(mark, (), f"a file name relative to this file is expected, got the absolute {shown(name)}")
        return None
    file = os.path.join(document.folder, name)
    try:
        robot = _parsed(read(file), file, problems)
    except UnreadableError as error:
        problems.add(mark, (), str(error))
        return None
    if robot and _kind(robot) == "scenario":
        problems.add(mark, (), f"'{file}' is a scenario; a robot file is expected")
        return None
    return robot


def _parsed(content: bytes, file: str, problems: Problems) -> Document | None:
    """Parse a robot file; each case of a study asks for one of few."""
    document, found = _parse(content, file)
    problems.include(found)
    return document and document.copy()


@lru_cache(maxsize=64)
def _parse(content: bytes, file: str) -> tuple[Document | None, Problems]:
    problems = Problems()
    return parse(content, file, problems), problems


def stem(path: str) -> str:
    """Make a name of a file's name."""
    stem = os.path.splitext(os.path.basename(path))[0]
    return re.sub(r"[^\w.-]+", "_", stem).lstrip(".-")[:64] or "unnamed"
