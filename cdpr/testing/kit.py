"""The three forms of the kit: checks of a factory, cases for pytest, and checks by plugin name for the command line."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, TypeVar

from pydantic import ValidationError

from cdpr.base.errors import CdprError, PluginError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Backend, Column, Controller, Estimator, PluginOptions, TensionSolver
from cdpr.plugins.registry import Role, registry
from cdpr.testing import (
    backend_anchors,
    backend_guided,
    backend_interface,
    backend_load,
    backend_physics,
    backend_surroundings,
    backend_winches,
    controller,
    estimator,
    solver_answers,
    solver_interface,
)
from cdpr.testing.case import Case
from cdpr.testing.check import Check, CheckResult
from cdpr.testing.estimator_subject import EstimatorSubject
from cdpr.testing.subjects import BackendSubject, ControllerSubject, SolverSubject

S = TypeVar("S")

BACKEND: list[Check[BackendSubject]] = [
    *backend_interface.CHECKS,
    *backend_physics.CHECKS,
    *backend_winches.CHECKS,
    *backend_guided.CHECKS,
    *backend_load.CHECKS,
    *backend_surroundings.CHECKS,
    *backend_anchors.CHECKS,
]
SOLVER: list[Check[SolverSubject]] = [*solver_interface.CHECKS, *solver_answers.CHECKS]
CONTROLLER: list[Check[ControllerSubject]] = controller.CHECKS
ESTIMATOR: list[Check[EstimatorSubject]] = estimator.CHECKS

ROLES: dict[Role, tuple[Sequence[Check[Any]], Callable[..., AbstractContextManager[Any]]]] = {
    "backend": (BACKEND, BackendSubject),
    "solver": (SOLVER, SolverSubject),
    "controller": (CONTROLLER, ControllerSubject),
    "estimator": (ESTIMATOR, EstimatorSubject),
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
        properties: declared properties: `order`, `snapshot` and `load` (True if supported), `surroundings` (supported
            fields of `Environment`), `threads`, `speed_max` (m/s, if it clamps).
        options: instance of its options model; None by default.
        columns: declared columns; by default the attribute `columns` of the factory.
        expected_failures: reason by id of each check that is known to fail.
        only: ids of the checks to run; all by default.

    Returns:
        The result of each check, in the order of the checks.

    Example:
        >>> import cdpr
        >>> from cdpr.testing import check_backend
        >>> class Still(cdpr.plugins.Backend):
        ...     def reset(self, state):
        ...         self.state[:] = state
        ...     def step(self, n):
        ...         pass
        >>> [result.outcome for result in check_backend(Still, only=["gravity_pulls"])]
        ['failed']
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

    Returns:
        The result of each check, in the order of the checks.

    Example:
        >>> from cdpr.testing import check_solver
        >>> from cdpr_solvers.closed_form import ClosedForm
        >>> results = check_solver(ClosedForm, properties={"exact": True}, only=["answers_balance"])
        >>> [(result.id, result.outcome) for result in results]
        [('answers_balance', 'passed')]
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
        properties: declared properties: `output` (one of `cdpr.plugins.controller.OUTPUTS`), `isotropic` (False if its
            default gains differ between directions), `feedback` (False if its output does not depend on the state),
            `sensors` (types of the sensors that it uses).
        options: instance of its options model; None by default.
        columns: declared columns; by default the attribute `columns` of the factory.
        changeable: changeable options; by default the attribute `changeable` of the factory.
        expected_failures: reason by id of each check that is known to fail.
        only: ids of the checks to run; all by default.

    Returns:
        The result of each check, in the order of the checks.

    Example:
        >>> import cdpr
        >>> from cdpr.testing import check_controller
        >>> class Weight(cdpr.plugins.Controller):
        ...     def control(self, time, state, desired, out):
        ...         out[:] = 0.0
        ...         out[:3] = -self.robot.platform.mass * self.gravity
        >>> [result.outcome for result in check_controller(Weight, only=["output_is_complete"])]
        ['passed']
    """
    return _run(
        CONTROLLER,
        lambda: ControllerSubject(factory, properties, options, columns, changeable),
        expected_failures,
        only,
    )


