"""The figures of a case, counted from all its samples while it runs, in compiled code."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import types
from numpy.typing import NDArray

from cdpr.log.layout import Layout
from cdpr.model.jit import threaded_kernel
from cdpr.model.kernels import conjugate, logarithm, multiply, quaternion
from cdpr.model.robot import Array
from cdpr.tension.status import Status

# As the columns of a study's table are called, and Run.summary() has them; the squares become a mean at the end.
FIGURES = (
    "position_error_max_m",
    "position_error_rms_m",
    "position_error_final_m",
    "orientation_error_max_rad",
    "orientation_error_rms_rad",
    "orientation_error_final_rad",
    "tension_min_N",
    "tension_max_N",
    "infeasible_steps",
    "unanswered_steps",
)
LOW, HIGH, INFEASIBLE, UNANSWERED = range(6, 10)
ANSWERED, NO_TENSIONS = int(Status.OK), int(Status.INFEASIBLE)
AT = ("position", "desired_position", "orientation", "desired_orientation", "tension", "status")

MATRIX, VECTOR, INDICES = types.float64[:, ::1], types.float64[::1], types.int64[::1]


class Figures:
    """Counts the samples of one case; `broken` are cables that count no more, and from when on, s."""

    def __init__(self, layout: Layout, broken: Sequence[tuple[int, float]]) -> None:
        self._since = np.full(layout.m, np.inf)
        for cable, time in broken:
            self._since[cable] = min(time, self._since[cable])
        self._at = np.array([layout.columns[name].start for name in AT])
        self._values = np.zeros(len(FIGURES))
        self._values[LOW], self._values[HIGH] = np.inf, -np.inf
        self.samples = 0

    def add(self, rows: Array) -> None:
        """Count the samples that follow, (n, width), C-contiguous."""
        count(rows, self._since, self._at, self._values)
        self.samples += len(rows)

    def told(self) -> dict[str, float | int]:
        """Return the figures by name, and the number of samples."""
        values = dict(zip(FIGURES, self._values.tolist(), strict=True))
        for name in ("position_error_rms_m", "orientation_error_rms_rad"):
            values[name] = math.sqrt(values[name] / self.samples) if self.samples else 0.0
        if values["tension_min_N"] == math.inf:  # no sample, or all cables are broken from the first on
            values["tension_min_N"] = values["tension_max_N"] = 0.0
        counts = {name: int(values[name]) for name in FIGURES[INFEASIBLE:]}
        return {"samples": self.samples, **values, **counts}


@threaded_kernel(types.void(MATRIX, VECTOR, INDICES, VECTOR))
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
