"""The three forms of the kit: checks of a factory, cases for pytest, and results by plugin name."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any

from pydantic import ValidationError

from cdpr.base.errors import CdprError, PluginError
from cdpr.plugins import Column, PluginOptions
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


def check_factory(
    role: Role,
    factory: Callable[..., Any],
    *,
    properties: Mapping[str, Any] = NOTHING,
    options: Any = None,
    columns: tuple[Column, ...] | None = None,
    changeable: tuple[str, ...] | None = None,
    expected_failures: Mapping[str, str] = NOTHING,
    only: Collection[str] | None = None,
) -> list[CheckResult]:
    """Check a plugin that need not be installed.

    Args:
        role: "backend", "controller", "solver" or "estimator".
        factory: its class, or another target of `PluginInfo.factory`, with the arguments of the interface of the role.
        properties: declared properties, as in `PluginInfo.properties`; docs/plugins.md lists them by role. The cost of
            a solver may also be a function.
        options: instance of its options model; None by default.
        columns: declared columns; by default the attribute `columns` of the factory.
        changeable: changeable options; by default the attribute `changeable` of the factory.
        expected_failures: reason by id of each check that is known to fail.
        only: ids of the checks to run; all by default.

    Returns:
        The result of each check, in the order of the checks.

    Raises:
        CdprError: if an id is unknown.

    Example:
        >>> from cdpr.testing import check_factory
        >>> from cdpr_solvers.closed_form import ClosedForm
        >>> results = check_factory("solver", ClosedForm, properties={"exact": True}, only=["answers_balance"])
        >>> [(result.id, result.outcome) for result in results]
        [('answers_balance', 'passed')]
    """
    checks, kind = ROLES[role]
    _refuse_unknown(checks, expected_failures)
    _refuse_unknown(checks, only or ())
    return [
        check.carry_out(kind(factory, properties, options, columns, changeable), expected_failures)
        for check in checks
        if only is None or check.id in only
    ]


def plugin_checks(
    role: Role, name: str, *, options: Any = None, expected_failures: Mapping[str, str] = NOTHING
) -> list[Case[Any]]:
    """Return the checks of an installed plugin, for pytest's `parametrize(..., ids=str)`.

    Args:
        role: "backend", "controller", "solver" or "estimator".
        name: name of the installed plugin.
        options: instance of its options model; the defaults if None.
        expected_failures: reason by id of each check that is known to fail.

    Returns:
        The checks; `str(check)` is the id, and a call raises if the plugin fails.

    Raises:
        PluginError: if the plugin is unknown, cannot be loaded, or requires options.

    Example:
        >>> from cdpr.testing import plugin_checks
        >>> checks = plugin_checks("solver", "qp")
        >>> checks[0]()
        >>> str(checks[0])
        'inputs_stay_unchanged'
    """
    entry = registry().get(role, name)
    factory = entry.load()
    try:
        chosen: PluginOptions = entry.info.options() if options is None else options
    except ValidationError:
        raise PluginError(
            f"{role} '{name}' needs options, such as a file: check it from Python, "
            f"plugin_checks('{role}', '{name}', options=...)"
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
    for case in plugin_checks(role, name):
        begin(str(case))
        results.append(case.carry_out())
    return results


def _refuse_unknown(checks: Sequence[Check[Any]], ids: Collection[str]) -> None:
    known = [check.id for check in checks]
    if unknown := sorted(set(ids) - set(known)):
        raise CdprError(f"unknown check {', '.join(unknown)}; allowed: {', '.join(known)}")
