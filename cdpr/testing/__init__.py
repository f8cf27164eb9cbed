"""Conformance kit for backends, solvers and controllers, for authors of plugins and for the built-in plugins.

One list of checks, in three forms:

    from cdpr.testing import check_solver, solver_checks

    results = check_solver(MySolver, properties={"exact": True})  # a factory, as a list of CheckResult

    @pytest.mark.parametrize("check", solver_checks("mine"), ids=str)  # an installed plugin, one test per check
    def test_mine(check):
        check()

    $ cdpr check solver mine

The properties declared in `PluginInfo.properties` select the checks that apply; the others are reported as n/a. Known
failures are passed as `expected_failures={id: reason}`; such a check must fail, or the declaration is out of date.
Times are for information only. Samples and seeds are fixed, so results are reproducible.
"""

from typing import TYPE_CHECKING

from cdpr.base.lazy import lazily
from cdpr.testing.check import CheckResult
from cdpr.testing.kit import (
    backend_checks,
    check_backend,
    check_controller,
    check_plugin,
    check_solver,
    controller_checks,
    solver_checks,
)

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = [
    "CheckResult",
    "backend_checks",
    "check_backend",
    "check_controller",
    "check_plugin",
    "check_solver",
    "controller_checks",
    "solver_checks",
]
