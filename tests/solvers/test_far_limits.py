"""Solvers where a limit is as good as none, and where the admissible tensions are a set that is flat but long."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from cdpr.analysis.bench.adversaries import robots
from cdpr.plugins.registry import registry
from cdpr.tension import Status

FAR = 2.0**39  # N: the limit of a cable that has none

CLOSE = 1e-6  # of the largest tension: how far the least exact of these solvers are from their optimum


def ask(name, W, wrench, low, high, **options):
    W, wrench, low, high = (np.array(each, dtype=float) for each in (W, wrench, low, high))
    robot = next(robot for robot in robots() if (robot.n, robot.m) == W.shape)
    entry = registry().get("solver", name)
    t = np.full(robot.m, np.nan)
    status = entry.make(robot, entry.read_options(options)).solve(W, wrench, low, high, t)
    return Status(status), t


@pytest.mark.parametrize("name", ["daqp", "clarabel", "piqp", "osqp", "highs", "exact", "qp", "lp"])
def test_a_limit_that_is_as_good_as_none_costs_no_accuracy(name):
    if registry().get("solver", name).missing:
        pytest.skip("not installed")
    status, t = ask(name, [[1, 2, 0], [0, 0, 1]], [1164, 513], [0, 388, 0], [388, FAR, FAR])
    least = [0, 582, 513] if name in ("highs", "lp") else [232.8, 465.6, 513]  # t_1 + 2 t_2 = 1164, by hand
    assert status == Status.OK
    np.testing.assert_allclose(t, least, rtol=0, atol=CLOSE * 582)


def test_the_middle_of_a_limit_that_is_as_good_as_none_leaves_no_round_off():
    W = np.array([[0.41738, -0.15134, -0.11351, -0.81518, 0.35753], [-0.90867, -0.47515, 0.15610, -0.42634, 0.68396]])
    W = np.vstack([W, [0.00965, -0.86679, 0.98119, 0.39204, -0.63589]])
    solution = np.array([154.0, 923.0, 1183.0, 12.0, 573.0])
    low, high = np.zeros(5), np.array([287.0, FAR, FAR, FAR, FAR])
    wrench = W @ solution
    status, t = ask("qp", W, wrench, low, high, about="middle")
    assert status == Status.OK
    assert np.abs(W @ t - wrench).max() <= 1e-12 * t.max()
    # The nearest point to a distant point is the farthest one in that direction: a linear program in the far cables.
    most = linprog([0, -1, -1, -1, -1], A_eq=W, b_eq=wrench, bounds=[*zip(low, [287.0, *[1e6] * 4], strict=True)])
    np.testing.assert_allclose(t, most.x, rtol=0, atol=CLOSE * t.max())


@pytest.mark.parametrize("width", [0.0, 2.0**-34])
@pytest.mark.parametrize("turn", [0.0, 0.3])  # the same equations, rotated: nothing is a round number any more
def test_the_centre_of_a_flat_set_is_in_its_middle(width, turn):
    """Cables 1 and 2 are as good as held by each other's limits; t_3 + 2 t_4 = 300 is all that 3 and 4 have to do."""
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    W = rotation @ [[1, -1, 0, 0], [0, 0, 1, 2]]
    status, t = ask("analytic_centre", W, rotation @ [0, 300], [0, 100 - width, 0, 0], [100 + width, 500, 200, 200])
    assert status == Status.OK
    np.testing.assert_allclose(t, [100, 100, 100, 100], rtol=0, atol=1e-8)


def test_the_centre_is_found_where_one_direction_is_far_longer_than_the_others():
    W = [[0, 0, 2, -2, 3], [0, -2, -3, 2, -3], [0, 0, 1, 2, 3]]
    high = [2.0**36, 2.0**36, 401, 1436, 2.0**36]
    status, t = ask("analytic_centre", W, [1994.8782348632812, -3813.7672119140625, 4445.7286376953125], [0] * 5, high)
    assert status == Status.OK
    assert t[0] == pytest.approx(2.0**35)  # which nothing else depends on


@pytest.mark.parametrize(
    ("W", "wrench", "high"),
    [
        ([[0, -1, -2, -1], [0, 2, -1, 1]], [17687799.0, -28987813.0], [np.inf, np.inf, np.inf, 36510977.0]),
        ([[1, -1, 0, 0], [0, 0, 1, 0]], [2.0, 3.0], [9.0, 9.0, 9.0, np.inf]),
    ],
)
def test_there_is_no_centre_where_a_tension_has_no_end(W, wrench, high):
    """The farther, the lower the barrier, however near other limits are: an answer would be round-off."""
    status, _ = ask("analytic_centre", W, wrench, [0.0, -19056200.0, -5042881.0, -36510977.0], high)
    assert status == Status.UNSUPPORTED
