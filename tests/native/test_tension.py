"""Functions of tension distribution in the kernel library."""

from __future__ import annotations

import doctest
from importlib import import_module

import numpy as np
import pytest

from cdpr.tension.admissible import admissible_corners, farthest_from_limits
from cdpr.tension.status import Status
from cdpr_solvers import qp

SOLVERS = (
    *("analytic_centre", "best_effort", "centroid", "dykstra", "improved_closed_form", "improved_puncture", "qp"),
    *("infinity_norm", "kernel_method", "lp", "maximin", "p_norm", "puncture", "closed_form", "pseudo_inverse"),
)
ROOMS = ("active_set", "admissible", "box_least_squares", "compiled", "policy", "row_space")
MODULES = [*(f"cdpr.tension.{name}" for name in ROOMS), *(f"cdpr_solvers.{name}" for name in SOLVERS)]


@pytest.mark.parametrize("module", MODULES)
def test_functions_match_their_docs(module):
    found = doctest.testmod(import_module(module))
    assert found.attempted
    assert not found.failed


def test_least_norm_near_something_else():
    W = np.array([[1.0, -1.0, 0.5], [0.2, 0.3, -1.0]])
    t, low, high = np.array([30.0, 20.0, 25.0]), np.full(3, 1.0), np.full(3, 100.0)
    tension, status = qp.minimum_norm_tension(W, W @ t, low, high, about="given", reference=t)
    assert status == Status.OK
    np.testing.assert_allclose(tension, t)
    for options in ({"change": 0.5}, {"about": "previous"}):
        tension, status = qp.minimum_norm_tension(W, W @ t, low, high, previous=t, **options)
        assert np.abs(tension - t).max() <= 0.5 + 1e-9
    with pytest.raises(ValueError, match="about: unknown value 'nothing'; allowed: zero, middle, previous, given"):
        qp.minimum_norm_tension(W, W @ t, low, high, about="nothing")
    assert qp.minimum_norm_tension(W, W @ t, low, [100.0, np.inf, 100.0], about="middle")[1] == Status.UNSUPPORTED


def test_functions_reject_wrong_shapes():
    with pytest.raises(ValueError, match=r"basis: expected shape \(m, 1\) or \(m, 2\)"):
        admissible_corners(np.ones((4, 3)), np.zeros(4), np.zeros(4), np.ones(4))
    with pytest.raises(ValueError, match="safest_point: box: expected shape"):
        farthest_from_limits(np.ones((4, 3)), np.zeros(3), np.zeros(3), np.ones(3))
