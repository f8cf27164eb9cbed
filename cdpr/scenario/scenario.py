"""A checked scenario, ready to run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError

from cdpr.errors import PluginError
from cdpr.model import Robot
from cdpr.model.robot import Array, frozen_array
from cdpr.plugins.registry import Registry
from cdpr.scenario.actuator_schema import Actuators
from cdpr.scenario.document import Document
from cdpr.scenario.events import ScenarioEvent
from cdpr.scenario.motions import Motion
from cdpr.scenario.schema import ControllerSection, Initial, ScenarioSection, Simulation, SolverSection, World
from cdpr.scenario.yaml_text import dump

if TYPE_CHECKING:
    from cdpr.scenario.overrides import Overrides


@dataclass(frozen=True, eq=False)
class Scenario:
    """What to simulate. Made by `load_scenario`; two scenarios are equal if they describe the same run.

    Attributes:
        sections: all sections of the file, every default filled in.
        robot: the robot as frozen arrays.
        controller_options: options of the controller, an instance of its plugin's model.
        solver_options: the same for the tension solver.
        source: the file that it came from.
        unused: dotted keys that are given but that a run does not use.
        notes: what became of the options of a controller or solver that was replaced, and warnings of what is allowed
            and seldom meant, a sentence each.
    """

    sections: ScenarioSection
    robot: Robot
    controller_options: BaseModel
    solver_options: BaseModel
    source: str
    unused: tuple[str, ...]
    notes: tuple[str, ...]
    _backend_options: Mapping[str, BaseModel]
    _document: Document = field(repr=False)
    _plugins: Registry = field(repr=False)

    @property
    def plugins(self) -> Registry:
        """The plugins that it chooses from."""
        return self._plugins

    @property
    def name(self) -> str:
        """Name of the scenario; the file's unless it says another."""
        return self.sections.name

    @property
    def world(self) -> World:
        """What surrounds the robot."""
        return self.sections.world

    @property
    def gravity(self) -> Array:
        """Acceleration of gravity, (3,), m/s^2, world."""
        return frozen_array(self.sections.world.gravity)

    @property
    def simulation(self) -> Simulation:
        """Backend, duration and steps."""
        return self.sections.simulation

    @property
    def initial(self) -> Initial:
        """State of the platform at time 0."""
        return self.sections.initial

    @property
    def trajectory(self) -> Motion:
        """The desired motion, with the initial pose filled in where a pose was left out."""
        return self.sections.trajectory

    @cached_property
    def controlled(self) -> Robot:
        """The robot as the distribution of tensions sees it: its `dof` are the controlled directions alone."""
        return replace(self.robot, dof=self.sections.controlled or self.robot.dof)

    @property
    def controller(self) -> ControllerSection:
        """Type of the controller."""
        return self.sections.controller

    @property
    def solver(self) -> SolverSection:
        """Type of the tension solver, and what to do while a wrench is infeasible."""
        return self.sections.solver

    @property
    def events(self) -> tuple[ScenarioEvent, ...]:
        """What happens during the run, each cable by its name."""
        return tuple(self.sections.events)

    @property
    def actuators(self) -> Actuators | None:
        """The FMU between commands and cables, if there is one."""
        return self.sections.actuators

    @property
    def cable_model(self) -> str:
        """What turns commands into tensions: the robot's model, or "fmu"."""
        return self.robot.cable_model if self.actuators is None else "fmu"

    @property
    def log_every(self) -> int:
        """Samples from one that is kept to the next; the whole run where it is shorter."""
        log, steps = self.sections.log, self.simulation.steps
        return 1 if log is None else max(1, min(round(log.step / self.simulation.control_step), steps))

    def backend_options(self, name: str | None = None) -> BaseModel:
        """Return the options of a backend, of the chosen one unless named; PluginError if it has none."""
        name = name or self.simulation.backend
        if name in self._backend_options:
            return self._backend_options[name]
        model = self._plugins.get("backend", name).info.options
        try:
            return model()
        except ValidationError as error:
            raise PluginError(f"backend '{name}' needs options: give them under backend_options.{name}") from error

    def resolved_yaml(self) -> str:
        """Return YAML that stands alone, robot and defaults written out, and loads to an equal scenario.

        A trajectory's CSV file, which may be large, stays a file; its checksum is written.
        """
        return dump(self._plain())

    def place(self, *path: str | int) -> str:
        """Return where the value at `path` was written: file, line and column."""
        return str(self._document.mark(path))

    def with_changes(
        self,
        overrides: Overrides = (),
        *,
        backend: str | None = None,
        solver: str | None = None,
        controller: str | None = None,
        plugins: Registry | None = None,
    ) -> Scenario:
        """Return a changed copy, checked like a file; arguments as for `load_scenario`."""
        from cdpr.scenario.loader import change_scenario  # the loader imports this module

        return change_scenario(self, overrides, backend, solver, controller, plugins or self._plugins)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scenario):
            return NotImplemented
        return self.resolved_yaml() == other.resolved_yaml()

    def __hash__(self) -> int:
        return hash(self.resolved_yaml())

    def _plain(self) -> dict[str, Any]:
        """Return the sections as plain data in the order of the schema."""
        data = self.sections.model_dump(mode="json", by_alias=True, exclude_none=True, exclude={"backend_options"})
        for section, options in (("controller", self.controller_options), ("solver", self.solver_options)):
            core = data[section]  # its keys come first, and stay where a plugin has one of the same name
            data[section] = {**core, **options.model_dump(mode="json", by_alias=True), **core}
        given = {
            name: options.model_dump(mode="json", by_alias=True)
            for name, options in sorted(self._backend_options.items())
        }
        data["backend_options"] = {name: options for name, options in given.items() if options}
        return data
