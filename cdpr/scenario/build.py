"""From a document to a checked scenario or robot."""

from __future__ import annotations

import json
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from cdpr.model import Robot
from cdpr.plugins.registry import Registry
from cdpr.scenario.angle_checks import AngleChecks
from cdpr.scenario.document import Document
from cdpr.scenario.event_checks import EventChecks, beyond
from cdpr.scenario.messages import explain
from cdpr.scenario.options import OptionsReader
from cdpr.scenario.overrides import CORE_KEYS
from cdpr.scenario.problems import Path, Problems
from cdpr.scenario.robot_checks import RobotChecks
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.run_checks import RunChecks
from cdpr.scenario.scenario import Scenario
from cdpr.scenario.schema import ScenarioSection

M = TypeVar("M", bound=BaseModel)


def build_robot(document: Document, problems: Problems) -> Robot:
    """Check the document of a robot file and make the robot."""
    section = validate(RobotSection, document.data, document, problems)
    report_nulls(document.data, (), document, problems)
    RobotChecks(document, problems).run(())
    AngleChecks(document, problems).run()
    problems.raise_any()
    assert section is not None
    return section.to_robot()


def build_scenario(document: Document, plugins: Registry, problems: Problems) -> Scenario:
    """Check the document of a scenario, its robot already in it, and make the scenario."""
    data, options = _split(document.data)
    sections = validate(ScenarioSection, data, document, problems)
    report_nulls(data, (), document, problems)
    RobotChecks(document, problems).run(("robot",))
    motion = RunChecks(document, problems).run()
    EventChecks(document, problems).run()
    AngleChecks(document, problems).run()
    reader = OptionsReader(document, problems, plugins)
    controller_options = reader.of_section("controller", options.get("controller", {}))
    solver_options = reader.of_section("solver", options.get("solver", {}))
    backend_options = reader.of_backends()
    problems.raise_any()
    assert sections is not None
    assert controller_options is not None
    assert solver_options is not None
    robot = sections.robot.named()
    trajectory = (motion or sections.trajectory).complete(sections.initial)
    names = [cable.name for cable in robot.cables]
    events = [event.named(names) for event in sections.events]
    return Scenario(
        sections=sections.model_copy(
            update={
                "robot": robot,
                "trajectory": trajectory,
                "controlled": sections.controlled or robot.dof,
                "events": events,
            }
        ),
        robot=robot.to_robot(),
        controller_options=controller_options,
        solver_options=solver_options,
        source=document.source,
        unused=(
            *(f"robot.{key}" for key in robot.unused()),
            *document.dropped,
            *(f"events[{i}]" for i in beyond(events, sections.simulation)),
        ),
        notes=(*document.notes, *document.warnings),
        _backend_options=backend_options,
        _document=document,
        _plugins=plugins,
    )


def _split(data: dict[str, Any]) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    """Take the plugins' options out: they are checked by the plugins' models, not by ours."""
    own = dict(data)
    options: dict[str, dict[str, Any]] = {}
    for section, core in CORE_KEYS.items():
        given = data.get(section, {})
        if isinstance(given, dict):
            own[section] = {key: value for key, value in given.items() if key in core}
            options[section] = {key: value for key, value in given.items() if key not in core}
    backends = data.get("backend_options")
    if isinstance(backends, dict):
        own["backend_options"] = {name: {} if isinstance(given, dict) else given for name, given in backends.items()}
    return own, options


def validate(model: type[M], data: dict[str, Any], document: Document, problems: Problems) -> M | None:
    """Check `data`; as JSON, since strict models then take lists for tuples but convert nothing else."""
    try:
        return model.model_validate_json(json.dumps(data), context={"folder": document.folder})
    except ValidationError as error:
        for message in explain(error, model, data):
            mark = document.key_mark(message.path) if message.at_key else document.mark(message.path)
            problems.add(mark, message.path, message.text)
        return None


def report_nulls(node: Any, path: Path, document: Document, problems: Problems) -> None:
    """Refuse keys without a value also where the model could do without one."""
    if node is None and not problems.has(path):
        problems.add(document.mark(path), path, "no value is given; give one or remove the key")
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, item in items:
        report_nulls(item, (*path, key), document, problems)
