"""Checks of what a tension solver answers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.tension import Status
from cdpr.tension.continuity import Path, steepest
from cdpr.testing import samples
from cdpr.testing.check import Check, expect, expect_close, needs
from cdpr.testing.samples import Problem
from cdpr.testing.solver_interface import expect_balanced
from cdpr.testing.subjects import SolverSubject, ask

INSIDE = 1e-6  # share of the largest limit: closer to a limit, a cable counts as at it


def _answered(subject: SolverSubject) -> Iterator[tuple[Problem, Array]]:
    """All feasible problems that the solver answers with OK."""
    for group in samples.feasible():
        solver = subject.make(group[0].robot)
        for problem in group:
            status, tension = ask(solver, problem)
            if status == Status.OK:
                yield problem, tension


def answers_balance(subject: SolverSubject) -> str:
    """OK means that W t is the wrench: to 1e-9 of it if declared exact, to 1e-6 otherwise."""
    count = 0
    started = perf_counter()
    for problem, tension in _answered(subject):
        expect_balanced(subject, problem, tension)
        count += 1
    expect(count, "it answered none of the feasible problems")
    return f"{count} of {sum(map(len, samples.feasible()))} answered, {perf_counter() - started:.2g} s in all"


def answers_are_within_the_limits(subject: SolverSubject) -> None:
    """OK means t_min <= t <= t_max to a millionth of a newton, unless respects_bounds is declared false."""
    needs(subject.respects_bounds, "it declares respects_bounds: false")
    for problem, tension in _answered(subject):
        over = float(np.maximum(problem.t_min - tension, tension - problem.t_max).max())
        expect(over <= 1e-6, f"OK, but {over:.3g} N beyond a limit")


def what_can_be_solved_is_solved(subject: SolverSubject) -> None:
    """Every problem that has an answer gets one, from a solver that declares coverage: full.

    Robots with more redundant cables than a declared max_redundancy may be UNSUPPORTED instead.
    """
    needs(subject.properties.get("coverage") == "full", "it does not declare coverage: full")
    most = subject.properties.get("max_redundancy", "any")
    for group in samples.feasible():
        robot = group[0].robot
        allowed = [Status.OK] if most == "any" or robot.m - robot.n <= most else [Status.OK, Status.UNSUPPORTED]
        solver = subject.make(robot)
        missed = sum(ask(solver, problem)[0] not in allowed for problem in group)
        expect(not missed, f"{missed} of {len(group)} not answered with {robot.m} cables")


def infeasible_is_never_ok(subject: SolverSubject) -> None:
    """A wrench that no tensions within the limits balance is never OK."""
    needs(subject.respects_bounds, "it declares respects_bounds: false")
    for group in samples.infeasible():
        solver = subject.make(group[0].robot)
        wrong = sum(ask(solver, problem)[0] == Status.OK for problem in group)
        expect(not wrong, f"{wrong} of {len(group)} called OK with {group[0].robot.m} cables")


def unreachable_is_never_ok(subject: SolverSubject) -> None:
    """A wrench that no tensions at all balance, fewer cables than freedoms or a singular W, is never OK."""
    rng = np.random.default_rng(50)
    robot = samples.sparse()
    solver = subject.make(robot)
    for _ in range(100):
        problem = samples.problem(robot, samples.state(rng, tilt=0.3), rng.uniform(10.0, 100.0, robot.m))
        nowhere = np.linalg.svd(problem.W)[0][:, -1]  # orthogonal to all that the cables can do
        status, _ = ask(solver, problem.with_wrench(problem.wrench + 100.0 * nowhere))
        expect(status != Status.OK, "OK with 4 cables for 6 freedoms and a wrench outside their span")
    for problem in samples.feasible()[2][:50]:
        flat = problem.W.copy()
        flat[-1] = flat[0]
        status, _ = ask(subject.make(problem.robot), replace(problem, W=flat))
        expect(status != Status.OK, "OK with a singular W and a wrench outside its range")


def limits_are_the_arguments(subject: SolverSubject) -> None:
    """The limits of a call are its arguments; scaled with the wrench they scale the tensions."""
    for group in samples.feasible():
        solver = subject.make(group[0].robot)
        for problem in group[:50]:
            status, tension = ask(solver, problem)
            larger = replace(problem, wrench=1e3 * problem.wrench, t_min=1e3 * problem.t_min, t_max=1e3 * problem.t_max)
            status_2, tension_2 = ask(solver, larger)
            expect(status == status_2, f"status {status}, and {status_2} with everything a thousand times larger")
            if status == Status.OK:
                allowed = max(1e-6, 10 * subject.accuracy) * float(problem.t_max.max())
                expect_close(tension_2 / 1e3, tension, allowed, "tensions of the scaled problem, N")


def cables_may_come_in_any_order(subject: SolverSubject) -> None:
    """Renumbering the cables renumbers the tensions, unless continuity: jump allows several answers."""
    needs(subject.properties.get("continuity") != "jump", "it declares continuity: jump")
    for k, group in enumerate(samples.feasible()):
        order = np.random.default_rng(60 + k).permutation(group[0].robot.m)
        robot = replace(group[0].robot, cables=tuple(group[0].robot.cables[i] for i in order))
        solver, other = subject.make(group[0].robot), subject.make(robot)
        for problem in group[:50]:
            status, tension = ask(solver, problem)
            status_2, tension_2 = ask(other, _reordered(problem, robot, order))
            expect(status == status_2, f"status {status}, and {status_2} with the cables in another order")
            if status == Status.OK:
                allowed = max(1e-6, 10 * subject.accuracy) * float(problem.t_max.max())
                expect_close(tension_2, tension[order], allowed, "tensions with the cables in another order, N")


def _reordered(problem: Problem, robot: Robot, order: NDArray[np.int64]) -> Problem:
    W = np.ascontiguousarray(problem.W[:, order])
    return Problem(robot, W, problem.wrench, problem.t_min[order], problem.t_max[order])


def answers_are_continuous(subject: SolverSubject) -> None:
    """Along a smooth path of pose and wrench the tensions do not jump, unless continuity: jump is declared."""
    declared = subject.properties.get("continuity")
    needs(declared not in (None, "jump"), "it declares no continuity")
    for k, robot in enumerate(samples.solver_robots()):
        solver = subject.make(robot)
        for path in range(3):
            rng = np.random.default_rng(70 + 10 * k + path)
            _expect_no_jump(subject, solver, _path(robot, rng))


def _path(robot: Robot, rng: np.random.Generator) -> Path:
    poses = np.array([samples.robot_state(robot, rng)[:7] for _ in range(2)])
    tensions = np.array([robot.tension_min + rng.uniform(0.0, 400.0, robot.m) for _ in range(2)])
    return Path(robot, poses, tensions)


def _expect_no_jump(subject: SolverSubject, solver: TensionSolver, path: Path) -> None:
    """Look at the largest step of the tensions on the path ever more closely: it must vanish."""
    robot = path.robot

    def answer(s: float) -> Array | None:
        status, tension = ask(solver, Problem(robot, *path.at(s), robot.tension_min, robot.tension_max))
        return tension if status == Status.OK else None

    found = steepest(answer, steps=100, halvings=20)
    noise = 10 * max(subject.accuracy, 1e-8) * float(robot.tension_max.max())
    expect(not found.jumps(noise), f"tensions jump by {found.change:.3g} N at one point of a smooth path")


def objective_is_reached(subject: SolverSubject) -> None:
    """The tensions are those nearest to zero (objective: min_norm) or to the middle of the limits (mid_range).

    By the conditions of Karush, Kuhn and Tucker, t is nearest to r if and only if t = r + W^T y, clipped to the limits,
    for some y; the cables inside their limits tell y.
    """
    objective = subject.properties.get("objective")
    needs(objective in ("min_norm", "mid_range"), "it declares no objective that the kit knows")
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
        objective_is_reached,
    )
]
