"""Figures of a case, computed from all its samples while it runs, in compiled code."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cdpr.log.layout import Layout
from cdpr.model.robot import Array
from cdpr.native.bind import bind

# Column names of a study's table and of Run.summary(); the sums of squares become a mean at the end.
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
# Indices of the figures that are no errors.
LOW, HIGH, INFEASIBLE = range(6, 9)

# Columns of a row that are evaluated.
AT = ("position", "desired_position", "orientation", "desired_orientation", "tension", "status")


class Figures:
    """Accumulator of the samples of one case.

    Args:
        layout: columns of a sample.
        row: present sample, live.
        broken: broken cables, which are ignored from a time on, s.

    Attributes:
        values: accumulated values in the order of FIGURES, live.
        samples: number of samples.
        counting: operation that evaluates the present sample.
    """

    def __init__(self, layout: Layout, row: Array, broken: Sequence[tuple[int, float]]) -> None:
        since = np.full(layout.m, np.inf)
        for cable, time in broken:
            since[cable] = min(time, since[cable])
        at = np.array([layout.columns[name].start for name in AT])
        self.values = np.zeros(len(FIGURES))
        self.restart()
        self._given = {"since": since, "at": at, "figures": self.values}
        self.counting = bind("count_sample", row=row, **self._given)

    def restart(self) -> None:
        """Discard all samples."""
        self.values[:] = 0.0
        self.values[LOW], self.values[HIGH] = np.inf, -np.inf
        self.samples = 0

    def take(self, rows: Array, places: NDArray[np.int64], every: int, kept: Array) -> None:
        """Evaluate the next samples, (n, width), C-contiguous, and store columns of one in `every`, (K, W)."""
        counting = bind(
            "count_samples", rows=rows, first=self.samples, columns=places, every=every, kept=kept, **self._given
        )
        counting.unlocked()
        self.samples += len(rows)

    def to_dict(self) -> dict[str, float | int]:
        """Return the figures by name, and the number of samples."""
        values = dict(zip(FIGURES, self.values.tolist(), strict=True))
        for name in ("position_error_rms_m", "orientation_error_rms_rad"):
            values[name] = math.sqrt(values[name] / self.samples) if self.samples else 0.0
        if values["tension_min_N"] == math.inf:  # no sample, or all cables are broken from the first on
            values["tension_min_N"] = values["tension_max_N"] = 0.0
        counts = {name: int(values[name]) for name in FIGURES[INFEASIBLE:]}
        return {"samples": self.samples, **values, **counts}
