"""The p-norm about the middle of the limits: the higher p, the more the cables nearest to their limits count."""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import ArrayLike

from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver
from cdpr.tension import null_space
from cdpr.tension.compiled import distribute_once
from cdpr.tension.null_space import reduce
from cdpr.tension.status import NOT_FOUND, UNSUPPORTED, Status
from cdpr_solvers.projection import admitted

# Newton's step, in half ranges or of the largest offset if that is more, with which it ends: the method being
# quadratic, the error after it is round-off. On the way to p a rough answer will do.
CONVERGED, ROUGHLY = 1e-10, 1e-2

# A step below the first that is not half as long as the one before is made of round-off: it cannot get better.
NOISE, SHRINKING = 1e-6, 0.5

# Steps that no sound problem needs for one exponent: ten are many.
MOST_STEPS = 100

# A direction in which all weighted rows are below this share of the largest is left as the lower exponents found it:
# what p would make of it drowns in the round-off of the others.
UNSEEN = 1e-9

# Offsets below this share of the half range are none: all tensions are in the middle.
CENTRED = 1e-12

# A step shorter than this share of the one asked for is none.
SHORTEST = 1e-12


class PNorm(CompiledSolver):
    """min sum u_i^p with W t = wrench, where u_i is the offset of t_i from the middle of its limits in half ranges.

    Gosselin and Grenier, On the Determination of the Force Distribution in Overconstrained Cable-Driven Parallel
    Mechanisms, Meccanica 46 (2011); here relative to the half ranges, so that limits may differ. p is even: p = 2 is
    the closed form if all ranges are equal, and for large p the largest offset becomes as small as it can be.
    The limits are no constraints: beyond them another distribution may be within, NOT_FOUND.

    Newton's method in the null space, for p = 2, 4, 8, ... up to p, each from the answer of the one before, with a
    line search. Its step solves weighted least squares, by an orthogonal factorisation: the weights u_i^(p-2) span too
    many decades for their normal equations. The answer depends continuously on pose and wrench, and smoothly but where
    so many cables are exactly in the middle that the others leave a direction undetermined.
    """

    def __init__(self, robot: Robot, options: Any) -> None:
        n, m = robot.n, robot.m
        super().__init__(
            robot,
            options,
            p_norm,
            parameters=[options.p],
            rows=null_space.form_rows(m) + m + 3 + max(null_space.work_rows(n), 2 * m + 5),
        )


@kernel
def p_norm(W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array, parameters: Array, work: Array) -> int:
    """Write the distribution; return OK, NOT_FOUND, INFEASIBLE where that is certain, UNSUPPORTED or BAD_INPUT."""
    m = W.shape[1]
    N, box, G = work[:m], work[m : m + 3], work[m + 3 : 2 * m + 3]
    start, u, x, rest = work[2 * m + 3, :m], work[2 * m + 4, :m], work[2 * m + 5], work[2 * m + 6 :]
    r = reduce(W, wrench, t_min, t_max, box, N, rest)
    if r < 0:
        return -r
    for i in range(m):  # u = start + G x; a locked cable stays at 0
        half = 0.5 * (box[2, i] - box[1, i])
        if half == math.inf:
            return UNSUPPORTED
        start[i] = (box[0, i] - 0.5 * (box[1, i] + box[2, i])) / half if half > 0.0 else 0.0
        for k in range(r):
            G[i, k] = N[i, k] / half if half > 0.0 else 0.0
    for k in range(r):
        x[k] = 0.0
    last, p = int(parameters[0]), 2
    while r > 0:
        if not _minimise(p, CONVERGED if p == last else ROUGHLY, G, r, start, x, u, rest):
            return NOT_FOUND
        if p == last:
            break
        p = min(2 * p, last)
    for i in range(m):
        tension[i] = box[0, i]
        for k in range(r):
            tension[i] += N[i, k] * x[k]
    return admitted(W, wrench, r, box, tension)


@kernel
def _minimise(p: int, goal: float, G: Array, r: int, start: Array, x: Array, u: Array, work: Array) -> bool:
    """Move x (r,) to where the sum of (start + G x)_i^p is least; return whether it was reached."""
    m = start.shape[0]
    v, d, rest = work[0], work[1], work[2:]
    previous = math.inf
    for _ in range(MOST_STEPS):
        scale = 0.0
        for i in range(m):
            u[i] = start[i]
            for k in range(r):
                u[i] += G[i, k] * x[k]
            scale = max(scale, abs(u[i]))
        if scale <= CENTRED:
            return True
        _least_squares(p, scale, G, r, u, d, rest)
        longest = 0.0
        for i in range(m):
            v[i] = 0.0
            for k in range(r):
                v[i] += G[i, k] * d[k]
            longest = max(longest, abs(v[i]))
        # The Hessian of the sum is p - 1 times the normal matrix of the weighted least squares.
        step = 1.0 / (p - 1)
        newton = longest * step / max(1.0, scale)
        if not newton < math.inf:  # NaN, too
            return False
        done = newton <= goal or (newton <= NOISE and newton > SHRINKING * previous)
        previous = newton
        if not done:
            step = _line_search(p, scale, u, v, step)
        for k in range(r):
            x[k] += step * d[k]
        if done:
            return True
    return False


