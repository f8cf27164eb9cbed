"""Loading of scenario and robot files, with the problems of all phases in one error."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from cdpr.base.errors import CdprError, ScenarioError
from cdpr.base.problems import Problem, shown
from cdpr.config.document import Document
from cdpr.config.overrides import Overrides, apply, read_overrides
from cdpr.config.problems import Problems
from cdpr.config.validation import report_nulls, validate
from cdpr.model import Robot
from cdpr.plugins.registry import Registry, registry
from cdpr.scenario import examples, plausible
from cdpr.scenario.checks import remember
from cdpr.scenario.choices import choices
from cdpr.scenario.from_python import document_of
from cdpr.scenario.named_files import files_of_robot
from cdpr.scenario.robot_checks import RobotChecks
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.scenario import Scenario, build_scenario
from cdpr.scenario.sound_robot import sound
from cdpr.scenario.source import Kind, accept_absolute, check_kind, kind_of, open_document, stem

Loaded = TypeVar("Loaded", Robot, Scenario)

# Remedies for an object in place of a file, by kind of file and class of the object.
REMEDIES = {
    ("scenario", "Robot"): "cdpr.Scenario(robot=robot, ...)",
    ("robot", "Scenario"): "use scenario.robot",
    ("study", "Scenario"): 'cdpr.study({"scenario": scenario, "axes": [...]}, out)',
    ("design", "Robot"): 'cdpr.design({"robot": robot, "vary": [...], ...}, out)',
}

Source = str | os.PathLike[str] | Mapping[str, Any]  # file, name of an example, or data with the keys of a file
AnyScenario = Source | Scenario
AnyRobot = Source | Scenario | Robot  # or the robot of a scenario


def load_scenario(
    path: AnyScenario,
    *,
    text: str | None = None,
    files: Mapping[str, str] | None = None,
    overrides: Overrides = (),
    backend: str | None = None,
    solver: str | None = None,
    controller: str | None = None,
    estimator: str | None = None,
    plugins: Registry | None = None,
    before: Scenario | None = None,
) -> Scenario:
    """Load and validate a scenario.

    Args:
        path: scenario file, name of an example, data with the keys of a scenario file, or a Scenario. With `text`, it
            is used only in messages and as the base of relative file names.
        text: YAML that is read instead of the file.
        files: texts that are read instead of referenced robot files, by absolute path.
        overrides: mapping of dotted keys to values ({"robot.cables[0].frame[2]": 3.5}), or list of texts as after
            `--set` ("simulation.duration=2").
        backend: name of the backend plugin.
        solver: name of the tension solver plugin. If it differs from the file's, the file's options of the old solver
            are dropped, listed in `Scenario.unused`, and reported in `Scenario.notes` and by the warning
            OptionsLeftOut.
        controller: name of the controller plugin; as for `solver`.
        estimator: name of the estimator plugin; as for `solver`.
        plugins: available plugins; the installed ones by default.
        before: scenario of the same file and plugins; sections that are equal are not validated again.

    Returns:
        The validated scenario.

    Raises:
        ScenarioError: with all problems.
        PluginError: if all problems are missing plugins.

    Example:
        >>> import cdpr
        >>> scenario = cdpr.load_scenario("caroca", overrides={"simulation.duration": 2.0})
        >>> scenario.simulation.duration
        2.0
    """
    _refuse_texts("load_scenario", path, text=text, files=files)
    names = {"backend": backend, "solver": solver, "controller": controller, "estimator": estimator}
    if isinstance(path, Scenario):
        return path.with_changes(overrides, **names, plugins=plugins)
    problems = Problems()
    document = _open(path, "scenario", problems, text)
    document.files = files or {}
    chosen = choices(names, problems)
    return build_scenario(document, overrides, chosen, plugins or registry(), problems, before)


def load_robot(path: Source | Robot, *, text: str | None = None, overrides: Overrides = ()) -> Robot:
    """Load and validate a robot file.

    Args:
        path: robot file, name of an example, data with the keys of a robot file, or a Robot.
        text: YAML that is read instead of the file.
        overrides: changes by dotted key, as for `load_scenario`, without the leading `robot.`.

    Returns:
        The validated robot, with frozen arrays (SI units, frames of `cdpr.model`).

    Raises:
        ScenarioError: with all problems.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca", overrides={"platform.mass": 120.0})
        >>> robot
        <Robot caroca: 8 cables, 3R3T, platform of 120 kg>
        >>> robot.tension_max.shape
        (8,)
    """
    _refuse_texts("load_robot", path, text=text)
    if isinstance(path, Robot):
        if not overrides:
            return sound(path)
        path = path.to_dict()
    problems = Problems()
    return _robot(_open(path, "robot", problems, text), overrides, problems)


def robot_or_scenario(source: AnyRobot) -> Robot | Scenario:
    """Return the robot or scenario of a file, an example, data, or the object itself; robots come before scenarios.

    Raises:
        ScenarioError: with all problems.
    """
    if isinstance(source, Robot | Scenario):
        return sound(source) if isinstance(source, Robot) else source
    if isinstance(source, Mapping):
        return load_any(source)
    if not isinstance(source, str | os.PathLike):
        kind = f"a {type(source).__name__}"
        raise ScenarioError([f"robot: expected a Robot, a file, an example's name, a dict or a Scenario, got {kind}"])
    return load_any(examples.resolve(os.fspath(source), "robot"))


def robot_of(source: AnyRobot) -> Robot:
    """Return the robot of a file, an example, data or a Scenario, or the Robot itself; files may be scenarios.

    Raises:
        ScenarioError: with all problems.
    """
    loaded = robot_or_scenario(source)
    return loaded.robot if isinstance(loaded, Scenario) else loaded


def file_name(path: object, kind: Kind | None = "scenario") -> str:
    """Return the name of a file of this kind; raise ScenarioError if `path` is not one."""
    if isinstance(path, (str, os.PathLike)):
        name = os.fspath(path)
        if "\n" in str(name) and not os.path.exists(name):
            remedy = f'for YAML text, use load_{kind or "scenario"}("NAME.yaml", text=...)'
            raise ScenarioError([f"expected the name of a file, got {shown(name)}, a text of several lines; {remedy}"])
        return name
    given = f"a {type(path).__name__}"
    own = {"scenario": " or a Scenario", "robot": " or a Robot"}.get(kind or "", "")
    allowed = f"a file, an example's name, a dict{own}" if own else "a file, an example's name or a dict"
    remedy = REMEDIES.get((kind or "", type(path).__name__), f"see load_{kind or 'scenario'}")
    raise ScenarioError([f"expected {allowed}, got {given}; {remedy}"])


def _refuse_texts(verb: str, source: object, **texts: object) -> None:
    """Raise CdprError if texts in place of files have another type, or are given although the source is no file."""
    for name, value in texts.items():
        if value is not None and not isinstance(value, Mapping if name == "files" else str | bytes):
            kind = "a mapping of file names to texts" if name == "files" else "a text"
            raise CdprError(f"{verb}({name}=): expected {kind}, got {shown(value)}")
        if value is not None and isinstance(source, Mapping | Robot | Scenario):
            kind = "dict" if isinstance(source, Mapping) else type(source).__name__
            raise CdprError(f"{verb}({name}=): replaces the text of a file, got a {kind} in place of a file name")


def _open(source: Source, kind: Kind | None, problems: Problems, text: str | None = None) -> Document:
    """Return the document of a file, an example or data."""
    if not isinstance(source, Mapping):
        return open_document(file_name(source, kind), kind, problems, text=text)
    document = document_of(source, study=kind in ("study", "design"))
    check_kind(document, kind, problems)
    document.data.setdefault("name", kind or kind_of(document) or "unnamed")
    return document


def open_with(
    source: Source, kind: Kind, key: str, load: Callable[[Any], Loaded], problems: Problems
) -> tuple[Document, Loaded | None]:
    """Return the document of a study or design, and what it refers to at `key`, if that is given in Python."""
    found = source.get(key) if isinstance(source, Mapping) else None
    loaded = None
    if isinstance(source, Mapping) and isinstance(found, Mapping | Robot | Scenario):
        loaded = load(found)
        source = {**source, key: loaded.name}
    return _open(source, kind, problems), loaded


def load_any(
    path: Source,
    *,
    overrides: Overrides = (),
    plugins: Registry | None = None,
    notes: list[str] | None = None,
    warnings: list[Problem] | None = None,
) -> Scenario | Robot:
    """Load and validate a file that is a scenario or a robot.

    `notes` receives `Scenario.notes`, and `warnings` receives `Scenario.warnings`.
    """
    problems = Problems()
    document = _open(path, None, problems)
    if kind_of(document) == "robot" or (isinstance(path, Mapping) and kind_of(document) is None):
        return _robot(document, overrides, problems, warnings)
    scenario = build_scenario(document, overrides, [], plugins or registry(), problems)
    if notes is not None:
        notes += scenario.notes
    if warnings is not None:
        warnings += scenario.warnings
    return scenario


def _robot(
    document: Document, overrides: Overrides, problems: Problems, warnings: list[Problem] | None = None
) -> Robot:
    document.data.setdefault("name", stem(document.source))
    for change in read_overrides(overrides, problems):
        apply(document, change, problems)
    accept_absolute(document, list(files_of_robot(document.data)))
    section = validate(RobotSection, document.data, document, problems)
    if section is not None:
        remember(section, document)
    report_nulls(document.data, (), document, problems)
    RobotChecks(document, problems).run(())
    problems.raise_any()
    assert section is not None
    robot = section.to_robot(document.folder)
    if warnings is not None:
        warnings += plausible.warnings(plausible.Setup(section, robot, (), document.data), document)
    return robot
