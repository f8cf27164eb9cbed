"""Plugins under test: creation and calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from importlib import import_module
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from cdpr.base.errors import PluginError, one_line
from cdpr.base.problems import short_repr
from cdpr.model import Robot
from cdpr.model.robot import Array, read_only
from cdpr.plugins import Backend, Column, Controller, ControllerInputs, Environment, Estimator, TensionSolver
from cdpr.plugins.controller import COMMANDS
from cdpr.plugins.registry import with_arrays
from cdpr.tension import Status
from cdpr.testing import samples
from cdpr.testing.check import Failed, NotApplicable, expect
from cdpr.testing.samples import GRAVITY, Problem
from cdpr.testing.sensors import SampleSensors

# Convex cost of tensions, given lowest and highest tensions, each (m,), N.
Cost = Callable[[Array, Array, Array], float]


FIRST = 50  # problems per robot for a solver declared slow


class Subject:
    """Plugin under test; everything created is closed at the end of its check."""

    def __init__(
        self,
        factory: Callable[..., Any],
        properties: Mapping[str, Any],
        options: Any,
        columns: tuple[Column, ...] | None = None,
        changeable: tuple[str, ...] | None = None,
    ) -> None:
        self.factory, self.properties, self.options = factory, properties, options
        self.columns: tuple[Column, ...] = getattr(factory, "columns", ()) if columns is None else columns
        self.changeable: tuple[str, ...] = getattr(factory, "changeable", ()) if changeable is None else changeable
        self._open: list[Backend | Controller | Estimator] = []

    def having(self, options: Any) -> Self:
        """Return the subject with other options."""
        other = copy(self)
        other.options = options
        return other

    def _create(self, *arguments: Any) -> Any:
        return with_arrays(self.factory(*arguments), self.columns, arguments)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Close all; a failure of `close` is reported unless the check has failed already."""
        failed = None
        while self._open:
            try:
                self._open.pop().close()
            except Exception as fault:
                failed = failed or fault
        if failed is not None and error is None:
            raise Failed(f"close raised {one_line(failed)}") from failed


class BackendSubject(Subject):
    """A backend under test."""

    def make(
        self,
        state: Array,
        robot: Robot | None = None,
        gravity: Array = GRAVITY,
        step: float = 1e-3,
        environment: Environment | None = None,
    ) -> Backend:
        """Create a plant in `state` (13,); by default the free robot with its centre of mass off the origin."""
        backend: Backend = self._create(robot or samples.free(), gravity, step, self.options)
        self._open.append(backend)
        if environment is not None:
            backend.surround(environment)
        backend.reset(state)
        return backend

    def guided(
        self, state: Array, gravity: Array = GRAVITY, step: float = 1e-3, *, robot: Robot | None = None
    ) -> Backend:
        """Create a guided robot, the planar one by default.

        Raises:
            NotApplicable: if the backend refuses it with a PluginError.
        """
        robot = robot or samples.planar()
        try:
            return self.make(state, robot, gravity, step)
        except PluginError as refusal:
            raise NotApplicable(f"it takes no platform with dof {', '.join(robot.dof)}: {refusal}") from refusal

    def close(self, backend: Backend) -> None:
        """Close a plant before the check ends."""
        self._open.remove(backend)
        backend.close()


class SolverSubject(Subject):
    """A tension solver under test."""

    def make(self, robot: Robot) -> TensionSolver:
        """Create a solver for a robot."""
        solver: TensionSolver = self._create(robot, self.options)
        return solver

    def declares(self, name: str) -> bool:
        """Return True if a property is declared and true."""
        return bool(self.properties.get(name))

    def limited(self, groups: tuple[tuple[Problem, ...], ...]) -> tuple[tuple[Problem, ...], ...]:
        """Return all problems of each group, or only the first ones for a solver declared `slow`."""
        return tuple(group[:FIRST] for group in groups) if self.declares("slow") else groups

    @property
    def respects_bounds(self) -> bool:
        """True if OK implies tensions within the limits, the default."""
        return bool(self.properties.get("respects_bounds", True))

    @property
    def cost(self) -> Cost | None:
        """Declared cost of the plugin: a function, or its location "module:function"."""
        declared = self.properties.get("cost")
        if isinstance(declared, str):
            module, _, name = declared.partition(":")
            declared = getattr(import_module(module), name)
        expect(
            declared is None or callable(declared), f"declares the cost {short_repr(declared)}, which is not a function"
        )
        return declared

    @property
    def accuracy(self) -> float:
        """Relative tolerance of an answer, as a share of the load or of the largest limit."""
        return 1e-9 if self.declares("exact") else 1e-6


