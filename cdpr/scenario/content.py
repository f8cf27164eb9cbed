"""Content of a validated scenario: its sections, robot and options."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from pydantic import BaseModel, ValidationError

from cdpr.base.errors import PluginError
from cdpr.base.problems import Mark, Problem
from cdpr.cables import model_of, rubs
from cdpr.config.document import Document
from cdpr.config.problems import Problems
from cdpr.fmu.read.options import FMU
from cdpr.model import Robot
from cdpr.model.robot import Array, frozen_array, ideal
from cdpr.model.shapes import Obstacle
from cdpr.plugins.registry import Registry
from cdpr.scenario import nominal, plausible
from cdpr.scenario.actuator_schema import Actuators
from cdpr.scenario.changes import Options
from cdpr.scenario.check import Checked
from cdpr.scenario.event_checks import EventChecks
from cdpr.scenario.events import ScenarioEvent, redirected
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions import Motion
from cdpr.scenario.schema import ControllerSection, EstimatorSection, ScenarioSection, Simulation, SolverSection, World
from cdpr.trajectory import Trajectory, of_tool


@dataclass(frozen=True, eq=False)
class Content:
    """Content of a scenario.

    Attributes:
        sections: all sections of the file, with defaults.
        robot: the robot as frozen arrays.
        nominal: nominal robot of controller and solver; None if it equals the robot.
        unused: dotted keys that are given but not used by a run.
        notes: remarks on the options of replaced controllers or solvers, a sentence each.
    """

    sections: ScenarioSection
    robot: Robot
    nominal: Robot | None
    unused: tuple[str, ...]
    notes: tuple[str, ...]
    _checked: Checked = field(repr=False)

    @property
    def plugins(self) -> Registry:
        """Available plugins."""
        return self._checked.plugins

    @property
    def source(self) -> str:
        """Scenario file."""
        return self._document.source

    @property
    def origin(self) -> str:
        """Scenario file or, if it was built in Python, the folder of its files: `load_scenario(origin, text=...)`."""
        return self.source or os.path.join(self._document.folder, "")

    @property
    def controller_options(self) -> BaseModel:
        """Options of the controller, an instance of its plugin's model."""
        return self._checked.controller_options

    @property
    def solver_options(self) -> BaseModel:
        """Options of the tension solver, an instance of its plugin's model."""
        return self._checked.solver_options

    @property
    def estimator_options(self) -> BaseModel | None:
        """Options of the estimator, an instance of its plugin's model; None without an estimator."""
        return self._checked.estimator_options

    @property
    def _document(self) -> Document:
        return self._checked.document

    @property
    def name(self) -> str:
        """Name of the scenario; by default that of the file."""
        return self.sections.name

    @property
    def world(self) -> World:
        """Surroundings of the robot."""
        return self.sections.world

    @property
    def gravity(self) -> Array:
        """Acceleration of gravity, (3,), m/s^2, world frame."""
        return frozen_array(self.sections.world.gravity)

    @cached_property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """Obstacles that cables should not touch."""
        folder = self._document.folder
        return tuple(each.build(i, folder) for i, each in enumerate(self.sections.world.obstacles, start=1))

    @property
    def simulation(self) -> Simulation:
        """Backend, duration and time steps."""
        return self.sections.simulation

    @property
    def initial(self) -> Initial:
        """State of the platform at time 0."""
        return self.sections.initial

    @property
    def trajectory(self) -> Motion:
        """Desired motion, with missing poses set to the initial pose."""
        return self.sections.trajectory

    @cached_property
    def planned(self) -> Trajectory:
        """Desired motion without the effect of events."""
        trajectory, tool = self.trajectory.make(), self.trajectory.tool
        return trajectory if tool is None else of_tool(trajectory, self.robot.platform.tools[tool])

    @cached_property
    def desired(self) -> Trajectory:
        """Desired motion with the effect of events; CdprError if an event makes it impossible."""
        return redirected(self.planned, self.events, self.simulation.control_step)

    @property
    def controlled_dof(self) -> tuple[str, ...]:
        """Degrees of freedom in which the cables exert the controller's wrench."""
        return self.sections.controlled or self.robot.dof

    @cached_property
    def controlled_robot(self) -> Robot:
        """Robot for the tension distribution: its `dof` are only the controlled ones."""
        dof = self.controlled_dof
        return self.robot if dof == self.robot.dof else replace(self.robot, dof=dof)

    @cached_property
    def nominal_differences(self) -> str:
        """Differences of the nominal robot in one line; "" if there are none."""
        robot, section = self.sections.robot, self.sections.believed
        return "" if section is None else nominal.in_a_line(nominal.differences(robot, section))

    @cached_property
    def warnings(self) -> tuple[Problem, ...]:
        """Values that are allowed but probably not intended, such as sizes in mm: see `cdpr.scenario.plausible`."""
        sections, document, twin = self.sections, self._document, self._checked.twin
        shortened = not document.mark(("simulation", "duration")).line
        about = sections.robot, self.robot, nominal.ROBOT, document.data, sections, self._checked.motion, self.obstacles
        setup = plausible.Setup(*about, lambda: self.desired, shortened, *self._declared())
        found = plausible.warnings(setup, document)
        if sections.believed is None or self.nominal is None or twin is None:
            return found
        thought = replace(setup, section=sections.believed, robot=self.nominal, data=twin.data)
        return (*found, *nominal.only_nominal(plausible.warnings(thought, twin), found))

    def _declared(self) -> tuple[dict[str, object], dict[str, object]]:
        """Return the declared properties of the controller, and of the estimator; those are empty without one."""
        controller = self.plugins.get("controller", self.controller.type).properties(self.controller_options)  # type: ignore[arg-type]
        if self.estimator is None:
            return controller, {}
        return controller, self.plugins.get("estimator", self.estimator.type).properties(self.estimator_options)  # type: ignore[arg-type]

    def doubts(self, events: Sequence[ScenarioEvent]) -> list[str]:
        """Return the warnings on the target of the last of these events, which replace the scenario's events."""
        relevant = [*(event for event in events[:-1] if event.goal() is None), *events[-1:]]
        run = self.sections.model_copy(update={"events": relevant})
        about = self.sections.robot, self.robot, nominal.ROBOT, self._document.data, run
        path = "events", len(relevant) - 1
        return [text for where, text in plausible.of_places(plausible.Setup(*about)) if where[:2] == path]

    @property
    def controller(self) -> ControllerSection:
        """Type of the controller."""
        return self.sections.controller

    @property
    def solver(self) -> SolverSection:
        """Type of the tension solver, and its reaction to infeasible wrenches."""
        return self.sections.solver

    @property
    def estimator(self) -> EstimatorSection | None:
        """Type of the estimator; None without one."""
        return self.sections.estimator

    @property
    def events(self) -> tuple[ScenarioEvent, ...]:
        """Events of the run, with cables by name."""
        return tuple(self.sections.events)

    @property
    def actuators(self) -> Actuators | None:
        """FMU between commands and cables, or None."""
        return self.sections.actuators

    @property
    def cable_model(self) -> str:
        """Model that converts commands into tensions: the robot's, or "fmu"."""
        return model_of(self.robot) if self.actuators is None else FMU

    @property
    def immediate_cables(self) -> bool:
        """True if the tensions of all cables equal the commands that the drives apply."""
        return ideal(self.cable_model) and not rubs(self.robot)

    @property
    def ideal_drives(self) -> bool:
        """True if the drives apply all commands exactly and at once."""
        return self.sections.drives is None or self.sections.drives.ideal

    @property
    def ideal_cables(self) -> bool:
        """True if the tensions of all cables equal their commands."""
        return self.immediate_cables and self.ideal_drives

    @property
    def log_every(self) -> int:
        """Number of samples per logged sample; at most the whole run."""
        log, steps = self.sections.log, self.simulation.steps
        return 1 if log is None else max(1, min(round(log.step / self.simulation.control_step), steps))

    def options(self) -> Options:
        """Return the initial options of controller and solver, which can be changed."""
        return self._checked.options()

    def backend_options(self, name: str | None = None) -> BaseModel:
        """Return the options of a backend (default: the selected one); PluginError if they are required but missing."""
        name = name or self.simulation.backend
        if name in self._checked.backend_options:
            return self._checked.backend_options[name]
        model = self.plugins.get("backend", name).info.options
        try:
            return model()
        except ValidationError as error:
            raise PluginError(f"backend '{name}' needs options: give them under backend_options.{name}") from error

    def problems_with(self, events: Sequence[ScenarioEvent], new: ScenarioEvent) -> list[Problem]:
        """Return the problems of `events` in place of the scenario's; all but `new` have been checked before.

        Paths are relative to the section `events`.
        """
        problems = Problems()
        EventChecks(self._document.copy(), problems, self.options()).run(events, new)
        return problems.items

    def place(self, *path: str | int) -> str:
        """Return file, line and column of the value at `path`."""
        return str(self.mark(*path))

    def mark(self, *path: str | int) -> Mark:
        """Return the mark of the value at `path`."""
        return self._document.mark(path)
