"""Validated scenario, ready to run."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.base.lazy import late
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import Mark, shown
from cdpr.config.document import Document, same
from cdpr.config.overrides import Change, Overrides
from cdpr.config.problems import Problems
from cdpr.config.yaml_text import dump
from cdpr.model import Robot
from cdpr.plugins.registry import Registry, registry
from cdpr.scenario import nominal
from cdpr.scenario.check import Checked, check, split
from cdpr.scenario.choices import choices
from cdpr.scenario.content import Content
from cdpr.scenario.event_checks import beyond
from cdpr.scenario.events import ScenarioEvent
from cdpr.scenario.from_python import document_of, output_file, working_folder, write
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions import Motion
from cdpr.scenario.plain_data import as_given, dumped, plain_in, to_dict
from cdpr.scenario.schema import ScenarioSection, Simulation, World
from cdpr.scenario.source import change

Data = Mapping[str, Any]


@dataclass(frozen=True, eq=False, init=False)
class Scenario(Content):
    """Simulation setup. Two scenarios are equal if they describe the same run.

    Arguments are the sections of a scenario file: objects of `cdpr.motions`, `cdpr.events` and `cdpr.scenario`, or
    dicts with the keys of a file. `load_scenario` reads a file. File names are absolute, or relative to the
    working folder at the time of the call.

    Args:
        robot: the robot: a Robot, a file, the name of an example, or a dict.
        simulation: duration, steps and backend, such as {"duration": 2.0, "backend": "mujoco"}.
        trajectory: desired motion; the start pose is held by default.
        initial: state at time 0; at rest at the robot's home by default.
        controller: type of the controller and its options, such as {"type": "computed_torque", "kp": 100.0}.
        solver: type of the tension solver and its options.
        events: events during the run.
        world: gravity and obstacles.
        name: name.
        sections: further sections, such as limits="stop".

    Attributes:
        sections: all sections of the file, with defaults.
        robot: the robot as frozen arrays.
        nominal: nominal robot of controller and solver; None if it equals the robot.
        unused: dotted keys that are given but not used by a run.
        notes: remarks on the options of replaced controllers or solvers, a sentence each.

    Raises:
        ScenarioError: with all problems, each with the key of its value.

    Example:
        >>> import cdpr
        >>> move = cdpr.motions.Quintic(duration=1.0, to={"position": [0.2, 0.0, 1.0]})
        >>> scenario = cdpr.Scenario(robot="caroca", simulation={"duration": 1.5}, trajectory=move)
        >>> scenario.robot
        <Robot caroca: 8 cables, 3R3T, platform of 150 kg>
        >>> faster = scenario.with_changes({"simulation.duration": 1.0})
        >>> faster.simulation.duration
        1.0
    """

    def __new__(cls, *unnamed: Any, **_: Any) -> Self:
        """Reject arguments without a name."""
        if unnamed:
            raise CdprError(f"Scenario(robot=, simulation=): expected arguments by name, got {shown(unnamed[0])}")
        return super().__new__(cls)

    def __init__(
        self,
        *,
        robot: Robot | Data | str | os.PathLike[str],
        simulation: Simulation | Data,
        trajectory: Motion | Data | None = None,
        initial: Initial | Data | None = None,
        controller: Data | None = None,
        solver: Data | None = None,
        events: Sequence[ScenarioEvent | Data] | None = None,
        world: World | Data | None = None,
        name: str = "scenario",
        **sections: Any,
    ) -> None:
        given = {
            "name": name,
            "robot": robot,
            "world": world,
            "simulation": simulation,
            "initial": initial,
            "trajectory": trajectory,
            "controller": controller,
            "solver": solver,
            "events": events,
            **sections,
        }
        left_out = {key for key, value in given.items() if value is None and key in ScenarioSection.model_fields}
        document = document_of({key: value for key, value in given.items() if key not in left_out})
        vars(self).update(vars(build_scenario(document, (), [], registry(), Problems())))

    def __repr__(self) -> str:
        simulation = self.simulation
        parts = f"controller {self.controller.type}, solver {self.solver.type}"
        return f"<Scenario {self.name}: {self.robot.name} on {simulation.backend}, {parts}, {simulation.duration:g} s>"

    def _repr_html_(self) -> str:
        """Return the HTML display for notebooks."""
        html: str = late("Scenario._repr_html_")(self)
        return html

    def session_yaml(self, folder: str, events: Sequence[ScenarioEvent], duration: float) -> str:
        """Return YAML of the scenario with these events and duration (s), for a file in another folder.

        File names are relative to that folder. `ends_early` is set if the duration is shorter.
        """
        data = plain_in(folder, self.sections, self._checked)
        data["simulation"]["duration"] = duration
        if duration < self.simulation.duration * (1.0 - tolerances.TIME):
            data["simulation"]["ends_early"] = True
        data["events"] = [dumped(event) for event in events]
        return dump(data)

    def yaml_in(self, folder: str) -> str:
        """Return `resolved_yaml` for a file in another folder, with adjusted file names."""
        data = plain_in(folder, self.sections, self._checked)
        return self.resolved_yaml() if data == to_dict(self.sections, self._checked) else dump(data)

    def resolved_yaml(self) -> str:
        """Return self-contained YAML with robot and defaults, which loads to an equal scenario.

        The CSV file of a trajectory, which may be large, remains a file; its checksum is included.
        """
        return self._text

    @cached_property
    def _text(self) -> str:
        return dump(to_dict(self.sections, self._checked))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the scenario with its robot as YAML, with the given values only; it loads to an equal scenario.

        Files of meshes, motions and options stay where they are; their names become relative to the saved file.

        Raises:
            OutputError: if it cannot be written.
        """
        target = output_file(path)
        write(target, dump(as_given(str(target.parent), self.sections, self._checked)))

    def replace(self, **sections: Any) -> Scenario:
        """Return a validated copy with other sections, such as trajectory=cdpr.motions.Hold(); None removes a section.

        Arguments are those of the constructor, but file names are absolute or relative to the scenario's folder: the
        file's or, of a scenario built in Python, the working folder at that time. `with_changes` changes single keys.

        Raises:
            ScenarioError: with all problems.
        """
        known = [*ScenarioSection.model_fields, nominal.ALTERNATIVE]
        for key in sections:
            if key not in known:
                hint = did_you_mean(key, known)
                raise CdprError(f"replace({key}=): unknown section: {hint}allowed: {', '.join(known)}")
        if nominal.ALTERNATIVE in sections and nominal.KEY in sections:
            raise CdprError(f"replace({nominal.ALTERNATIVE}=): {nominal.ANOTHER}: remove one of them")
        document = self._document.copy()
        for key in [key for key, value in sections.items() if value is None]:
            del sections[key]
            if (key := nominal.KEY if key == nominal.ALTERNATIVE else key) in document.data:
                document.drop((key,))
        plain = document_of(sections, document.folder).data
        mark = Mark("")  # a new object, because `Replacement` recognises old options by the identity of their marks
        changes = [Change((key,), value, mark) for key, value in plain.items()]
        return build_scenario(document, changes, [], self.plugins, Problems(), self)

    def with_changes(
        self,
        overrides: Overrides = (),
        *,
        backend: str | None = None,
        solver: str | None = None,
        controller: str | None = None,
        estimator: str | None = None,
        plugins: Registry | None = None,
    ) -> Scenario:
        """Return a changed and validated copy, or self if nothing changes; arguments are those of `load_scenario`."""
        names = {"backend": backend, "solver": solver, "controller": controller, "estimator": estimator}
        if not overrides and not any(names.values()) and plugins in (None, self.plugins):
            return self
        problems = Problems()
        chosen = choices(names, problems)
        return build_scenario(self._document.copy(), overrides, chosen, plugins or self.plugins, problems, self)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scenario):
            return NotImplemented
        return self is other or self.yaml_in("") == other.yaml_in("")  # with comparable file names

    def __hash__(self) -> int:
        return hash((self.name, self.robot, self.simulation))


