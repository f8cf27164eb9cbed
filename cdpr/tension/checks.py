"""Compiled checks of a distribution: no solver is believed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr.model.jit import any_width, apart, kernel, small
from cdpr.model.lanes import choose, code, every, some
from cdpr.model.robot import Array
from cdpr.tension.status import BAD_INPUT, NOT_FOUND, OK

# A tension counts as within its limits, and as at a limit, to this many newtons, or on robots whose largest limit is
# less than a newton to this share of that (`newton`): finer than any force sensor, coarser than the round-off of every
# exact solver. Accepted tensions are then clipped, so that no limit is broken at all.
LIMIT_TOLERANCE = 1e-6

# A distribution balances the wrench if the residual is below this share of the wrench (or of `newton`): a millionth of
# the load is below any model error, and above what first-order solvers reach when they say that they have converged.
RESIDUAL_TOLERANCE = 1e-6

# Squares of numbers beyond 1e154 are infinite, and an infinite residual would be within an infinite allowance. Such
# wrenches are absurd, but finite: their squares are taken in units so large that none overflows, a power of two.
FAR = 2.0**-520


@any_width
@kernel
def select(rows: NDArray[np.int64], W: Array, wrench: Array, free_W: Array, free_wrench: Array) -> None:
    """Copy the rows of W (6, m) and wrench (6,) that belong to the degrees of freedom into (n, m) and (n,)."""
    for k in range(rows.shape[0]):
        free_wrench[k] = wrench[rows[k]]
        for i in range(W.shape[1]):
            free_W[k, i] = W[rows[k], i]


@small
@kernel
def newton(limits: Array) -> float:
    """Return what is large beside the tolerances, N: one newton, or the largest of the limits (2, m) if that is less.

    Otherwise nothing would be proved of robots that are held by millinewtons. Of limits that are all zero it is 1.
    """
    largest = 0.0
    for i in range(limits.shape[1]):
        largest = max(largest, max(abs(limits[0, i]), abs(limits[1, i])))
        if every(largest >= 1.0):
            return 1.0
    return choose(largest >= 1.0, 1.0, choose(largest > 0.0, largest, 1.0))


@kernel
def room(limits: Array, tension: Array, report: Array, held: Array | None = None) -> None:
    """Write margin (N) and number of cables at a limit of `tension` (m,) into report[2:4]; limits are (2, m).

    A locked cable, whose limits are equal, counts only where it does not have that tension. Cables whose `held` (m,) is
    not NaN are broken or jammed and do not count, whether or not the distribution knows: the others' room is told.
    """
    margin, at_limit, tolerance = math.inf, 0.0, LIMIT_TOLERANCE * newton(limits)
    for i in range(tension.shape[0]):
        distance = min(tension[i] - limits[0, i], limits[1, i] - tension[i])
        aside = (limits[0, i] == limits[1, i]) & (distance >= -tolerance)
        if held is not None:
            aside = aside | (held[i] == held[i])
        margin = choose(aside, margin, min(margin, distance))
        at_limit += choose(aside, 0.0, choose(distance <= tolerance, 1.0, 0.0))
    report[2] = margin
    report[3] = at_limit


@apart
@kernel
def judge(
    W: Array,
    wrench: Array,
    weights: Array,
    limits: Array,
    tension: Array,
    report: Array,
    held: Array | None = None,
) -> float:
    """Write residual (N), margin (N) and number of cables at a limit of `tension` into report[1:4].

    weights (n,): 1 for forces, 1 / characteristic length for moments; limits (2, m) and `held` as `room` says. Returns
    the residual allowed.
    """
    n, m = W.shape
    unit, square, load = 1.0, 0.0, 0.0
    for _ in range(2):
        square, load = 0.0, 0.0
        for j in range(n):
            s = -wrench[j]
            for i in range(m):
                s += W[j, i] * tension[i]
            lack, wanted = unit * weights[j] * s, unit * weights[j] * wrench[j]
            square += lack * lack
            load += wanted * wanted
        if some((square < math.inf) & (load < math.inf)):
            break
        unit = FAR
    room(limits, tension, report, held)
    report[1] = math.sqrt(square) / unit
    return RESIDUAL_TOLERANCE * max(newton(limits), math.sqrt(load) / unit)


@any_width
@apart
@kernel
def accept(W: Array, wrench: Array, weights: Array, limits: Array, answer: Array, tension: Array, report: Array) -> int:
    """Copy a solver's answer (m,) into `tension` if it is finite, within the limits and balances the wrench.

    Returns and writes into report[0] a `cdpr.tension.Status`: OK, BAD_INPUT where the wrench is not finite, else
    NOT_FOUND; the rest of `report` is as `judge` says.
    """
    n, m = W.shape
    answered, asked = 0.0, 0.0  # NaN where an entry is not finite
    for i in range(m):
        answered += 0.0 * answer[i]
    for j in range(n):
        asked += 0.0 * wrench[j]
    right = (answered == 0.0) & (asked == 0.0)
    if some(right):
        right = right & holds(W, wrench, weights, limits, answer, report)
        for i in range(m):
            tension[i] = choose(right, min(max(answer[i], limits[0, i]), limits[1, i]), tension[i])
    status = choose(right, OK, choose(asked == 0.0, NOT_FOUND, BAD_INPUT))
    report[0] = status
    return code(status)


@kernel
def holds(W: Array, wrench: Array, weights: Array, limits: Array, answer: Array, report: Array) -> bool:
    """Whether a finite answer keeps the limits and balances the wrench, see `accept`; of lanes, too."""
    allowed = judge(W, wrench, weights, limits, answer, report)
    within = report[2] >= -LIMIT_TOLERANCE * newton(limits)
    kept: bool = within & (report[1] <= allowed) & (allowed < math.inf)
    return kept


@any_width
@kernel
def hold(held: Array, tension: Array) -> None:
    """Set the tensions (m,) whose `held` is not NaN to that."""
    for i in range(held.shape[0]):
        tension[i] = choose(held[i] == held[i], held[i], tension[i])


@any_width
@kernel
def impose(held: Array, W: Array, wrench: Array, weights: Array, limits: Array, tension: Array, report: Array) -> None:
    """Let `held` tensions be and `report` say what all tensions (m,) do then; its status stays the distribution's."""
    hold(held, tension)
    judge(W, wrench, weights, limits, tension, report, held)


@any_width
@kernel
def true_margin(limits: Array, tension: Array, held: Array, room: Array) -> None:
    """Write how far the tensions (m,) are from the nearer of the limits (2, m), N, negative beyond.

    NaN for cables whose `held` (m,) is not: broken or jammed, nothing is asked of them.
    """
    for i in range(tension.shape[0]):
        distance = min(tension[i] - limits[0, i], limits[1, i] - tension[i])
        room[i] = choose(held[i] == held[i], math.nan, distance)
