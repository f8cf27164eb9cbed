"""Comparison of several solvers on one wrench at one pose, with independent checks of the answers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median
from time import perf_counter_ns
from typing import Any

import numpy as np

from cdpr.base.problems import short_repr
from cdpr.model.robot import Array, read_only
from cdpr.tension.checks import LIMIT_TOLERANCE, allowed_residual, newton
from cdpr.tension.compiled import accept_tension
from cdpr.tension.problem import Problem
from cdpr.tension.stage import Solve
from cdpr.tension.status import Status

# limits of the number and total time of calls to measure the time of a call
CALLS = 200
SECONDS = 0.02

REASONS = {
    Status.INFEASIBLE: "reports that no tensions within the limits balance the wrench",
    Status.NOT_FOUND: "found no tensions",
    Status.UNSUPPORTED: "does not support this robot or pose: 'cdpr solvers NAME' shows its properties",
    Status.BAD_INPUT: "refused its input",
}


@dataclass(frozen=True)
class Contestant:
    """Solver in a comparison."""

    name: str
    make: Callable[[], Solve]
    respects_bounds: bool = True  # as it declares
    absent: str = ""  # reason why it cannot be used, if any


@dataclass(frozen=True, eq=False)
class Answer:
    """Answer of a solver to a problem."""

    solver: str
    status: Status | None  # returned status; None if the solver was not created, raised, or returned something else
    reason: str = ""  # reason of a missing or inadmissible answer; "" if admissible
    true: bool = True  # True if the answer passes the checks and agrees with the solver's declarations
    tension: Array | None = None  # (m,), N, as written by the solver; None unless the status is OK
    residual: float = math.nan  # N, moments divided by the characteristic length
    margin: float = math.nan  # N, smallest distance from a limit; negative if exceeded
    at_limit: int = 0  # cables at a limit or beyond it
    seconds: float | None = None  # median of repeated calls

    @property
    def admissible(self) -> bool:
        """True if the tensions are finite, within the limits, and balance the wrench."""
        return self.tension is not None and not self.reason


def compare(
    problem: Problem, contestants: Sequence[Contestant], progress: Callable[[int, int], None] | None = None
) -> list[Answer]:
    """Distribute the wrench with each solver, and check each result independently.

    Args:
        problem: pose and wrench.
        contestants: the solvers.
        progress: called after each solver with the number of finished solvers and the total.
    """
    answers = []
    for contestant in contestants:
        answers.append(_answer_of(problem, contestant))
        if progress is not None:
            progress(len(answers), len(contestants))
    return answers


def _answer_of(problem: Problem, contestant: Contestant) -> Answer:
    robot, name = problem.robot, contestant.name
    if contestant.absent:
        return Answer(name, None, contestant.absent)
    tension = np.full(robot.m, np.nan)
    try:
        solve = contestant.make()
        arguments = (read_only(problem.W), read_only(problem.wanted), robot.tension_min, robot.tension_max)
        code = solve(*arguments, tension)
        seconds = _time(solve, arguments, np.empty(robot.m))
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        text = " ".join(str(error).split())
        return Answer(name, None, f"raised {type(error).__name__}: {text}".removesuffix(": "))
    try:
        status = Status(code)
    except ValueError:
        return Answer(name, None, f"returned {short_repr(code)}, which is not a status", seconds=seconds)
    if status != Status.OK:
        wrong = status == Status.INFEASIBLE and problem.feasible
        return Answer(name, status, REASONS[status] + wrong * "; but such tensions exist", not wrong, seconds=seconds)
    low, high = problem.limits
    _, report = accept_tension(problem.W, problem.wanted, problem.weights, low, high, tension)
    accepted, residual, margin, at_limit = report.tolist()
    reason, true = "", accepted == Status.OK
    if not np.isfinite(tension).all():
        reason, at_limit = "returns OK, but some tensions are not finite", 0.0
    elif not residual <= allowed_residual(problem.wanted, problem.weights, problem.limits):
        reason = f"returns OK, but leaves {residual:.3g} N unbalanced"
    elif margin < -LIMIT_TOLERANCE * newton(problem.limits):
        true = not contestant.respects_bounds
        reason = f"{'ignores the limits and' if true else 'returns OK, but'} goes {-margin:.4g} N beyond them"
    judged = {"residual": residual, "margin": margin}
    return Answer(name, status, reason, true, tension, at_limit=int(at_limit), seconds=seconds, **judged)


def _time(solve: Solve, arguments: tuple[Array, Array, Array, Array], tension: Array) -> float:
    """Return the median time of a call, s, each with a fresh result array."""
    times: list[int] = []
    end = perf_counter_ns() + round(1e9 * SECONDS)
    while len(times) < CALLS and (len(times) < 3 or perf_counter_ns() < end):
        tension[:] = np.nan
        start = perf_counter_ns()
        solve(*arguments, tension)
        times.append(perf_counter_ns() - start)
    return 1e-9 * median(times)


def describe(problem: Problem, answers: Sequence[Answer], source: str, wrench_source: str) -> dict[str, Any]:
    """Return problem and answers as plain figures with units in their names.

    `source` and `wrench_source` describe the origin of pose and wrench. `time_us` is the only figure that varies
    between calls.
    """
    robot = problem.robot
    rank, condition = problem.conditioning
    space: dict[str, Any] | None = None
    if problem.general is not None:
        c, N = problem.general
        space = {"dimension": N.shape[1], "particular_N": c.tolist(), "basis": N.tolist()}
        space["safest_N"] = None if problem.safest is None else problem.safest[1].tolist()
        if problem.corners is not None:
            space["corners_N"] = problem.corners.tolist()
    return {
        "robot": robot.name,
        "dof": list(robot.dof),
        "n": robot.n,
        "m": robot.m,
        "redundancy": robot.m - robot.n,
        "pose": {
            "source": source,
            "position_m": problem.pose[:3].tolist(),
            "orientation_wxyz": problem.pose[3:].tolist(),
        },
        "wrench": {"source": wrench_source, "value": problem.wrench.tolist()},
        "characteristic_length_m": robot.characteristic_length,
        "rank": rank,
        "condition_number": condition,
        "cables": [
            {"name": cable.name, "tension_min_N": cable.tension_min, "tension_max_N": cable.tension_max}
            for cable in robot.cables
        ],
        "reachable": problem.general is not None,
        "feasible": problem.feasible,
        "ranges_N": problem.ranges.tolist() if np.isfinite(problem.limits).all() else None,
        "largest_margin_N": None if problem.safest is None else problem.safest[0],
        "null_space": space,
        "solvers": [_figures(problem, answer) for answer in answers],
    }


def _figures(problem: Problem, answer: Answer) -> dict[str, Any]:
    t, x = answer.tension, None
    finite = t is not None and bool(np.isfinite(t).all())
    if t is not None and finite and problem.general is not None:
        with np.errstate(over="ignore", invalid="ignore"):
            x = problem.x(t)
    return {
        "solver": answer.solver,
        "status": None if answer.status is None else answer.status.name,
        "admissible": answer.admissible,
        "true": answer.true,
        "reason": answer.reason,
        "tension_N": None if t is None else t.tolist(),
        "null_space_N": x.tolist() if x is not None and np.isfinite(x).all() else None,
        "norm_N": None if t is None else math.hypot(*t),
        "margin_N": answer.margin,
        "at_limit": answer.at_limit if finite else None,
        "residual_N": answer.residual,
        "time_us": None if answer.seconds is None else 1e6 * answer.seconds,
    }
