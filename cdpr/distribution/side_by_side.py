"""The compiled loop over many distributions, eight rows at a time, for solvers with a kernel for that.

Compiled where many rows are asked for, and kept on disk as all kernels are.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cdpr.distribution.batch import COMMON, DONE, ROWS, Common, Rows
from cdpr.mechanics import geometry
from cdpr.model import kernels
from cdpr.model.jit import kernel, threaded_kernel
from cdpr.model.kinds import CUBE, NOTHING, ROW, TABLE, WHOLE, Function
from cdpr.model.lanes import WIDTH, aligned, bits, side_by_side
from cdpr.model.robot import Array
from cdpr.tension.checks import holds, select
from cdpr.tension.status import OK

LANES_KERNEL = Function(WHOLE(CUBE, *[TABLE] * 4, ROW, CUBE))

# Where fewer of eight rows are answered the attempt costs more than it saves.
WORTHWHILE = 4

STATE, WRENCH, REPORT = 13, 6, 4  # numbers of each, see `memory`


def memory(n: int, m: int, work: tuple[int, int]) -> tuple[Array, Array]:
    """Return space for eight rows of n degrees of freedom and m cables, and the work space of a solver with `work`.

    Both have eight numbers at the end and begin where a register of eight is read at once.
    """
    numbers = STATE + WRENCH + 6 * m + n + n * m + 2 * m + m + m + REPORT
    return aligned((numbers, WIDTH)), aligned((*work, WIDTH))


@kernel
def _spread(limits: Array, k: int, own: Array) -> None:
    """Write the limits (K, 2, m) of eight rows from k on into (2, m, 8), the only one of all rows eight times."""
    for lane in range(own.shape[2]):
        row = k + lane if limits.shape[0] > 1 else 0
        for i in range(own.shape[1]):
            own[0, i, lane] = limits[row, 0, i]
            own[1, i, lane] = limits[row, 1, i]


@kernel
def _pose(common: Common, state: Array, W: Array, wrench: Array, wanted: bool) -> None:
    """Make quaternions one long; write the wrench matrices and, unless they are given, what holds the platform."""
    w, x, y, z = kernels.quaternion(state, 3)
    length = math.sqrt(w * w + x * x + y * y + z * z)
    for i in range(3, 7):
        state[i] /= length
    geometry.point_columns(common.lines, state, W)
    if not wanted:
        still = (0.0, 0.0, 0.0)
        attitude = kernels.quaternion(state, 3)
        kernels.inverse_dynamics(common.inertial, common.gravity, attitude, still, still, still, wrench)


@kernel
def _accept(W: Array, wrench: Array, weights: Array, limits: Array, answer: Array, tension: Array, told: Array) -> int:
    """Do what `accept` does; return the bits of those that it would say OK of."""
    n, m = W.shape
    sound = holds(W, wrench, weights, limits, answer, told)
    for j in range(n):
        sound = sound & (abs(wrench[j]) < math.inf)
    for i in range(m):
        sound = sound & (abs(answer[i]) < math.inf) & (limits[0, i] <= limits[1, i])
        tension[i] = min(max(answer[i], limits[0, i]), limits[1, i])
    told[0] = OK
    return bits(sound)


@threaded_kernel(NOTHING(LANES_KERNEL, ROW, COMMON, ROWS, TABLE, CUBE, DONE))
def distribute_eights(
    lanes: Callable[..., int],
    parameters: Array,
    common: Common,
    given: Rows,
    space: Array,
    work: Array,
    done: NDArray[np.uint8],
) -> None:
    """Fill tension and report of the rows that `lanes` answers, to the bit as `distribute_rows` would, and say which.

    All cables must leave from points. Where it answers few, ever more rows are left out before it is asked again.
    """
    limits, poses, wrenches, tension, report = given
    lines, rows = common.lines, common.rows
    m, n = lines.shape[0], rows.shape[0]
    state, rest = space[:STATE], space[STATE:]
    wrench6, rest = rest[:WRENCH], rest[WRENCH:]
    W6, rest = rest[: 6 * m].reshape(6, m, WIDTH), rest[6 * m :]
    wrench, rest = rest[:n], rest[n:]
    W, rest = rest[: n * m].reshape(n, m, WIDTH), rest[n * m :]
    own, rest = rest[: 2 * m].reshape(2, m, WIDTH), rest[2 * m :]
    answer, accepted, told = rest[:m], rest[m : 2 * m], rest[2 * m :]
    _spread(limits, 0, own)
    k, pause = 0, 1
    while k + WIDTH <= poses.shape[0]:
        for lane in range(WIDTH):
            for i in range(7):
                state[i, lane] = poses[k + lane, i]
            if wrenches.shape[0] > 0:
                for i in range(6):
                    wrench6[i, lane] = wrenches[k + lane, i]
            for i in range(m):
                answer[i, lane] = math.nan
        if limits.shape[0] > 1:
            _spread(limits, k, own)
        _pose(common, side_by_side(state), side_by_side(W6), side_by_side(wrench6), wrenches.shape[0] > 0)
        select(rows, side_by_side(W6), side_by_side(wrench6), side_by_side(W), side_by_side(wrench))
        found = lanes(W, wrench, own[0], own[1], answer, parameters, work)
        if found:
            found &= _accept(
                side_by_side(W),
                side_by_side(wrench),
                common.weights,
                side_by_side(own),
                side_by_side(answer),
                side_by_side(accepted),
                side_by_side(told),
            )
        count = 0
        for lane in range(WIDTH):
            if found >> lane & 1:
                count += 1
                done[k + lane] = 1
                for i in range(m):
                    tension[k + lane, i] = accepted[i, lane]
                for i in range(REPORT):
                    report[k + lane, i] = told[i, lane]
        if count >= WORTHWHILE:
            pause = 1
            k += WIDTH
        else:
            k += WIDTH * (1 + pause)
            pause *= 2
