"""Counts samples while they are at hand."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr.model.jit import threaded_kernel
from cdpr.model.kernels import conjugate, logarithm, multiply, quaternion
from cdpr.model.kinds import INDICES, NOTHING, ROW, TABLE
from cdpr.model.robot import Array
from cdpr.tension.status import Status

# Places in the figures that are no errors.
LOW, HIGH, INFEASIBLE, UNANSWERED = range(6, 10)

ANSWERED, NO_TENSIONS = int(Status.OK), int(Status.INFEASIBLE)


@threaded_kernel(NOTHING(TABLE, ROW, INDICES, ROW))
def count(rows: Array, since: Array, at: NDArray[np.int64], figures: Array) -> None:
    """Add rows (n, width) to the figures, in the order of FIGURES; a NaN stays."""
    for k in range(rows.shape[0]):
        row = rows[k]
        square = 0.0
        for i in range(3):
            square += (row[at[1] + i] - row[at[0] + i]) ** 2
        turn = logarithm(multiply(quaternion(row, at[3]), conjugate(quaternion(row, at[2]))))
        angle = turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]
        for first, value in ((0, square), (3, angle)):
            error = math.sqrt(value)
            if error > figures[first] or error != error:
                figures[first] = error
            figures[first + 1] += value
            figures[first + 2] = error
        for i in range(since.shape[0]):
            if row[0] < since[i]:
                tension = row[at[4] + i]
                if tension < figures[LOW] or tension != tension:
                    figures[LOW] = tension
                if tension > figures[HIGH] or tension != tension:
                    figures[HIGH] = tension
        status = row[at[5]]
        if status == NO_TENSIONS:
            figures[INFEASIBLE] += 1.0
        elif status != ANSWERED:
            figures[UNANSWERED] += 1.0