@kernel
def _line_search(p: int, scale: float, u: Array, v: Array, step: float) -> float:
    """Return a step of about the length that makes the sum of (u + step v)_i^p least, from Newton's."""
    here, there = _sum(p, scale, u, v, 0.0), _sum(p, scale, u, v, step)
    if there < here:
        # Far away Newton's step is too short by as much as p - 1.
        while step < 1.0:
            beyond = _sum(p, scale, u, v, 2.0 * step)
            if not beyond < there:
                break
            step, there = 2.0 * step, beyond
        return step
    shortest = SHORTEST * step
    while not there < here and step > shortest:
        step *= 0.5
        there = _sum(p, scale, u, v, step)
    return step


@kernel
def _sum(p: int, scale: float, u: Array, v: Array, step: float) -> float:
    """Return the sum of ((u + step v)_i / scale)^p."""
    total = 0.0
    for i in range(u.shape[0]):
        total += _power((u[i] + step * v[i]) / scale, p)
    return total


@kernel
def _power(base: float, exponent: int) -> float:
    result = 1.0
    while exponent > 0:
        if exponent % 2 == 1:
            result *= base
        base *= base
        exponent //= 2
    return result


@kernel
def _least_squares(p: int, scale: float, G: Array, r: int, u: Array, d: Array, work: Array) -> None:
    """Write the d (r,) that minimises the sum of u_i^(p-2) (u + G d)_i^2.

    Modified Gram-Schmidt with column pivoting on the rows and the right-hand side, which keeps the small rows accurate
    beside the large ones (Gulliksson, BIT 35, 1995).
    """
    m = u.shape[0]
    A, R = work[:r], work[r : 2 * r]  # the rows of A are the columns of the problem
    y, column, b = work[2 * r], work[2 * r + 1], work[2 * r + 2]
    for i in range(m):
        weight = _power(abs(u[i]) / scale, p // 2 - 1)
        b[i] = -weight * u[i]
        for k in range(r):
            A[k, i] = weight * G[i, k]
    for k in range(r):
        column[k] = k
        d[k] = 0.0
    rank = 0
    for k in range(r):
        pivot, best = k, -1.0
        for j in range(k, r):
            square = 0.0
            for i in range(m):
                square += A[j, i] * A[j, i]
            if square > best:
                pivot, best = j, square
        R[k, k] = math.sqrt(best)
        if not R[k, k] > UNSEEN * R[0, 0]:
            break
        if pivot != k:
            column[k], column[pivot] = column[pivot], column[k]
            for i in range(m):
                A[k, i], A[pivot, i] = A[pivot, i], A[k, i]
            for j in range(k):
                R[j, k], R[j, pivot] = R[j, pivot], R[j, k]
        y[k] = 0.0
        for i in range(m):
            A[k, i] /= R[k, k]
            y[k] += A[k, i] * b[i]
        for i in range(m):
            b[i] -= y[k] * A[k, i]
        for j in range(k + 1, r):
            s = 0.0
            for i in range(m):
                s += A[k, i] * A[j, i]
            for i in range(m):
                A[j, i] -= s * A[k, i]
            R[k, j] = s
        rank += 1
    for k in range(rank - 1, -1, -1):
        for j in range(k + 1, rank):
            y[k] -= R[k, j] * y[j]
        y[k] /= R[k, k]
        d[int(column[k])] = y[k]


def p_norm_tension(
    matrix: ArrayLike,
    wrench: ArrayLike,
    tension_min: ArrayLike,
    tension_max: ArrayLike,
    p: int = 4,
) -> tuple[Array, Status]:
    """Compute the distribution of least p-norm about the middle of the limits, in half ranges.

    Gosselin and Grenier, Meccanica 46 (2011).

    Args:
        matrix: (n, m), rows of the wrench matrix, moments about the platform's origin, world axes.
        wrench: (n,), N and N m: the wrench that the cables shall exert.
        tension_min: (m,) N.
        tension_max: (m,) N. A cable whose limits are equal is locked at that tension.
        p: The exponent, an even number of at least 2.

    Returns:
        Tensions (m,) N, NaN unless the status is OK. The status: OK, NOT_FOUND where the tensions break a limit,
        INFEASIBLE where none are admissible, UNSUPPORTED where infinite limits have no middle, or BAD_INPUT.

    Raises:
        ValueError: The shapes do not match, or p is odd or less than 2.

    Example:
        >>> p_norm_tension([[1.0, -1.0]], [2.0], [1.0, 1.0], [9.0, 9.0])
        (array([6., 4.]), <Status.OK: 0>)
    """
    if p < 2 or p % 2 != 0:
        raise ValueError(f"p_norm: p: expected an even number of at least 2, got {p}.")
    return distribute_once("p_norm", matrix, wrench, tension_min, tension_max, p=p)
