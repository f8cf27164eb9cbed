"""From files to checked scenarios and robots, with every problem of every phase in one error."""

from __future__ import annotations

import json
import os
import re
from typing import Any, Literal, TypeVar

from pydantic import BaseModel, ValidationError

from cdpr.errors import PluginError
from cdpr.model import Robot
from cdpr.plugins.registry import Registry, Role, registry
from cdpr.scenario.checks import Checker
from cdpr.scenario.document import Document
from cdpr.scenario.files import UnreadableError, read
from cdpr.scenario.messages import explain
from cdpr.scenario.options import read_options
from cdpr.scenario.overrides import CORE_KEYS, Overrides, apply, choices, read_overrides
from cdpr.scenario.problems import Mark, Path, Problems
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.scenario import Scenario
from cdpr.scenario.schema import ScenarioSection
from cdpr.scenario.trajectory_schema import complete
from cdpr.scenario.yaml_nodes import parse

Kind = Literal["robot", "scenario"]

M = TypeVar("M", bound=BaseModel)


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

    `overrides` maps dotted keys to values ({"robot.cables[0].frame[2]": 3.5}) or lists texts as typed after `--set`
    ("simulation.duration=2"). `backend`, `solver` and `controller` choose plugins; where that changes the type of the
    solver or controller, the options of the old one are left out and listed in `Scenario.unused`. With `text`, that is
    read in place of the file, and `path` only names it and is where relative file names start. `plugins` are the
    installed ones unless given.

    Raises ScenarioError with all problems, or PluginError if nothing but plugins is missing.
    """
    document = _open(os.fspath(path), text, "scenario")
    return build(document, overrides, backend, solver, controller, plugins or registry())


def load_robot(path: str | os.PathLike[str], *, text: str | None = None, overrides: Overrides = ()) -> Robot:
    """Load and check a robot file; arguments and errors as for `load_scenario`."""
    return _build_robot(_open(os.fspath(path), text, "robot"), overrides)


def load_any(
    path: str | os.PathLike[str], *, overrides: Overrides = (), plugins: Registry | None = None
) -> Scenario | Robot:
    """Load and check a file that may be a scenario or a robot."""
    document = _open(os.fspath(path), None, None)
    if _kind(document) == "robot":
        return _build_robot(document, overrides)
    return build(document, overrides, None, None, None, plugins or registry())


def build(
    document: Document,
    overrides: Overrides,
    backend: str | None,
    solver: str | None,
    controller: str | None,
    plugins: Registry,
) -> Scenario:
    """Change `document` as asked, check it and make the scenario."""
    problems = Problems()
    document.data.setdefault("name", _stem(document.source))
    for change in [*choices(backend, solver, controller), *read_overrides(overrides, problems)]:
        if change.path[0] == "robot" and len(change.path) > 1:
            _include_robot(document, problems)
        apply(document, change, problems)
    _include_robot(document, problems)

    data, options = _split(document)
    sections = _validate(ScenarioSection, data, document, problems)
    _report_nulls(data, (), document, problems)
    checker = Checker(document, problems)
    checker.robot(("robot",))
    checker.scenario()
    controller_options = _options("controller", options, document, problems, plugins)
    solver_options = _options("solver", options, document, problems, plugins)
    backend_options = _backend_options(document, problems, plugins)
    problems.raise_any()

    assert sections is not None
    assert controller_options is not None
    assert solver_options is not None
    sections = sections.model_copy(update={"trajectory": complete(sections.trajectory, sections.initial)})
    return Scenario(
        sections=sections,
        robot=sections.robot.to_robot(),
        controller_options=controller_options,
        solver_options=solver_options,
        source=document.source,
        unused=(*(f"robot.{key}" for key in sections.robot.unused()), *document.dropped),
        _backend_options=backend_options,
        _document=document,
        _plugins=plugins,
    )


def _build_robot(document: Document, overrides: Overrides) -> Robot:
    problems = Problems()
    document.data.setdefault("name", _stem(document.source))
    for change in read_overrides(overrides, problems):
        apply(document, change, problems)
    section = _validate(RobotSection, document.data, document, problems)
    _report_nulls(document.data, (), document, problems)
    Checker(document, problems).robot(())
    problems.raise_any()
    assert section is not None
    return section.to_robot()


def _open(path: str, text: str | None, kind: Kind | None) -> Document:
    """Read and parse the file that the user named."""
    problems = Problems()
    content: bytes | str | None = text
    if content is None:
        try:
            content = read(path)
        except UnreadableError as error:
            problems.add(Mark(path), (), str(error))
            problems.raise_any()
    assert content is not None
    document = parse(content, path, problems)
    if document and kind and _kind(document) != kind:
        hint = {"robot": "a scenario names it with 'robot: FILE'", "scenario": "a robot file is expected"}
        problems.add(Mark(path), (), f"this is a {_kind(document)} file; {hint[_kind(document)]}")
        problems.raise_any()
    ...
