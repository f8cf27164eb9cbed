"""Calls of one solver on all problems, with the time of each call."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter_ns
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.bench.poison import POISON
from cdpr.analysis.bench.problems import Problems
from cdpr.base.errors import one_line
from cdpr.base.problems import short_repr
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver, TensionSolver
from cdpr.tension import Status

FIRST_CALLS = 10  # not timed: they import modules and fill caches
PINV_EVERY = 10  # calls between two calls of numpy's pinv, so that both see the same machine load


class SolverCallFailed(Exception):  # noqa: N818 - an outcome
    """The solver raised, or returned no valid status."""


@dataclass(frozen=True, eq=False)
class Answers:
    """Results of a solver on K problems."""

    status: NDArray[np.int64]  # (K,), values of `cdpr.tension.Status`
    tension: Array  # (K, m), N; NaN if nothing was written
    nanoseconds: NDArray[np.int64]  # (K,), wall time of each call
    pinv_ns: NDArray[np.int64]  # times of numpy.linalg.pinv of a 6x8 matrix, called in between


def make_solver(factory: Callable[..., Any], robot: Robot, options: Any) -> TensionSolver:
    """Create a solver.

    Raises:
        SolverCallFailed: if it raises.
    """
    try:
        solver: TensionSolver = factory(robot, options)
        return solver
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise SolverCallFailed(f"raised {one_line(error)} during construction") from error


def run_solver(solver: TensionSolver, problems: Problems, *, poisoned: bool = False) -> Answers:
    """Solve all problems in order and return the results.

    The first problems are solved once in advance, untimed, and the solver is then reset.

    Args:
        solver: the solver.
        problems: the problems.
        poisoned: fill a compiled solver's work space with garbage before each call, to expose reads of unwritten
            memory.

    Raises:
        SolverCallFailed: if the solver raises or returns no valid status.
    """
    robot, count = problems.robot, len(problems)
    t_min, t_max = problems.t_min, problems.t_max
    work = solver.work if poisoned and isinstance(solver, CompiledSolver) else ()
    status, nanoseconds = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
    tension = np.full((count, robot.m), np.nan)
    matrix = np.random.default_rng(0).normal(size=(6, 8))
    pinv = []
    with _no_garbage_collection():
        for k in range(min(FIRST_CALLS, count)):
            solve_one(solver, problems.W[k], problems.wrench[k], t_min[k], t_max[k])
        try:
            solver.reset()
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise SolverCallFailed(f"raised {one_line(error)} during reset") from error
        solve = solver.solve
        for k in range(count):
            W, wrench, low, high, t = problems.W[k], problems.wrench[k], t_min[k], t_max[k], tension[k]
            for array in work:
                array[...] = POISON[k % len(POISON)]
            try:
                before = perf_counter_ns()
                returned = solve(W, wrench, low, high, t)
                nanoseconds[k] = perf_counter_ns() - before
            except KeyboardInterrupt:
                raise
            except BaseException as error:
                raise SolverCallFailed(f"raised {one_line(error)} at problem {k}") from error
            status[k] = _checked(returned)
            if k % PINV_EVERY == 0:
                np.linalg.pinv(matrix)  # the first call after one of a large library is slow
                before = perf_counter_ns()
                np.linalg.pinv(matrix)
                pinv.append(perf_counter_ns() - before)
    return Answers(status, tension, nanoseconds, np.array(pinv))


def solve_one(solver: TensionSolver, W: Array, wrench: Array, t_min: Array, t_max: Array) -> tuple[int, Array]:
    """Return the status and the tensions, (m,), N, of one problem.

    Raises:
        SolverCallFailed: if the solver raises or returns no valid status.
    """
    tension = np.full(len(t_min), np.nan)
    try:
        returned = solver.solve(W, wrench, t_min, t_max, tension)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise SolverCallFailed(f"raised {one_line(error)}") from error
    return _checked(returned), tension


def _checked(returned: Any) -> int:
    if isinstance(returned, (int, np.integer)) and not isinstance(returned, bool) and returned in list(Status):
        return int(returned)
    raise SolverCallFailed(f"returned {short_repr(returned)}, which is not a cdpr.tension.Status")


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
