"""Reference results by HiGHS and DAQP: feasibility, margins and optima, independent of the solvers under test."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.bench.adversaries import BAND, Adversaries
from cdpr.analysis.bench.problems import Problems
from cdpr.base.errors import MissingPackageError
from cdpr.model.robot import Array

try:
    import daqp
    from scipy.optimize import linprog
except ImportError as error:
    raise MissingPackageError(f"the benchmark needs scipy and daqp ({error}): pip install 'cdpr[solvers]'") from error

# Share of the largest limit: problems with a smaller absolute margin count as neither feasible nor infeasible, because
# round-off decides.
UNDECIDED = 1e-7

# Smallest tolerance that HiGHS accepts; problems are scaled to tensions near 1.
LP_OPTIONS = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
QP_TOLERANCE = 1e-11  # same for DAQP

SOLVED, IMPOSSIBLE = 0, 2  # status codes of linprog
UNIQUE = ("min_norm", "mid_range")  # objectives with a unique optimum: answers are compared by tensions
COSTS = ("one_norm", "max_slack")  # objectives of linear programs, possibly with several optima: compared by cost
OBJECTIVES = (*UNIQUE, *COSTS)


@dataclass(frozen=True, eq=False)
class Oracle:
    """Reference results of K problems.

    Attributes:
        margin: (K,), N, the largest s with W t = wrench, t_min + s <= t <= t_max - s; -inf if W t = wrench has no
            solution.
        feasible: (K,), certainly feasible problems.
        infeasible: (K,), certainly infeasible problems.
        optima: optimal tensions (K, m), N, by objective; NaN if the problem is not feasible.
        edge: (K,), certainly feasible problems that are too close to infeasibility to count as `feasible`.
    """

    margin: Array
    feasible: NDArray[np.bool_]
    infeasible: NDArray[np.bool_]
    optima: dict[str, Array]
    edge: NDArray[np.bool_]

    def first(self, count: int) -> Oracle:
        """Return the results of the first `count` problems."""
        optima = {name: values[:count] for name, values in self.optima.items()}
        return Oracle(self.margin[:count], self.feasible[:count], self.infeasible[:count], optima, self.edge[:count])


def certified(problems: Adversaries) -> Oracle:
    """Return the known results of constructed problems, within their error band.

    The margin is that of the solution from which a problem was constructed, a lower bound of the largest. It has no
    meaning for infeasible problems.
    """
    safe = problems.feasible & (problems.slack > BAND)
    margin = problems.slack * np.abs(problems.high).max(axis=1)
    return Oracle(margin, safe, ~problems.feasible, {}, problems.feasible & ~safe)


def consult(problems: Problems, objectives: Sequence[str] = ()) -> Oracle:
    """Return the reference results of all problems, with the optima of those `objectives` that are in `OBJECTIVES`."""
    robot = problems.robot
    scale = float(robot.tension_max.max())
    t_min, t_max = robot.tension_min / scale, robot.tension_max / scale
    weights = problems.weights
    margin = np.empty(len(problems))
    optima = {name: np.full((len(problems), robot.m), np.nan) for name in OBJECTIVES if name in objectives}
    for k, (W, wrench) in enumerate(zip(problems.W, problems.wrench, strict=True)):
        A, b = weights[:, None] * W, weights * wrench / scale
        margin[k], roomiest = _largest_margin(A, b, t_min, t_max)
        if margin[k] > UNDECIDED:
            for name, found in optima.items():
                found[k] = scale * (roomiest if name == "max_slack" else _optimum(name, A, b, t_min, t_max))
    no_edge = np.zeros(len(problems), dtype=bool)  # none: HiGHS is not certain there
    return Oracle(scale * margin, margin > UNDECIDED, margin < -UNDECIDED, optima, no_edge)


def _largest_margin(A: Array, b: Array, t_min: Array, t_max: Array) -> tuple[float, Array]:
    """Return the largest s with A t = b, t_min + s <= t <= t_max - s, and such a t; -inf if A t = b has no solution."""
    n, m = A.shape
    eye, one = np.eye(m), np.ones((m, 1))
    within = np.block([[-eye, one], [eye, one]])
    equal = np.hstack([A, np.zeros((n, 1))])
    cost = np.append(np.zeros(m), -1.0)
    answer = linprog(cost, within, np.append(-t_min, t_max), equal, b, (None, None), options=LP_OPTIONS)
    if answer.status == IMPOSSIBLE:
        return -np.inf, np.full(m, np.nan)
    if answer.status != SOLVED:
        return np.nan, np.full(m, np.nan)  # undecided
    return float(answer.x[m]), answer.x[:m]


def _optimum(objective: str, A: Array, b: Array, t_min: Array, t_max: Array) -> Array:
    """Return the optimal t; NaN if the library finds none."""
    n, m = A.shape
    if objective == "one_norm":
        answer = linprog(np.ones(m), None, None, A, b, np.array([t_min, t_max]).T, options=LP_OPTIONS)
        return np.asarray(answer.x) if answer.status == SOLVED else np.full(m, np.nan)
    target = 0.5 * (t_min + t_max) if objective == "mid_range" else np.zeros(m)
    sense = np.array([0] * m + [5] * n, dtype=np.int32)  # sense of the constraints: limits, then equalities
    upper, lower = np.append(t_max, b), np.append(t_min, b)
    t, _, flag, _ = daqp.solve(np.eye(m), -target, A.copy(), upper, lower, sense, primal_tol=QP_TOLERANCE)
    return np.asarray(t) if flag == 1 else np.full(m, np.nan)
