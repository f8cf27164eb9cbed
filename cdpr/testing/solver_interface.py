"""Checks of a tension solver as a part of a program: inputs, state, repeats, exceptions, leaks."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np

from cdpr.model.robot import Array
from cdpr.tension import Status
from cdpr.testing import samples
from cdpr.testing.check import Check, expect, expect_close, expect_same_bits, needs
from cdpr.testing.process import resident_bytes
from cdpr.testing.samples import Problem
from cdpr.testing.subjects import SolverSubject, ask

ARRAYS = ("W", "wrench", "t_min", "t_max")


def inputs_stay_unchanged(subject: SolverSubject) -> None:
    """The matrix, the wrench and the limits are only read."""
    for group in (*samples.feasible(), *samples.infeasible()):
        solver = subject.make(group[0].robot)
        for problem in group[:20]:
            own = replace(problem, **{name: getattr(problem, name).copy() for name in ARRAYS})
            ask(solver, own)
            for name in ARRAYS:
                expect_same_bits(getattr(own, name), getattr(problem, name), f"{name} after solve")


def answers_are_not_shared(subject: SolverSubject) -> None:
    """An answer is written into the array given for it and never touched again."""
    group = samples.feasible()[2]
    solver = subject.make(group[0].robot)
    answers = [ask(solver, problem)[1] for problem in group[:20]]
    kept = [answer.copy() for answer in answers]
    for problem in group[20:40]:
        ask(solver, problem)
    for answer, copy in zip(answers, kept, strict=True):
        expect_same_bits(answer, copy, "an answer after later calls")


def instances_agree(subject: SolverSubject) -> None:
    """Two solvers given the same problems give the same bits: nothing random, nothing shared."""
    for group in samples.feasible():
        first, second = subject.make(group[0].robot), subject.make(group[0].robot)
        for problem in group[:50]:
            expect_same_bits(ask(second, problem)[1], ask(first, problem)[1], "answer of a second solver")


def answers_do_not_depend_on_the_past(subject: SolverSubject) -> None:
    """A problem has the same answer whatever was solved before it: to the bit, or as exactly as warm_start allows."""
    for group, other in zip(samples.feasible(), samples.infeasible(), strict=True):
        used = subject.make(group[0].robot)
        for problem, hard in zip(group[:40], other[:40], strict=True):
            fresh = subject.make(problem.robot)
            wanted = ask(fresh, problem)
            ask(used, hard)
            found = ask(used, problem)
            expect(found[0] == wanted[0], f"status {found[0]} after another problem, {wanted[0]} without")
            if wanted[0] == Status.OK and subject.declares("warm_start"):
                expect_close(found[1], wanted[1], 1e-6 * float(problem.t_max.max()), "tension after another, N")
            elif wanted[0] == Status.OK:
                expect_same_bits(found[1], wanted[1], "answer after another problem")


def reset_forgets(subject: SolverSubject) -> None:
    """After reset the answers are those of a new solver, to the bit."""
    for group in samples.feasible():
        fresh, used = subject.make(group[0].robot), subject.make(group[0].robot)
        for problem in group[50:60]:
            ask(used, problem)
        used.reset()
        for problem in group[:10]:
            expect_same_bits(ask(used, problem)[1], ask(fresh, problem)[1], "answer after reset")


def bad_input_raises_nothing(subject: SolverSubject) -> None:
    """NaN, infinity and contradictory limits yield a status; the stage that called decides what to do."""
    for group in samples.feasible():
        solver = subject.make(group[0].robot)
        for problem in group[:3]:
            for bad in _spoilt(problem):
                ask(solver, bad)
            crossed = replace(problem, t_min=problem.t_max, t_max=problem.t_min)
            status, _ = ask(solver, crossed)
            expect(status != Status.OK or not subject.respects_bounds, "OK where t_min > t_max")


def memory_layout_misleads_nobody(subject: SolverSubject) -> None:
    """A W in single precision and column by column is answered truly or refused, never read in the wrong order."""
    group = samples.feasible()[2]
    solver = subject.make(group[0].robot)
    for problem in group[:10]:
        W = problem.W.astype(np.float32)
        same = replace(problem, W=W.astype(np.float64))
        wanted, _ = ask(solver, same)
        try:
            status, tension = ask(solver, replace(problem, W=np.asfortranarray(W)))
        except (TypeError, ValueError):
            continue  # refused
        expect(status in (wanted, Status.BAD_INPUT), f"status {status}, and {wanted} for the same numbers row by row")
        if status == Status.OK:
            expect_balanced(subject, same, tension)


def _spoilt(problem: Problem) -> list[Problem]:
    """Copies with one entry, or all, of W or wrench not finite."""
    bad = []
    for name in ("W", "wrench"):
        for value in (np.nan, np.inf, -np.inf):
            for where in (0, -1, slice(None)):
                array = getattr(problem, name).copy()
                array.ravel()[where] = value
                bad.append(replace(problem, **{name: array}))
    return bad


def degenerate_problems_are_answered(subject: SolverSubject) -> None:
    """No wrench, a locked or cut cable, equal cables, too few cables and a singular W yield true answers."""
    for group in samples.feasible():
        solver = subject.make(group[0].robot)
        for problem in group[:10]:
            for odd in _degenerate(problem):
                status, tension = ask(solver, odd)
                if status == Status.OK:
                    expect_balanced(subject, odd, tension)
    rng = np.random.default_rng(40)
    solver = subject.make(samples.sparse())
    for _ in range(20):
        problem = samples.problem(samples.sparse(), samples.state(rng, tilt=0.3), rng.uniform(10.0, 100.0, 4))
        status, tension = ask(solver, problem)
        if status == Status.OK:
            expect_balanced(subject, problem, tension)


def _degenerate(problem: Problem) -> list[Problem]:
    W, t = problem.W, 0.5 * (problem.t_min + problem.t_max)
    locked, twin, flat, cut = problem.t_max.copy(), W.copy(), W.copy(), problem.t_max.copy()
    locked[0] = t[0]
    twin[:, 1] = twin[:, 0]
    flat[-1] = 0.0
    cut[0] = 0.0
    low, zero = problem.t_min.copy(), problem.t_min.copy()
    low[0], zero[0] = t[0], 0.0
    return [
        problem.with_wrench(np.zeros_like(problem.wrench)),
        replace(problem, t_min=low, t_max=locked, wrench=W @ t),
        replace(problem, t_min=zero, t_max=cut, wrench=W[:, 1:] @ t[1:]),
        replace(problem, W=twin, wrench=twin @ t),
        replace(problem, W=flat, wrench=flat @ t),
        replace(problem, W=np.zeros_like(W), wrench=np.zeros_like(problem.wrench)),
        replace(problem, W=np.zeros_like(W)),
    ]


def expect_balanced(subject: SolverSubject, problem: Problem, tension: Array) -> None:
    """Fail unless an answer balances its wrench."""
    load = max(1.0, float(np.abs(problem.wrench).max()))
    expect_close(problem.W @ tension, problem.wrench, subject.accuracy * load, "OK, but W t - wrench")


def nothing_leaks(subject: SolverSubject) -> None:
    """Five thousand answers leave at most 2 MB behind."""
    needs(os.path.isdir("/proc/self"), "only Linux tells what a process holds")
    group = samples.feasible()[2]
    solver = subject.make(group[0].robot)

    def cycle(count: int) -> int:
        tension = np.zeros(group[0].robot.m)
        for _ in range(count):
            for problem in group:
                solver.solve(problem.W, problem.wrench, problem.t_min, problem.t_max, tension)
        return resident_bytes()

    before = cycle(5)
    more = cycle(25) - before
    expect(more <= 2_000_000, f"{more / 1e6:.1f} MB more after 5000 answers")


CHECKS = [
    Check(function)
    for function in (
        inputs_stay_unchanged,
        answers_are_not_shared,
        instances_agree,
        answers_do_not_depend_on_the_past,
        reset_forgets,
        bad_input_raises_nothing,
        memory_layout_misleads_nobody,
        degenerate_problems_are_answered,
        nothing_leaks,
    )
]
