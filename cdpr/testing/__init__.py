"""The conformance kit: proves a backend, a solver or a controller right. For plugin authors, and for our own plugins.

One list of checks, in three forms:

    from cdpr.testing import check_solver, solver_checks

    results = check_solver(MySolver, properties={"exact": True})  # a factory, as a list of CheckResult

    @pytest.mark.parametrize("check", solver_checks("mine"), ids=str)  # an installed plugin, one test a check
    def test_mine(check):
        check()

    $ cdpr check solver mine

What a plugin declares in `PluginInfo.properties` decides which checks apply; the others are reported as n/a. A failure
that is known is passed as `expected_failures={id: reason}`; it must then fail, or the declaration is out of date. The
seconds of a result inform and are never judged. Samples and seeds are fixed: a check says the same each time.
"""

from typing import TYPE_CHECKING

from cdpr.lazy import lazily
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
