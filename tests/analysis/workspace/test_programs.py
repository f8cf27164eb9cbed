"""Workspaces against linear programs that HiGHS solves directly, by the ten thousand."""

from __future__ import annotations

import itertools
import os

import numpy as np
import pytest
from workspace_cases import poses_of, problem, robot_of

from cdpr.analysis.workspace import box, measure

highspy = pytest.importorskip("highspy")

pytestmark = pytest.mark.slow

ROBOTS = ["cogiro", "caroca", "ipanema_1", "planar", "point_mass", "seven"]
CASES = int(os.environ.get("CDPR_WORKSPACE_CASES", "1"))
POSES = 1500 * CASES  # of each: 9000 in all
FEASIBLE_POSES = 45 * CASES  # of each: 270, with up to 64 programs each
# N, and of a closure whose vectors have length 1: closer to zero the program's tolerance of 1e-10 N decides, which is
# magnified by what the largest tension, 1e4 N, is over it. Nearer ones are counted, and must be few.
UNSURE = 1e-4
FEW = 1e-3  # share


class Program:
    """The largest s with W t = wrench, low + s <= t <= high - s."""

    def __init__(self, m, n):
        self.highs, self.m, self.n = highspy.Highs(), m, n
        self.highs.setOptionValue("output_flag", False)
        for name in ("primal_feasibility_tolerance", "dual_feasibility_tolerance"):
            self.highs.setOptionValue(name, 1e-10)

    def most(self, W, wrench, low, high):
        m, n = self.m, self.n
        model = highspy.HighsLp()
        model.num_col_, model.num_row_ = m + 1, n + 2 * m
        model.sense_ = highspy.ObjSense.kMaximize
        model.col_cost_ = np.append(np.zeros(m), 1.0)
        model.col_lower_, model.col_upper_ = np.full(m + 1, -np.inf), np.append(np.full(m, np.inf), 1e6)
        model.row_lower_ = np.concatenate([wrench, low, np.full(m, -np.inf)])
        model.row_upper_ = np.concatenate([wrench, np.full(m, np.inf), high])
        above = np.hstack([np.eye(m), -np.ones((m, 1))])
        below = np.hstack([np.eye(m), np.ones((m, 1))])
        matrix = np.vstack([np.hstack([W, np.zeros((n, 1))]), above, below])
        packed = model.a_matrix_
        packed.format_ = highspy.MatrixFormat.kColwise
        packed.start_ = np.arange(0, matrix.size + 1, len(matrix))
        packed.index_ = np.tile(np.arange(len(matrix)), m + 1)
        packed.value_ = matrix.ravel(order="F")
        self.highs.passModel(model)
        self.highs.run()
        status = self.highs.getModelStatus()
        if status == highspy.HighsModelStatus.kInfeasible:
            return -np.inf
        assert status == highspy.HighsModelStatus.kOptimal
        return self.highs.getInfo().objective_function_value


def agree(values, answers):
    """No value and its program are of different signs but within UNSURE of zero, and few are."""
    values, answers = np.array(values), np.array(answers)
    sure = (np.abs(values) > UNSURE) & (np.abs(answers) > UNSURE)
    assert ((values > 0.0) == (answers > 0.0))[sure].all()
    assert (~sure).mean() <= FEW
    assert (values[sure] > 0.0).any()


@pytest.mark.parametrize("name", ROBOTS)
def test_static(name):
    robot, poses = robot_of(name), poses_of(robot_of(name), POSES, seed=7)
    program, found = Program(robot.m, robot.n), measure(robot, poses)
    answers = []
    for pose in poses:
        W, wrench, _ = problem(robot, pose)
        answers.append(program.most(W, wrench, robot.tension_min, robot.tension_max))
    regular = ~found.singular
    agree(found.value[regular], np.array(answers)[regular])


@pytest.mark.parametrize("name", ROBOTS)
def test_wrench_closure(name):
    robot, poses = robot_of(name), poses_of(robot_of(name), POSES, seed=8)
    program, found = Program(robot.m, robot.n), measure(robot, poses, "closure")
    zero, one = np.zeros(robot.m), np.ones(robot.m)
    answers = [program.most(problem(robot, pose)[0], np.zeros(robot.n), zero, one) for pose in poses]
    regular = ~found.singular
    # s = 0 is always there, so that what is not closed has 0, not less: as far below as others are above.
    shown = np.where(np.array(answers) > UNSURE, 1.0, -1.0)
    values = found.value[regular]
    near = np.abs(values) <= 10 * UNSURE
    assert ((values > 0.0) == (shown[regular] > 0.0))[~near].all()
    assert near.mean() <= 20 * FEW


@pytest.mark.parametrize("name", ROBOTS)
def test_wrench_feasible_at_all_corners(name):
    robot, poses = robot_of(name), poses_of(robot_of(name), FEASIBLE_POSES, seed=9)
    half = np.zeros(6)
    half[robot.rows] = np.repeat([20.0, 2.0], 3)[robot.rows]
    program, found = Program(robot.m, robot.n), measure(robot, poses, required=box(half))
    corners = np.array([*itertools.product((-1.0, 1.0), repeat=robot.n)])
    answers = []
    for pose in poses:
        W, wrench, weights = problem(robot, pose)
        far = corners * (weights * half[robot.rows])
        answers.append(min(program.most(W, wrench + each, robot.tension_min, robot.tension_max) for each in far))
    regular = ~found.singular
    agree(found.value[regular], np.array(answers)[regular])
