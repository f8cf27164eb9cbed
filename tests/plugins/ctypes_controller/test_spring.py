"""The conformance kit, and the same bits from C and Python."""

import numpy as np
import pytest
from cdpr_spring import Options
from cdpr_spring.controller import Spring

from cdpr.testing import plugin_checks, samples


@pytest.mark.parametrize("check", plugin_checks("controller", "spring"), ids=str)
def test_spring(check):
    check()


def test_same_bits():
    rng = np.random.default_rng(0)
    spring = Spring(samples.braced(), samples.GRAVITY, 1e-3, Options())
    state, desired, compiled, python = np.empty(13), np.empty(19), np.empty(6), np.empty(6)
    call = spring.compiled(state, desired, compiled)
    for _ in range(1000):
        state[:], desired[:] = rng.normal(size=13), rng.normal(size=19)
        assert call() == 0
        spring.control(0.0, state, desired, python)
        np.testing.assert_array_equal(compiled, python)
