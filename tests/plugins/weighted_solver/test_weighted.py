"""Run each check of the conformance kit of cdpr as one test."""

import pytest

from cdpr.testing import plugin_checks


@pytest.mark.parametrize("check", plugin_checks("solver", "weighted"), ids=str)
def test_weighted(check):
    check()
