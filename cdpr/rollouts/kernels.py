"""Looks at samples while they are at hand: counts them, and keeps some."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr.model.jit import any_width, kernel, threaded_kernel
from cdpr.model.kernels import conjugate, logarithm, multiply, quaternion
from cdpr.model.kinds import INDICES, NOTHING, ROW, TABLE, WHOLE
from cdpr.model.lanes import choose
from cdpr.model.robot import Array
from cdpr.tension.status import Status

# Places in the figures that are no errors.
LOW, HIGH, INFEASIBLE, UNANSWERED = range(6, 10)

ANSWERED, NO_TENSIONS = int(Status.OK), int(Status.INFEASIBLE)


@any_width
@kernel
def count(row: Array, since: Array, at: NDArray[np.int64], figures: Array) -> None:
    """Add a sample to the figures, in the order of FIGURES; a NaN stays."""
    square = 0.0
    for i in range(3):
        miss = row[at[1] + i] - row[at[0] + i]
        square += miss * miss
    turn = logarithm(multiply(quaternion(row, at[3]), conjugate(quaternion(row, at[2]))))
    angle = turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]
    for first, value in ((0, square), (3, angle)):
        error = math.sqrt(value)
        figures[first] = choose((error > figures[first]) | (error != error), error, figures[first])
        figures[first + 1] += value
        figures[first + 2] = error
    for i in range(since.shape[0]):
        tension, counts = row[at[4] + i], row[0] < since[i]
        low, high = figures[LOW], figures[HIGH]
        figures[LOW] = choose(counts & ((tension < low) | (tension != tension)), tension, low)
        figures[HIGH] = choose(counts & ((tension > high) | (tension != tension)), tension, high)
    status = row[at[5]]
    figures[INFEASIBLE] += choose(status == NO_TENSIONS, 1.0, 0.0)
    figures[UNANSWERED] += choose((status == NO_TENSIONS) | (status == ANSWERED), 0.0, 1.0)


@threaded_kernel(NOTHING(TABLE, WHOLE, ROW, INDICES, ROW, INDICES, WHOLE, TABLE))
def take(
    rows: Array,
    sample: int,
    since: Array,
    at: NDArray[np.int64],
    figures: Array,
    places: NDArray[np.int64],
    every: int,
    kept: Array,
) -> None:
    """Count rows (n, width), of which the first is that of a sample, and keep the columns (W,) of each so manyth."""
    for k in range(rows.shape[0]):
        row = rows[k]
        count(row, since, at, figures)
        if (sample + k) % every == 0:
            for i in range(places.shape[0]):
                kept[(sample + k) // every, i] = row[places[i]]