def build_scenario(
    document: Document,
    overrides: Overrides,
    chosen: list[Change],
    plugins: Registry,
    problems: Problems,
    before: Scenario | None = None,
) -> Scenario:
    """Apply changes to a document, check it and return the scenario; raise ScenarioError with all `problems`.

    If the document is a copy of that of `before`, unchanged sections are not validated again.
    """
    change(document, overrides, chosen, plugins, problems)
    return _build(check(document, plugins, problems, before._checked if before else None), before)


def _build(checked: Checked, before: Scenario | None) -> Scenario:
    """Return the scenario of valid sections; what has not changed comes from the one `before`."""
    document, sections, unchanged = checked.document, checked.sections, checked.unchanged
    document.folder = os.path.join(working_folder(), document.folder)  # after the checks, whose messages name files
    known = before if "robot" in unchanged else None
    like = before if before and _same_but_platform(document, before._document) else None
    robot = sections.robot.named(like.sections.robot if like else None)
    section = checked.nominal and checked.nominal.named()
    trajectory = checked.motion.complete(checked.motion.begins(sections.initial, robot.platform.tools))
    if like and "actuators" in unchanged:
        unused = [key for key in like.unused if key.startswith("robot.")]
    else:
        unused = [f"robot.{key}" for key in robot.unused(sections.actuators is not None)]
    names = [cable.name for cable in robot.cables]
    events = [event.named(names) for event in checked.events]
    _, options = split(document.data)
    completed = {
        "controller": sections.controller.with_options(options.get("controller", {})),
        "solver": sections.solver.with_options(options.get("solver", {})),
        "estimator": sections.estimator and sections.estimator.with_options(options.get("estimator", {})),
        "backend_options": document.data.get("backend_options") or {},
        "robot": robot,
        "believed": section,
        "trajectory": trajectory,
        "controlled": sections.controlled or robot.dof,
        "events": events,
    }
    scenario = object.__new__(Scenario)
    vars(scenario).update(
        sections=sections.model_copy(update=completed),
        robot=known.robot if known else robot.to_robot(document.folder, like.robot if like else None),
        nominal=section.to_robot(document.folder) if section else None,
        unused=(
            *unused,
            *(nominal.unused(robot, section) if section else ()),
            *document.dropped,
            *(f"events[{i}]" for i in beyond(events, sections.simulation)),
        ),
        notes=tuple(document.notes),
        _checked=checked,
    )
    moving = {"trajectory", "initial"} if trajectory.tool is None else {"trajectory", "initial", "robot"}
    if before and moving <= unchanged and "planned" in before.__dict__:
        scenario.__dict__["planned"] = before.planned  # as `cached_property` stores it
    return scenario


def _same_but_platform(document: Document, before: Document) -> bool:
    """Return True if the robots of two validated documents differ in the platform only."""
    robot, other = document.data["robot"], before.data["robot"]
    return all(same(robot.get(key), other.get(key)) for key in {*robot, *other} - {"platform"})
