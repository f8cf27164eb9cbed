"""Conformance kit of all roles, for authors of plugins and for the built-in plugins.

One list of checks, in three forms: `check_solver` returns the results for a factory, `solver_checks` the checks of an
installed plugin for pytest, and `cdpr check solver NAME` prints them; likewise for other roles.

The properties declared in `PluginInfo.properties` select the checks that apply; the others are reported as n/a. Known
failures are passed as `expected_failures={id: reason}`; such a check must fail, or the declaration is out of date.
Times are for information only. Samples and seeds are fixed, so results are reproducible.

Example:
    >>> from cdpr.testing import check_solver, solver_checks
    >>> from cdpr_solvers.closed_form import ClosedForm
    >>> [str(result.outcome) for result in check_solver(ClosedForm, only=["answers_balance"])]  # of a factory
    ['passed']
    >>> str(solver_checks("closed_form")[0])  # of an installed plugin, for `pytest.mark.parametrize`
    'inputs_stay_unchanged'
"""

from typing import TYPE_CHECKING

from cdpr.base.lazy import lazily
from cdpr.testing.check import CheckResult
from cdpr.testing.kit import (
    backend_checks,
    check_backend,
    check_controller,
    check_estimator,
    check_plugin,
    check_solver,
    controller_checks,
    estimator_checks,
    solver_checks,
)

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = [
    "CheckResult",
    "backend_checks",
    "check_backend",
    "check_controller",
    "check_estimator",
    "check_plugin",
    "check_solver",
    "controller_checks",
    "estimator_checks",
    "solver_checks",
]