def solve(solver: TensionSolver, problem: Problem) -> tuple[int, Array]:
    """Return the solver's status and answer; fail if the status is invalid or an answer with OK is not finite."""
    tension = np.full(problem.W.shape[1], np.nan)
    status = solver.solve(problem.W, problem.wrench, problem.t_min, problem.t_max, tension)
    expect(
        isinstance(status, (int, np.integer)) and not isinstance(status, bool) and status in list(Status),
        f"returned {short_repr(status)}, which is not a cdpr.tension.Status",
    )
    sound = np.isfinite(problem.W).all() and np.isfinite(problem.wrench).all()  # the stage rejects non-finite input
    expect(status != Status.OK or not sound or np.isfinite(tension).all(), "OK, but not every tension is written")
    return int(status), tension


class ControllerSubject(Subject):
    """A controller under test.

    Attributes:
        limits: (2, m), N, limits that the last controller observes, live.
        held: (m,), cables that it knows to be held, live.
        missing: name and index of a measurement that is NaN; None by default.
    """

    limits: Array
    held: NDArray[np.bool_]
    missing: tuple[str, int] | None = None
    _desired: Array

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._sensors: dict[Controller, SampleSensors] = {}

    @property
    def commands(self) -> bool:
        """True if the output is the command of each cable instead of a wrench."""
        return bool(self.properties.get("output", "wrench") in COMMANDS)

    @property
    def pulls(self) -> bool:
        """True if the output is a wrench or tensions; False for lengths or rates."""
        return self.properties.get("output", "wrench") not in ("length", "rate")

    def make(self, robot: Robot, gravity: Array = GRAVITY, step: float = 1e-3) -> Controller:
        """Create a controller, connected to a tension stage with an empty report."""
        controller: Controller = self._create(robot, gravity, step, self.options)
        self._open.append(controller)
        controller.connect(np.zeros(4))
        sensors = SampleSensors(self.properties.get("sensors", ()), robot, gravity, step)
        self._sensors[controller] = sensors
        controller.use_sensors(sensors.sensors)
        controller.observe(self._inputs(robot, sensors))
        return controller

    def corrected(self, controller: Controller, distributed: Array, actual: Array, time: float) -> Array | None:
        """Return the tensions (m,) that a controller's inner loop writes, N; None without one.

        Args:
            controller: the controller.
            distributed: (m,), N, tensions of the distribution.
            actual: (m,), N, tensions of the cables in the control period before.
            time: time, s.
        """
        tension = np.full(controller.robot.m, np.nan)
        correct = controller.inner_loop(read_only(distributed), tension)
        if correct is None:
            return None
        sensors = self._sensors[controller]
        sensors.tension[:] = actual
        sensors.measure(sensors.state, time, self.missing)
        correct(time)
        return tension

    def _inputs(self, robot: Robot, sensors: SampleSensors) -> ControllerInputs:
        """Return inputs of a robot without faults, whose preview is the last desired state."""
        self.limits, self.held = np.array([robot.tension_min, robot.tension_max]), np.zeros(robot.m, dtype=bool)
        limits, held, command = read_only(self.limits), read_only(self.held), read_only(np.zeros(robot.m))
        return ControllerInputs(self._preview, limits, held, command, sensors.measurements)

    def _preview(self, times: Array) -> Array:
        return np.tile(self._desired, (len(times), 1))

    def measured(self, controller: Controller) -> list[tuple[str, int]]:
        """Return name and index of each value that the sensors of a controller measure."""
        return self._sensors[controller].quantities

    def compute(self, controller: Controller, state: Array, desired: Array, time: float = 0.0) -> Array:
        """Return the output: (6,) or (m,)."""
        self._desired = desired.copy()
        self._sensors[controller].measure(state, time, self.missing)
        out = np.full(controller.robot.m if self.commands else 6, np.nan)
        controller.control(time, state, desired, out)
        return out
