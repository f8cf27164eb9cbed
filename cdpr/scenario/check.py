"""Validation of a scenario's document: the sections, the plugins' options, and the checks across sections."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from cdpr.config.document import Document, same
from cdpr.config.problems import Problems
from cdpr.config.validation import report_nulls, validate
from cdpr.plugins.registry import Registered, Registry, Role
from cdpr.scenario import nominal
from cdpr.scenario.changes import Options
from cdpr.scenario.checks import remember
from cdpr.scenario.choices import CORE_KEYS
from cdpr.scenario.event_checks import EventChecks
from cdpr.scenario.events import ScenarioEvent
from cdpr.scenario.motions import Motion
from cdpr.scenario.options import OptionsReader
from cdpr.scenario.robot_checks import RobotChecks
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.run_checks import RunChecks
from cdpr.scenario.schema import ScenarioSection

# Sections that do not affect the motion and its checks.
BESIDES = {"controller", "solver", "estimator", "backend_options"}
# Sections that determine the options of backends.
BACKENDS = {"simulation", "backend_options"}


@dataclass(frozen=True)
class Checked:
    """Valid content of a scenario's document.

    Attributes:
        document: the document, with its robot.
        plugins: available plugins.
        sections: the sections as in the file, with defaults.
        motion: desired motion, with its files loaded.
        events: events with their files loaded.
        controller_options: options of the controller, an instance of its plugin's model.
        solver_options: the same for the tension solver.
        estimator_options: the same for the estimator; None without one.
        backend_options: the same for backends, by name.
        nominal: section of the nominal robot; None if it equals the robot.
        twin: document of the nominal robot; None likewise.
        unchanged: sections that are equal in the scenario before.
    """

    document: Document
    plugins: Registry
    sections: ScenarioSection
    motion: Motion
    events: list[ScenarioEvent]
    controller_options: BaseModel
    solver_options: BaseModel
    estimator_options: BaseModel | None
    backend_options: Mapping[str, BaseModel]
    nominal: RobotSection | None
    twin: Document | None
    unchanged: frozenset[str]

    def options(self) -> Options:
        """Return the initial options of controller and solver, which can be changed."""
        return _options(self.plugins, self.sections, self.controller_options, self.solver_options, self.document)


def check(document: Document, plugins: Registry, problems: Problems, before: Checked | None = None) -> Checked:
    """Validate a document; raise ScenarioError or PluginError with all `problems`.

    If the document is a copy of that of `before`, unchanged sections are not validated again.
    """
    unchanged = frozenset[str]() if before is None or problems.items else _unchanged(document, before.document)
    data, options = split(document.data)
    old, _ = split(before.document.data) if before else ({}, {})
    for each in (data, old):
        if each.get(nominal.KEY) is not None:
            del each[nominal.KEY]
    reader = OptionsReader(document, problems, plugins)
    known_before = (before.sections, old) if before else None
    sections = validate(ScenarioSection, data, document, problems, known_before, reader.places)
    if sections is not None:
        remember(sections, document)
    report_nulls(data, (), document, problems, old)
    if "robot" not in unchanged:
        RobotChecks(document, problems).run(("robot",))
    motion_known = unchanged >= ScenarioSection.model_fields.keys() - BESIDES
    motion = before.motion if before and motion_known else RunChecks(document, problems).run()
    known = unchanged if before and plugins is before.plugins else frozenset[str]()
    controller_options = before.controller_options if before and "controller" in known else None
    controller_options = controller_options or reader.of_section("controller", options.get("controller", {}))
    solver_options = before.solver_options if before and "solver" in known else None
    solver_options = solver_options or reader.of_section("solver", options.get("solver", {}))
    estimator_options = None
    if document.data.get("estimator") is not None:
        estimator_options = before.estimator_options if before and "estimator" in known else None
        estimator_options = estimator_options or reader.of_section("estimator", options.get("estimator", {}))
    backend_options = before.backend_options if before and known >= BACKENDS else reader.of_backends()
    in_force = None
    if sections is not None and controller_options is not None and solver_options is not None:
        in_force = _options(plugins, sections, controller_options, solver_options, document)
    events = EventChecks(document, problems, in_force).run()
    nominal_section, twin = _nominal(document, problems)
    problems.raise_any()
    assert sections is not None
    assert controller_options is not None
    assert solver_options is not None
    return Checked(
        document=document,
        plugins=plugins,
        sections=sections,
        motion=motion or sections.trajectory,
        events=events,
        controller_options=controller_options,
        solver_options=solver_options,
        estimator_options=estimator_options,
        backend_options=backend_options,
        nominal=nominal_section,
        twin=twin,
        unchanged=unchanged,
    )


def _unchanged(document: Document, before: Document) -> frozenset[str]:
    """Return the sections that are equal, or missing, in both."""
    keys = ScenarioSection.model_fields.keys() | document.data.keys() | before.data.keys()
    return frozenset(key for key in keys if same(document.data.get(key), before.data.get(key)))


def _nominal(document: Document, problems: Problems) -> tuple[RobotSection | None, Document | None]:
    """Return the nominal robot and its scenario, validated as both; None if there is none."""
    found = Problems(unreadable=set(problems.unreadable))
    twin = None if ("robot",) in found.unreadable else nominal.nominal_document(document, found)
    sections = None
    if twin is not None:
        data, _ = split(twin.data)
        sections = validate(ScenarioSection, data, twin, found)
        if sections is not None:
            remember(sections, twin)
        report_nulls(data, (), twin, found)
        RobotChecks(twin, found, nominal=True).run(("robot",))
        RunChecks(twin, found).start()
        EventChecks(twin, found).run()
    nominal.add_problems(found, problems)
    return sections.robot if sections else None, twin


def _options(
    plugins: Registry, sections: ScenarioSection, controller: BaseModel, solver: BaseModel, document: Document
) -> Options:
    chosen: dict[Role, Registered] = {
        "controller": plugins.get("controller", sections.controller.type),
        "solver": plugins.get("solver", sections.solver.type),
    }
    return Options(chosen, {"controller": controller, "solver": solver}, document.folder)


def split(data: dict[str, Any]) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    """Separate the plugins' options, which are validated by the plugins' models."""
    own = dict(data)
    options: dict[str, dict[str, Any]] = {}
    for section, core in CORE_KEYS.items():
        given = data.get(section)
        if isinstance(given, dict):
            own[section] = {key: value for key, value in given.items() if key in core}
            options[section] = {key: value for key, value in given.items() if key not in core}
    backends = data.get("backend_options")
    if isinstance(backends, dict):
        own["backend_options"] = {name: {} if isinstance(given, dict) else given for name, given in backends.items()}
    return own, options
