"""Run each check of the conformance kit of cdpr as one test."""

import pytest

from cdpr.testing import solver_checks


@pytest.mark.parametrize("check", solver_checks("weighted"), ids=str)
def test_weighted(check):
    check()
