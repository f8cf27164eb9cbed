"""The three forms of the kit: checks of a factory, cases for pytest, and checks by plugin name for the command line."""

from __future__ import annotations

import unittest
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from pydantic import ValidationError

from cdpr.base.errors import CdprError, PluginError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Backend, Column, Controller, PluginOptions, TensionSolver
from cdpr.plugins.registry import Role, registry
from cdpr.testing import (
    backend_guided,
    backend_interface,
    backend_physics,
    backend_winches,
    controller,
    solver_answers,
    solver_interface,
)
from cdpr.testing.check import Check, CheckResult, Failed
from cdpr.testing.subjects import BackendSubject, ControllerSubject, SolverSubject

S = TypeVar("S")

BACKEND: list[Check[BackendSubject]] = [
    *backend_interface.CHECKS,
    *backend_physics.CHECKS,
    *backend_winches.CHECKS,
    *backend_guided.CHECKS,
]
SOLVER: list[Check[SolverSubject]] = [*solver_interface.CHECKS, *solver_answers.CHECKS]
CONTROLLER: list[Check[ControllerSubject]] = controller.CHECKS

ROLES: dict[Role, tuple[Sequence[Check[Any]], Callable[..., AbstractContextManager[Any]]]] = {
    "backend": (BACKEND, BackendSubject),
    "solver": (SOLVER, SolverSubject),
    "controller": (CONTROLLER, ControllerSubject),
}

NOTHING: Mapping[str, Any] = {}


def check_backend(
    factory: Callable[[Robot, Array, float, Any], Backend],
    *,
    properties: Mapping[str, Any] = NOTHING,
    options: Any = None,
    columns: tuple[Column, ...] | None = None,
    expected_failures: Mapping[str, str] = NOTHING,
    only: Collection[str] | None = None,
) -> list[CheckResult]:
    """Check a backend: `factory(robot, gravity, physics_step, options)`.

    Args:
        factory: target of the plugin's `PluginInfo.factory`.
        properties: declared properties: `order`, `snapshot` (True if supported), `threads`, `speed_max` (m/s, if it
            clamps).
        options: instance of its options model; None by default.
        columns: declared columns; by default the attribute `columns` of the factory.
        expected_failures: reason by id of each check that is known to fail.
        only: ids of the checks to run; all by default.
    """
    return _run(BACKEND, lambda: BackendSubject(factory, properties, options, columns), expected_failures, only)


def check_solver(
    factory: Callable[[Robot, Any], TensionSolver],
    *,
    properties: Mapping[str, Any] = NOTHING,
    options: Any = None,
    columns: tuple[Column, ...] | None = None,
    changeable: tuple[str, ...] | None = None,
    expected_failures: Mapping[str, str] = NOTHING,
    only: Collection[str] | None = None,
) -> list[CheckResult]:
    """Check a tension solver: `factory(robot, options)`.

    Args:
        factory: target of the plugin's `PluginInfo.factory`.
        properties: declared properties: `exact` (balances to round-off), `respects_bounds`, `continuity` ("jump", "C0",
            "C1", "Cinf"), `coverage` ("full" if it solves every solvable problem), `objective` ("min_norm" or
            "mid_range"), `cost` (another convex objective: a function of tensions, lowest and highest tensions, or its
            location, "module:function"), `slow` (it gets fewer problems), `warm_start` (True if answers may depend on
            earlier ones, within the accuracy).
        options: instance of its options model; None by default.
        columns: declared columns; by default the attribute `columns` of the factory.
        changeable: changeable options; by default the attribute `changeable` of the factory.
        expected_failures: reason by id of each check that is known to fail.
        only: ids of the checks to run; all by default.
    """
    return _run(
        SOLVER, lambda: SolverSubject(factory, properties, options, columns, changeable), expected_failures, only
    )


