"""Checks of a tension solver's answers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.bench import adversaries
from cdpr.analysis.bench.continuity import Path, steepest
from cdpr.analysis.bench.poison import POISON, Memory
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.tension import Status
from cdpr.tension.active_set import extreme_point
from cdpr.testing import samples
from cdpr.testing.check import Check, expect, expect_close, needs
from cdpr.testing.samples import Problem
from cdpr.testing.solver_interface import expect_balanced
from cdpr.testing.subjects import Cost, SolverSubject, solve

MANY, FEW = 400, 20  # adversarial problems per robot size, for fast and slow solvers

# Steps, as shares of the way to another admissible answer, that must not lower a plugin's cost.
STEPS = (1e-2, 1e-4, 1e-6)

ROUND_OFF = 1e-13  # of a cost that is a sum over some cables

INSIDE = 1e-6  # share of the largest limit: closer to a limit, a cable counts as at the limit


def _answered(subject: SolverSubject) -> Iterator[tuple[Problem, Array]]:
    """Yield all feasible problems that the solver answers with OK."""
    for group in subject.limited(samples.feasible()):
        solver = subject.make(group[0].robot)
        for problem in group:
            status, tension = solve(solver, problem)
            if status == Status.OK:
                yield problem, tension


def answers_balance(subject: SolverSubject) -> str:
    """If the status is OK, W t equals the wrench.

    The relative tolerance is 1e-9 if the solver declares `exact`, and 1e-6 otherwise.
    """
    count = 0
    started = perf_counter()
    for problem, tension in _answered(subject):
        expect_balanced(subject, problem, tension)
        count += 1
    expect(count, "it answered none of the feasible problems")
    posed = sum(map(len, subject.limited(samples.feasible())))
    return f"{count} of {posed} answered, {perf_counter() - started:.2g} s in all"


def answers_are_within_the_limits(subject: SolverSubject) -> None:
    """If the status is OK, all tensions are within the limits. The tolerance is 1e-6 N.

    Skipped if the solver declares `respects_bounds: false`.
    """
    needs(subject.respects_bounds, "it declares respects_bounds: false")
    for problem, tension in _answered(subject):
        over = float(np.maximum(problem.t_min - tension, tension - problem.t_max).max())
        expect(over <= 1e-6 * min(1.0, float(problem.t_max.max())), f"OK, but {over:.3g} N beyond a limit")


def what_can_be_solved_is_solved(subject: SolverSubject) -> None:
    """The solver solves every feasible problem.

    If the solver declares `max_redundancy`, problems with more redundant cables than this number may have the status
    UNSUPPORTED instead. Skipped if the solver does not declare `coverage: full`.
    """
    needs(subject.properties.get("coverage") == "full", "it does not declare coverage: full")
    most = subject.properties.get("max_redundancy", "any")
    for group in subject.limited(samples.feasible()):
        robot = group[0].robot
        allowed = [Status.OK] if most == "any" or robot.m - robot.n <= most else [Status.OK, Status.UNSUPPORTED]
        solver = subject.make(robot)
        missed = sum(solve(solver, problem)[0] not in allowed for problem in group)
        expect(not missed, f"{missed} of {len(group)} feasible problems have no answer with {robot.m} cables")


def infeasible_is_never_ok(subject: SolverSubject) -> None:
    """The status of an infeasible problem is never OK.

    Skipped if the solver declares `respects_bounds: false`.
    """
    needs(subject.respects_bounds, "it declares respects_bounds: false")
    for group in subject.limited(samples.infeasible()):
        solver = subject.make(group[0].robot)
        wrong = sum(solve(solver, problem)[0] == Status.OK for problem in group)
        expect(not wrong, f"{wrong} of {len(group)} infeasible problems are OK with {group[0].robot.m} cables")


def unreachable_is_never_ok(subject: SolverSubject) -> None:
    """If no tensions balance the wrench, not even tensions outside the limits, the status is not OK.

    The kit tests robots with too few cables, and singular matrices W.
    """
    rng = np.random.default_rng(50)
    robot = samples.sparse()
    solver = subject.make(robot)
    for _ in range(100):
        problem = samples.problem(robot, samples.state(rng, tilt=0.3), rng.uniform(10.0, 100.0, robot.m))
        nowhere = np.linalg.svd(problem.W)[0][:, -1]  # orthogonal to the reach of the cables
        status, _ = solve(solver, problem.with_wrench(problem.wrench + 100.0 * nowhere))
        expect(status != Status.OK, "OK with 4 cables for 6 degrees of freedom and a wrench outside their span")
    for problem in samples.feasible()[2][:50]:
        flat = problem.W.copy()
        flat[-1] = flat[0]
        status, _ = solve(subject.make(problem.robot), replace(problem, W=flat))
        expect(status != Status.OK, "OK with a singular W and a wrench outside its range")


def limits_are_the_arguments(subject: SolverSubject) -> None:
    """The solver uses the limits `t_min` and `t_max` of each call, not those of the robot.

    The kit solves a problem. Then it multiplies the limits and the wrench by 1000 and solves the problem again. The
    second tensions must be 1000 times as large as the first.
    """
    for group in samples.feasible():
        solver = subject.make(group[0].robot)
        for problem in group[:50]:
            status, tension = solve(solver, problem)
            larger = replace(problem, wrench=1e3 * problem.wrench, t_min=1e3 * problem.t_min, t_max=1e3 * problem.t_max)
            status_2, tension_2 = solve(solver, larger)
            expect(status == status_2, f"status {status}, but {status_2} with 1000 times limits and wrench")
            if status == Status.OK:
                allowed = max(1e-6, 10 * subject.accuracy) * float(problem.t_max.max())
                expect_close(tension_2 / 1e3, tension, allowed, "tensions of the scaled problem, N")


def cables_may_come_in_any_order(subject: SolverSubject) -> None:
    """If the order of the cables changes, each cable keeps its tension.

    Skipped if the solver declares `continuity: jump`.
    """
    needs(subject.properties.get("continuity") != "jump", "it declares continuity: jump")
    for k, group in enumerate(samples.feasible()):
        order = np.random.default_rng(60 + k).permutation(group[0].robot.m)
        robot = replace(group[0].robot, cables=tuple(group[0].robot.cables[i] for i in order))
        solver, other = subject.make(group[0].robot), subject.make(robot)
        for problem in group[:50]:
            status, tension = solve(solver, problem)
            status_2, tension_2 = solve(other, _reordered(problem, robot, order))
            expect(status == status_2, f"status {status}, but {status_2} with another order of the cables")
            if status == Status.OK:
                allowed = max(1e-6, 10 * subject.accuracy) * float(problem.t_max.max())
                expect_close(tension_2, tension[order], allowed, "tensions with the cables in another order, N")


def _reordered(problem: Problem, robot: Robot, order: NDArray[np.int64]) -> Problem:
    W = np.ascontiguousarray(problem.W[:, order])
    return Problem(robot, W, problem.wrench, problem.t_min[order], problem.t_max[order])


def answers_are_continuous(subject: SolverSubject) -> None:
    """If pose and wrench change smoothly, the tensions do not jump.

    Skipped if the solver does not declare `continuity: C0`, `C1` or `Cinf`.
    """
    declared = subject.properties.get("continuity")
    needs(declared not in (None, "jump"), "it declares no continuity")
    for robot, paths in zip(samples.solver_robots(), samples.paths(), strict=True):
        solver = subject.make(robot)
        for path in paths:
            _expect_no_jump(subject, solver, path)


def _expect_no_jump(subject: SolverSubject, solver: TensionSolver, path: Path) -> None:
    """Refine the largest step of the tensions on the path: it must vanish."""

    def answer(s: float) -> Array | None:
        status, tension = solve(solver, samples.on_path(path, s))
        return tension if status == Status.OK else None

    found = steepest(answer, steps=100, halvings=20)
    noise = 10 * max(subject.accuracy, 1e-8) * float(path.robot.tension_max.max())
    expect(not found.jumps(noise), f"tensions jump by {found.change:.3g} N at one point of a smooth path")


def misleading_problems_are_answered_truly(subject: SolverSubject) -> str:
    """The statuses OK and INFEASIBLE are correct even for difficult problems, for example with a singular W.

    If the solver declares `coverage: full`, it must also solve every feasible problem of this check. The check applies
    only to solvers that declare `exact` or `coverage: full`. Skipped if the solver declares `respects_bounds: false`.
    """
    full, most = subject.properties.get("coverage") == "full", subject.properties.get("max_redundancy", "any")
    needs(
        (subject.declares("exact") or full) and subject.respects_bounds,
        "it declares neither exact nor coverage: full, or it declares respects_bounds: false",
    )
    solved = 0
    for found, problems in samples.misleading(FEW if subject.declares("slow") else MANY, seed=301):
        robot, slack = found.robot, found.slack
        solver = subject.make(robot)
        memory = Memory(solver)
        for k, problem in enumerate(problems):
            memory.fill(POISON[k % len(POISON)])
            status, tension = solve(solver, problem)
            what = f"of {robot.m} cables for {robot.n}, {found.kind[k]}"
            if status == Status.OK:
                expect(found.feasible[k], f"OK, but no tensions balance the wrench: {what}")
                largest = float(np.abs(problem.t_max).max())
                lack = float(np.abs(problem.W @ tension - problem.wrench).max())
                rows = float((np.abs(problem.W) @ np.abs(tension) + np.abs(problem.wrench)).max())
                expect(lack <= subject.accuracy * rows, f"OK, but W t - wrench is {lack:.2g} of {rows:.2g} N: {what}")
                over = float(np.maximum(problem.t_min - tension, tension - problem.t_max).max())
                expect(over <= 1e-6 * min(1.0, largest), f"OK, but {over:.3g} N beyond a limit: {what}")
            elif found.feasible[k] and slack[k] > adversaries.BAND:
                expect(status != Status.INFEASIBLE, f"INFEASIBLE, but there are admissible tensions: {what}")
                refused = status == Status.UNSUPPORTED and most != "any" and _null_space(problem.W).shape[1] > most
                expect(not full or refused, f"{Status(status)}, but there are admissible tensions: {what}")
            solved += 1
    return f"{solved} problems"


def objective_is_reached(subject: SolverSubject) -> str:
    """The answer minimises the declared `objective` (`min_norm` or `mid_range`), or the declared `cost`.

    Skipped if the solver declares none of these.
    """
    # By the conditions of Karush, Kuhn and Tucker, t is nearest to r if and only if t = r + W^T y, clipped to the
    # limits, for some y; the cables inside their limits determine y.
    objective = subject.properties.get("objective")
    if subject.cost is not None:
        return _no_step_is_cheaper(subject, subject.cost)
    needs(objective in ("min_norm", "mid_range"), "it declares neither a known objective nor a cost")
    certified = 0
    for problem, tension in _answered(subject):
        low, high = (problem.t_min, problem.t_max) if subject.respects_bounds else (np.array(-np.inf), np.array(np.inf))
        near = INSIDE * float(problem.t_max.max())
        inside = (tension > low + near) & (tension < high - near)
        W = problem.W[:, inside]
        if np.linalg.matrix_rank(W, 1e-6) < len(W):
            continue  # y is not unique
        target = 0.0 * tension if objective == "min_norm" else 0.5 * (problem.t_min + problem.t_max)
        y = np.linalg.lstsq(W.T, (tension - target)[inside], rcond=None)[0]
        allowed = max(1e-6, 10 * subject.accuracy) * float(problem.t_max.max())
        expect_close(np.clip(target + problem.W.T @ y, low, high), tension, allowed, f"distance from {objective}, N")
        certified += 1
    expect(certified, "it answered none of the feasible problems")
    return f"{certified} certified"


def _no_step_is_cheaper(subject: SolverSubject, cost: Cost) -> str:
    """Fail if a direction within the admissible set lowers a convex cost.

    The tried directions lead to the best answer by the cost's gradient, a linear program, and to random answers.
    """
    certified = 0
    for k, (problem, tension) in enumerate(_answered(subject)):
        low, high = problem.t_min, problem.t_max
        reach = 1.0 + float(np.abs(tension).max())  # step limit if the solver ignores limits
        if not subject.respects_bounds:
            low, high = tension - reach, tension + reach
        N = _null_space(problem.W)
        if N.shape[1] == 0:
            continue
        here = cost(tension, problem.t_min, problem.t_max)
        rng = np.random.default_rng([80, k])
        step = 1e-6 * reach
        slope = [(cost(tension + step * e, problem.t_min, problem.t_max) - here) / step for e in np.eye(len(tension))]
        for direction in (N.T @ np.array(slope), *rng.normal(size=(4, N.shape[1]))):
            other = tension + N @ _farthest(direction, N, tension, low, high)
            there = cost(other, problem.t_min, problem.t_max)
            for share in STEPS:
                beside = cost(tension + share * (other - tension), problem.t_min, problem.t_max)
                allowed = 10 * subject.accuracy * (abs(here) + abs(there)) * share + ROUND_OFF * abs(here)
                expect(beside >= here - allowed, f"the cost of an answer is {here:.9g}, nearby it is {beside:.9g}")
        certified += 1
    expect(certified, "it answered none of the feasible problems that leave a choice")
    return f"{certified} evaluated"


def _null_space(W: Array) -> Array:
    _, values, rows = np.linalg.svd(W)
    rank = int(np.count_nonzero(values > 1e-9 * values[0]))
    return np.ascontiguousarray(rows[rank:].T)


def _farthest(direction: Array, N: Array, tension: Array, low: Array, high: Array) -> Array:
    """Return the x (r,) with low <= tension + N x <= high that minimises direction . x."""
    x, _, status = extreme_point(direction, N, tension, np.minimum(low, tension), np.maximum(high, tension))
    return x if status == Status.OK else np.zeros(N.shape[1])


CHECKS = [
    Check(function)
    for function in (
        answers_balance,
        answers_are_within_the_limits,
        what_can_be_solved_is_solved,
        infeasible_is_never_ok,
        unreachable_is_never_ok,
        limits_are_the_arguments,
        cables_may_come_in_any_order,
        answers_are_continuous,
        misleading_problems_are_answered_truly,
        objective_is_reached,
    )
]
