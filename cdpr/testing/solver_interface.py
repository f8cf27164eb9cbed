"""Checks of a tension solver's interface: inputs, state, repeatability, exceptions, leaks."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.analysis.bench.poison import POISON, Memory
from cdpr.model.robot import Array, read_only
from cdpr.native.bind import LANES
from cdpr.plugins import CompiledSolver
from cdpr.tension import Status
from cdpr.testing import samples
from cdpr.testing.changes import expect_changes
from cdpr.testing.check import Check, expect, expect_close, expect_same_bits, needs
from cdpr.testing.columns import expect_written
from cdpr.testing.process import MemoryUse
from cdpr.testing.samples import Problem
from cdpr.testing.subjects import SolverSubject, solve

if TYPE_CHECKING:
    from cdpr.native.library import Bound

ARRAYS = ("W", "wrench", "t_min", "t_max")


def inputs_stay_unchanged(subject: SolverSubject) -> None:
    """The solver does not change its inputs: the wrench matrix, the wrench and the limits."""
    for group in (*samples.feasible(), *samples.infeasible()):
        solver = subject.make(group[0].robot)
        for problem in group[:20]:
            own = replace(problem, **{name: getattr(problem, name).copy() for name in ARRAYS})
            solve(solver, own)
            for name in ARRAYS:
                expect_same_bits(getattr(own, name), getattr(problem, name), f"{name} after solve")


def answers_are_not_shared(subject: SolverSubject) -> None:
    """The solver writes the tensions into the array that the call passes. Later calls do not change this array."""
    group = samples.feasible()[2]
    solver = subject.make(group[0].robot)
    answers = [solve(solver, problem)[1] for problem in group[:20]]
    kept = [answer.copy() for answer in answers]
    for problem in group[20:40]:
        solve(solver, problem)
    for answer, copy in zip(answers, kept, strict=True):
        expect_same_bits(answer, copy, "an answer after later calls")


def instances_agree(subject: SolverSubject) -> None:
    """Two objects of the solver give identical answers to the same problems.

    A solver must not use random numbers, and its objects must not share data.
    """
    for group in samples.feasible():
        first, second = subject.make(group[0].robot), subject.make(group[0].robot)
        for problem in group[:50]:
            expect_same_bits(solve(second, problem)[1], solve(first, problem)[1], "answer of a second solver")


def answers_do_not_depend_on_the_past(subject: SolverSubject) -> None:
    """An answer does not depend on the problems that the object solved before.

    It is identical to the answer of a new object. With `warm_start`, the tensions may differ from it by 1e-6 of the
    largest limit.
    """
    for group, other in zip(samples.feasible(), samples.infeasible(), strict=True):
        used = subject.make(group[0].robot)
        for problem, hard in zip(group[:40], other[:40], strict=True):
            fresh = subject.make(problem.robot)
            wanted = solve(fresh, problem)
            solve(used, hard)
            found = solve(used, problem)
            expect(found[0] == wanted[0], f"status {found[0]} after another problem, {wanted[0]} without")
            if wanted[0] == Status.OK and subject.declares("warm_start"):
                expect_close(found[1], wanted[1], 1e-6 * float(problem.t_max.max()), "tension after another, N")
            elif wanted[0] == Status.OK:
                expect_same_bits(found[1], wanted[1], "answer after another problem")


def reset_forgets(subject: SolverSubject) -> None:
    """After `reset`, the answers are identical to those of a new object."""
    for group in samples.feasible():
        fresh, used = subject.make(group[0].robot), subject.make(group[0].robot)
        for problem in group[50:60]:
            solve(used, problem)
        used.reset()
        for problem in group[:10]:
            expect_same_bits(solve(used, problem)[1], solve(fresh, problem)[1], "answer after reset")


def the_platform_does_not_matter(subject: SolverSubject) -> None:
    """The mass and the inertia of the platform have no effect on an answer.

    Skipped if the solver does not declare `platform_independent`.
    """
    needs(subject.declares("platform_independent"), "it does not declare platform_independent")
    for group in samples.feasible():
        robot = group[0].robot
        one, other = subject.make(robot), subject.make(samples.laden(robot))
        for problem in group[:20]:
            wanted, found = solve(one, problem), solve(other, problem)
            expect(found[0] == wanted[0], f"status {found[0]} with another platform, {wanted[0]} without")
            expect_same_bits(found[1], wanted[1], "answer with another platform")


def columns_are_written(subject: SolverSubject) -> str:
    """In each sample, the solver writes finite numbers into all columns of the log that it declares.

    It writes nothing outside these columns. Skipped if it declares no columns.
    """
    group = samples.feasible()[0]
    solver = subject.make(group[0].robot)
    return expect_written(
        subject.columns, group[0].robot, solver, solver.reset, lambda k: solve(solver, group[k % len(group)])
    )


def options_change(subject: SolverSubject) -> str:
    """After `change`, the answers are identical to those of a new object with the same options.

    If a second `change` sets the first options again, the answers are the same as without any change. Each changeable
    option must have an effect. Skipped without `changeable` options.
    """
    group = samples.feasible()[0]
    return expect_changes(
        subject.changeable,
        subject.options,
        lambda options: subject.having(options).make(group[0].robot),
        lambda solver, k: solve(solver, group[k % len(group)])[1],
    )


def bad_input_raises_nothing(subject: SolverSubject) -> None:
    """If the input is invalid, the solver returns a status. It raises no exception.

    The kit tests NaN, infinity, and lower limits above the upper limits. For such limits, the status is OK only if the
    solver declares `respects_bounds: false`.
    """
    for group in samples.feasible():
        solver = subject.make(group[0].robot)
        for problem in group[:3]:
            for bad in _spoilt(problem):
                solve(solver, bad)
            crossed = replace(problem, t_min=problem.t_max, t_max=problem.t_min)
            status, _ = solve(solver, crossed)
            expect(status != Status.OK or not subject.respects_bounds, "OK where t_min > t_max")


def views_are_answered_alike(subject: SolverSubject) -> None:
    """The answer is the same if the inputs are read-only parts of longer arrays.

    Each input is still a C-contiguous array of float64.
    """
    for problem in samples.feasible()[2][:10]:
        view = replace(problem, **{name: _view(getattr(problem, name)) for name in ARRAYS})  # type: ignore[arg-type]
        wanted, found = solve(subject.make(problem.robot), problem), solve(subject.make(problem.robot), view)
        expect(found[0] == wanted[0], f"status {found[0]} for read-only views, {wanted[0]} for arrays of their own")
        if wanted[0] == Status.OK:
            expect_same_bits(found[1], wanted[1], "answer to read-only views")


def _view(array: Array) -> Array:
    """Return the array as a read-only part of a longer one, between non-finite numbers."""
    long = np.full(array.size + 16, np.nan)
    long[8:-8] = array.ravel()
    return read_only(long[8:-8].reshape(array.shape))


def memory_never_decides(subject: SolverSubject) -> None:
    """An answer does not depend on the old values in the solver's own arrays.

    Before a call, the kit writes NaN, 1e30 or 0 into these arrays. The answers must be identical. Skipped for solvers
    in Python that declare `warm_start`.
    """
    hard = [problems for _, problems in samples.misleading(40, seed=300)[2:6]]
    groups = [*(group[:20] for group in (*samples.feasible(), *samples.infeasible())), *hard]
    if subject.declares("slow"):
        groups = [group[:8] for group in groups]
    for group in groups:
        solver = subject.make(group[0].robot)
        memory = Memory(solver)
        needs(
            isinstance(solver, CompiledSolver) or not subject.declares("warm_start"),
            "it declares warm_start: earlier problems may affect its answers",
        )
        for problem in group[:5]:
            solve(solver, problem)
        for problem in group:
            answers = []
            for value in POISON:
                memory.fill(value)
                answers.append(solve(solver, problem))
            for value, (status, tension) in zip(POISON[:-1], answers, strict=False):
                expect(
                    status == answers[-1][0],
                    f"status {Status(status)} with {value} in its memory, {Status(answers[-1][0])} with 0",
                )
                if status == Status.OK:
                    expect_same_bits(tension, answers[-1][1], f"answer with {value} in its memory")


def eight_are_answered_as_one(subject: SolverSubject) -> str:
    """A kernel for eight problems at once gives the same answers as the kernel for one problem.

    An answer must not depend on the seven other problems, or on old values in the arrays of the kernel. Skipped for
    solvers without such a kernel.
    """
    created = subject.make(samples.feasible()[0][0].robot)
    needs(isinstance(created, CompiledSolver) and _eight(created) is not None, "it has no kernel for eight problems")
    answered = count = 0
    hard = [problems for _, problems in samples.misleading(80, seed=302)]
    for k, group in enumerate((*samples.feasible(), *samples.infeasible(), *hard)):
        solver = subject.make(group[0].robot)
        assert isinstance(solver, CompiledSolver)
        odd = [bad for problem in group[:2] for bad in (*_spoilt(problem), *_degenerate(problem))]
        crossed = replace(group[0], t_min=group[0].t_max, t_max=group[0].t_min)
        many = [*group[:80], *odd, crossed]
        rng = np.random.default_rng([70, k])
        eight = _eight(solver)
        for chosen in (group[:LANES], *rng.permutation(len(many))[: len(many) // LANES * LANES].reshape(-1, LANES)):
            problems = [each if isinstance(each, Problem) else many[each] for each in chosen]
            count += LANES
            answered += _expect_the_same(solver, eight, problems, POISON[count // LANES % len(POISON)])
    expect(answered, "it answers none of the problems")
    return f"{answered} of {count} answered"


def _eight(solver: CompiledSolver) -> Bound | None:
    """Return the operation for eight problems, bound to its own arrays; None if there is none."""
    n, m = solver.robot.n, solver.robot.m
    shapes = (n, m), (n,), (m,), (m,), (m,)
    return solver.side_by_side(*(np.empty((*shape, LANES)) for shape in shapes))


def _expect_the_same(solver: CompiledSolver, eight: Bound | None, problems: Sequence[Problem], rubbish: float) -> int:
    """Solve eight problems at once and one by one; return the number of solved ones."""
    assert eight is not None
    parameters = {id(array) for name, array in eight.given.items() if name in solver.parameters}
    written: Any = eight.arrays
    for array in written:
        if id(array) not in parameters:
            array[...] = rubbish
    fields = "matrix", "wrench", "tension_min", "tension_max"
    kept = [np.stack([getattr(problem, name) for problem in problems], axis=-1) for name in ARRAYS]
    for field, array in zip(fields, kept, strict=True):
        eight.given[field][...] = array
    tension = eight.given["tension"]
    tension[...] = np.nan
    refused = eight()
    expect(0 <= refused < 2**LANES, f"returned {refused}, expected one bit for each of eight problems")
    for field, array in zip(fields, kept, strict=True):
        expect_same_bits(eight.given[field], array, f"{field} of eight after they are answered")
    for lane, problem in enumerate(problems):
        status, alone = solve(solver, problem)
        among = "refused" if refused >> lane & 1 else "answered"
        expect(
            (status != Status.OK) == bool(refused >> lane & 1), f"{among} among eight problems, {Status(status)} alone"
        )
        if status == Status.OK:
            expect_same_bits(tension[:, lane].copy(), alone, "answer among eight")
    return LANES - int(refused).bit_count()


def _spoilt(problem: Problem) -> list[Problem]:
    """Return copies with one entry, or all entries, of W or wrench not finite."""
    bad = []
    for name in ("W", "wrench"):
        for value in (np.nan, np.inf, -np.inf):
            for where in (0, -1, slice(None)):
                array = getattr(problem, name).copy()
                array.ravel()[where] = value
                bad.append(replace(problem, **{name: array}))
    return bad


def degenerate_problems_are_answered(subject: SolverSubject) -> None:
    """If the status of a degenerate problem is OK, W t equals the wrench."""
    for group in samples.feasible():
        solver = subject.make(group[0].robot)
        for problem in group[:10]:
            for odd in _degenerate(problem):
                status, tension = solve(solver, odd)
                if status == Status.OK:
                    expect_balanced(subject, odd, tension)
    rng = np.random.default_rng(40)
    solver = subject.make(samples.sparse())
    for _ in range(20):
        problem = samples.problem(samples.sparse(), samples.state(rng, tilt=0.3), rng.uniform(10.0, 100.0, 4))
        status, tension = solve(solver, problem)
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


# Answers between two memory measurements, and number of measurements; solvers declared `slow` give fewer.
ANSWERS, FEW_ANSWERS, LOOKS = 400, 25, 4
# Memory that one answer may leave on average: less than the smallest object, and than the shortest array of numbers.
BLOCKS, BYTES = 0.5, 200.0


def nothing_leaks(subject: SolverSubject) -> str:
    """Memory does not grow during 2000 calls (125 calls if the solver declares `slow`)."""
    needs(os.path.isdir("/proc/self"), "only Linux reports the resources of a process")
    group = samples.feasible()[2]
    solver = subject.make(group[0].robot)
    tension = np.zeros(group[0].robot.m)
    count = FEW_ANSWERS if subject.declares("slow") else ANSWERS

    measurements = []
    for _ in range(LOOKS + 1):  # objects created in the first round and kept are no leak
        for k in range(count):
            problem = group[k % len(group)]
            solver.solve(problem.W, problem.wrench, problem.t_min, problem.t_max, tension)
        measurements.append(MemoryUse.now())
    grown = [after.more_than(before) for before, after in pairwise(measurements)]
    blocks, size = (min(values) for values in zip(*grown, strict=True))
    expect(blocks <= BLOCKS * count, f"{blocks} Python objects more after every {count} answers")
    expect(size <= BYTES * count, f"{size / 1e6:.2f} MB more after every {count} answers")
    return f"{LOOKS} times {count} answers"


CHECKS = [
    Check(function)
    for function in (
        inputs_stay_unchanged,
        answers_are_not_shared,
        instances_agree,
        answers_do_not_depend_on_the_past,
        reset_forgets,
        the_platform_does_not_matter,
        columns_are_written,
        options_change,
        bad_input_raises_nothing,
        views_are_answered_alike,
        memory_never_decides,
        eight_are_answered_as_one,
        degenerate_problems_are_answered,
        nothing_leaks,
    )
]
