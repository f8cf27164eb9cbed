"""Conformance kit of all roles, for authors of plugins and for the built-in plugins.

One list of checks for each role, in three forms: `check_factory` returns the results for a class, `plugin_checks` the
checks of an installed plugin for pytest, and `cdpr check ROLE NAME` prints them.

The properties declared in `PluginInfo.properties` select the checks that apply; the others are reported as n/a. Known
failures are passed as `expected_failures={id: reason}`; such a check must fail, or the declaration is out of date.
Times are for information only. Samples and seeds are fixed, so results are reproducible.

Example:
    >>> from cdpr.testing import check_factory, plugin_checks
    >>> from cdpr_solvers.closed_form import ClosedForm
    >>> [str(result.outcome) for result in check_factory("solver", ClosedForm, only=["answers_balance"])]
    ['passed']
    >>> str(plugin_checks("solver", "closed_form")[0])
    'inputs_stay_unchanged'
"""

from typing import TYPE_CHECKING

from cdpr.base.lazy import lazily
from cdpr.testing.check import CheckResult
from cdpr.testing.kit import check_factory, check_plugin, plugin_checks

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = ["CheckResult", "check_factory", "check_plugin", "plugin_checks"]
