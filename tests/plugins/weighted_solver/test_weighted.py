"""The conformance kit of cdpr, one test a check."""

import pytest

from cdpr.testing import solver_checks


@pytest.mark.parametrize("check", solver_checks("weighted"), ids=str)
def test_weighted(check):
    check()