def check_estimator(
    factory: Callable[[Robot, Array, float, Any, Any], Estimator],
    *,
    properties: Mapping[str, Any] = NOTHING,
    options: Any = None,
    columns: tuple[Column, ...] | None = None,
    expected_failures: Mapping[str, str] = NOTHING,
    only: Collection[str] | None = None,
) -> list[CheckResult]:
    """Check an estimator: `factory(robot, gravity, control_step, sensors, options)`.

    Args:
        factory: target of the plugin's `PluginInfo.factory`.
        properties: declared properties: `sensors` (types of the sensors with which it is checked, ("encoders",) by
            default), `covariance` and `innovation` (True if it provides them).
        options: instance of its options model; None by default.
        columns: declared columns; by default the attribute `columns` of the factory.
        expected_failures: reason by id of each check that is known to fail.
        only: ids of the checks to run; all by default.

    Returns:
        The result of each check, in the order of the checks.

    Example:
        >>> from cdpr.testing import check_estimator
        >>> from cdpr_controllers.estimators import RESIDUAL, ForwardKinematicsOptions
        >>> from cdpr_controllers.estimators.forward_kinematics import ForwardKinematics
        >>> given = {"options": ForwardKinematicsOptions(), "columns": (RESIDUAL,)}
        >>> [result.outcome for result in check_estimator(ForwardKinematics, **given, only=["reset_forgets"])]
        ['passed']
    """
    return _run(ESTIMATOR, lambda: EstimatorSubject(factory, properties, options, columns), expected_failures, only)


def backend_checks(
    name: str, *, options: Any = None, expected_failures: Mapping[str, str] = NOTHING
) -> list[Case[Any]]:
    """Return the checks of an installed backend, for pytest's `parametrize(..., ids=str)`.

    Args:
        name: name of the installed backend.
        options: instance of its options model; the defaults if None.
        expected_failures: reason by id of each check that is known to fail.

    Returns:
        The checks; `str(check)` is the id, and a call raises if the backend fails.

    Raises:
        PluginError: if the backend is unknown, cannot be loaded, or requires options.

    Example:
        >>> from cdpr.testing import backend_checks
        >>> checks = backend_checks("reference")
        >>> checks[0]()
        >>> str(checks[0])
        'arrays_are_kept'
    """
    return _cases("backend", name, options, expected_failures)


def solver_checks(name: str, *, options: Any = None, expected_failures: Mapping[str, str] = NOTHING) -> list[Case[Any]]:
    """Return the checks of an installed solver, for pytest's `parametrize(..., ids=str)`.

    Args:
        name: name of the installed solver.
        options: instance of its options model; the defaults if None.
        expected_failures: reason by id of each check that is known to fail.

    Returns:
        The checks; `str(check)` is the id, and a call raises if the solver fails.

    Raises:
        PluginError: if the solver is unknown, cannot be loaded, or requires options.

    Example:
        >>> from cdpr.testing import solver_checks
        >>> checks = solver_checks("qp")
        >>> checks[0]()
        >>> str(checks[0])
        'inputs_stay_unchanged'
    """
    return _cases("solver", name, options, expected_failures)


def controller_checks(
    name: str, *, options: Any = None, expected_failures: Mapping[str, str] = NOTHING
) -> list[Case[Any]]:
    """Return the checks of an installed controller, for pytest's `parametrize(..., ids=str)`.

    Args:
        name: name of the installed controller.
        options: instance of its options model; the defaults if None.
        expected_failures: reason by id of each check that is known to fail.

    Returns:
        The checks; `str(check)` is the id, and a call raises if the controller fails.

    Raises:
        PluginError: if the controller is unknown, cannot be loaded, or requires options.

    Example:
        >>> from cdpr.testing import controller_checks
        >>> checks = controller_checks("static")
        >>> checks[0]()
        >>> str(checks[0])
        'output_is_complete'
    """
    return _cases("controller", name, options, expected_failures)


def estimator_checks(
    name: str, *, options: Any = None, expected_failures: Mapping[str, str] = NOTHING
) -> list[Case[Any]]:
    """Return the checks of an installed estimator, for pytest's `parametrize(..., ids=str)`.

    Args:
        name: name of the installed estimator.
        options: instance of its options model; the defaults if None.
        expected_failures: reason by id of each check that is known to fail.

    Returns:
        The checks; `str(check)` is the id, and a call raises if the estimator fails.

    Raises:
        PluginError: if the estimator is unknown, cannot be loaded, or requires options.

    Example:
        >>> from cdpr.testing import estimator_checks
        >>> checks = estimator_checks("forward_kinematics")
        >>> checks[0]()
        >>> str(checks[0])
        'estimate_is_complete'
    """
    return _cases("estimator", name, options, expected_failures)


def check_plugin(role: Role, name: str, begin: Callable[[str], object] = str) -> list[CheckResult]:
    """Check an installed plugin with its declared properties and default options.

    Args:
        role: "backend", "controller", "solver" or "estimator".
        name: name of the installed plugin.
        begin: function that gets the id of each check before the check begins.

    Returns:
        The result of each check, in the order of the checks.

    Raises:
        PluginError: if it is unknown or cannot be loaded.

    Example:
        >>> from cdpr.testing import check_plugin
        >>> results = check_plugin("controller", "static")
        >>> {result.outcome for result in results} <= {"passed", "n/a"}
        True
    """
    results = []
    for case in _cases(role, name, None, NOTHING):
        begin(str(case))
        results.append(case.carry_out())
    return results


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
        raise CdprError(f"unknown check {', '.join(unknown)}; allowed: {', '.join(known)}")
