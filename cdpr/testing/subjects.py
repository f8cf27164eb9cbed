"""The plugin under test: how the checks make it and call it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from importlib import import_module
from types import TracebackType
from typing import Any, Self

import numpy as np

from cdpr.errors import PluginError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Backend, Column, Controller, TensionSolver
from cdpr.plugins.registry import with_arrays
from cdpr.tension import Status
from cdpr.testing import samples
from cdpr.testing.check import NotApplicable, expect
from cdpr.testing.samples import GRAVITY, Problem

# Of tensions, lowest and highest tensions, each (m,), N: what a solver minimises, convex in the tensions.
Cost = Callable[[Array, Array, Array], float]


FIRST = 50  # of the problems for each robot, for a solver declared slow


class _Subject:
    """Closes what was made when its check ends."""

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
        self._open: list[Backend | Controller] = []

    def having(self, options: Any) -> Self:
        """Return the same with other options."""
        other = copy(self)
        other.options = options
        return other

    def _made(self, *arguments: Any) -> Any:
        return with_arrays(self.factory(*arguments), self.columns, arguments)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        while self._open:
            self._open.pop().close()


class BackendSubject(_Subject):
    """A backend under test."""

    def __enter__(self) -> BackendSubject:
        return self

    def make(self, state: Array, robot: Robot | None = None, gravity: Array = GRAVITY, step: float = 1e-3) -> Backend:
        """Make a plant and put it into `state` (13,); by default the free robot with its mass off the origin."""
        backend: Backend = self._made(robot or samples.free(), gravity, step, self.options)
        self._open.append(backend)
        backend.reset(state)
        return backend

    def guided(
        self, state: Array, gravity: Array = GRAVITY, step: float = 1e-3, *, robot: Robot | None = None
    ) -> Backend:
        """Make the planar robot, or another; a backend that refuses it with a PluginError has no such guides."""
        robot = robot or samples.planar()
        try:
            return self.make(state, robot, gravity, step)
        except PluginError as refusal:
            raise NotApplicable(f"it takes no platform with dof {', '.join(robot.dof)}: {refusal}") from refusal

    def close(self, backend: Backend) -> None:
        """Close a plant before the check ends."""
        self._open.remove(backend)
        backend.close()


class SolverSubject(_Subject):
    """A tension solver under test."""

    def __enter__(self) -> SolverSubject:
        return self

    def make(self, robot: Robot) -> TensionSolver:
        """Make a solver for a robot."""
        solver: TensionSolver = self._made(robot, self.options)
        return solver

    def declares(self, name: str) -> bool:
        """Whether a property is declared and true."""
        return bool(self.properties.get(name))

    def asked(self, groups: tuple[tuple[Problem, ...], ...]) -> tuple[tuple[Problem, ...], ...]:
        """All problems of each group, or the first ones if the solver is declared `slow`."""
        return tuple(group[:FIRST] for group in groups) if self.declares("slow") else groups

    @property
    def respects_bounds(self) -> bool:
        """Whether OK promises tensions within the limits: so unless the plugin says otherwise."""
        return bool(self.properties.get("respects_bounds", True))

    @property
    def cost(self) -> Cost | None:
        """What the plugin declares that it minimises: a function, or where to find one, "module:function"."""
        declared = self.properties.get("cost")
        if isinstance(declared, str):
            module, _, name = declared.partition(":")
            declared = getattr(import_module(module), name)
        expect(declared is None or callable(declared), f"declares the cost {declared!r}, which is no function")
        return declared

    @property
    def accuracy(self) -> float:
        """Share of the load, or of the largest limit, by which an answer may be off."""
        return 1e-9 if self.declares("exact") else 1e-6


def ask(solver: TensionSolver, problem: Problem) -> tuple[int, Array]:
    """Return the solver's status and answer; the status must be one, and the answer to OK must be finite."""
    tension = np.full(problem.W.shape[1], np.nan)
    status = solver.solve(problem.W, problem.wrench, problem.t_min, problem.t_max, tension)
    expect(
        isinstance(status, (int, np.integer)) and not isinstance(status, bool) and status in list(Status),
        f"returned {status!r}, which is no cdpr.tension.Status",
    )
    sound = np.isfinite(problem.W).all() and np.isfinite(problem.wrench).all()  # the stage refuses what is not
    expect(status != Status.OK or not sound or np.isfinite(tension).all(), "OK, but not every tension is written")
    return int(status), tension


class ControllerSubject(_Subject):
    """A controller under test."""

    def __enter__(self) -> ControllerSubject:
        return self

    @property
    def commands(self) -> bool:
        """Whether it puts out the command of each cable instead of a wrench."""
        return bool(self.properties.get("output", "wrench") == "command")

    def make(self, robot: Robot, gravity: Array = GRAVITY, step: float = 1e-3) -> Controller:
        """Make a controller, connected to a tension stage that has nothing to report."""
        controller: Controller = self._made(robot, gravity, step, self.options)
        self._open.append(controller)
        controller.connect(np.zeros(4))
        return controller

    def ask(self, controller: Controller, state: Array, desired: Array, time: float = 0.0) -> Array:
        """Return the output: (6,) or (m,)."""
        out = np.full(controller.robot.m if self.commands else 6, np.nan)
        controller.control(time, state, desired, out)
        return out