def check_controller(
    factory: Callable[[Robot, Array, float, Any], Controller],
    *,
    properties: Mapping[str, Any] = NOTHING,
    options: Any = None,
    columns: tuple[Column, ...] | None = None,
    changeable: tuple[str, ...] | None = None,
    expected_failures: Mapping[str, str] = NOTHING,
    only: Collection[str] | None = None,
) -> list[CheckResult]:
    """Check a controller: `factory(robot, gravity, control_step, options)`.

    Args:
        factory: target of the plugin's `PluginInfo.factory`.
        properties: declared properties: `output` ("wrench" or "command"), `isotropic` (False if its default gains
            differ between directions).
        options: instance of its options model; None by default.
        columns: declared columns; by default the attribute `columns` of the factory.
        changeable: changeable options; by default the attribute `changeable` of the factory.
        expected_failures: reason by id of each check that is known to fail.
        only: ids of the checks to run; all by default.
    """
    return _run(
        CONTROLLER,
        lambda: ControllerSubject(factory, properties, options, columns, changeable),
        expected_failures,
        only,
    )


@dataclass(frozen=True)
class Case(Generic[S]):
    """One check of one installed plugin; `str(case)` is its id, and a call raises if the plugin fails."""

    check: Check[S]
    make: Callable[[], AbstractContextManager[S]]
    expected_failures: Mapping[str, str]

    def __str__(self) -> str:
        return self.check.id

    def carry_out(self) -> CheckResult:
        """Run the check and return its result."""
        return self.check.carry_out(self.make(), self.expected_failures)

    def __call__(self) -> None:
        """Raise Failed if the plugin fails, and SkipTest if the check does not apply."""
        result = self.carry_out()
        if result.outcome == "failed":
            raise Failed(f"{result.id} ({result.reason}): {result.detail}")
        if result.outcome == "n/a":
            raise unittest.SkipTest(result.detail)


def backend_checks(
    name: str, *, options: Any = None, expected_failures: Mapping[str, str] = NOTHING
) -> list[Case[Any]]:
    """Return the checks of an installed backend, for pytest's `parametrize(..., ids=str)`."""
    return _cases("backend", name, options, expected_failures)


def solver_checks(name: str, *, options: Any = None, expected_failures: Mapping[str, str] = NOTHING) -> list[Case[Any]]:
    """Return the checks of an installed solver, for pytest's `parametrize(..., ids=str)`."""
    return _cases("solver", name, options, expected_failures)


def controller_checks(
    name: str, *, options: Any = None, expected_failures: Mapping[str, str] = NOTHING
) -> list[Case[Any]]:
    """Return the checks of an installed controller, for pytest's `parametrize(..., ids=str)`."""
    return _cases("controller", name, options, expected_failures)


def check_plugin(role: Role, name: str) -> list[CheckResult]:
    """Check an installed plugin with its declared properties and default options.

    Raises:
        PluginError: if it is unknown or cannot be loaded.
    """
    return [case.carry_out() for case in _cases(role, name, None, NOTHING)]


def _cases(role: Role, name: str, options: Any, expected_failures: Mapping[str, str]) -> list[Case[Any]]:
    entry = registry().get(role, name)
    factory = entry.load()
    try:
        chosen: PluginOptions = entry.info.options() if options is None else options
    except ValidationError:
        raise PluginError(
            f"{role} '{name}' needs options, such as a file: check it from Python, {role}_checks('{name}', options=...)"
        ) from None
    properties = entry.properties(chosen)
    checks, kind = ROLES[role]
    _refuse_unknown(checks, expected_failures)
    return [
        Case(
            check,
            lambda: kind(factory, properties, chosen, entry.info.columns, entry.info.changeable),
            expected_failures,
        )
        for check in checks
    ]


def _run(
    checks: Sequence[Check[S]],
    make: Callable[[], AbstractContextManager[S]],
    expected_failures: Mapping[str, str],
    only: Collection[str] | None,
) -> list[CheckResult]:
    _refuse_unknown(checks, expected_failures)
    _refuse_unknown(checks, only or ())
    wanted = [check for check in checks if only is None or check.id in only]
    return [check.carry_out(make(), expected_failures) for check in wanted]


def _refuse_unknown(checks: Sequence[Check[Any]], ids: Collection[str]) -> None:
    known = [check.id for check in checks]
    if unknown := sorted(set(ids) - set(known)):
        raise CdprError(f"no check is named {', '.join(unknown)}; there are {', '.join(known)}")
