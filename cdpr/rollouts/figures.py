"""The figures of a case, counted from all its samples while it runs, in compiled code."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cdpr.log.layout import Layout
from cdpr.model.robot import Array
from cdpr.rollouts.kernels import HIGH, INFEASIBLE, LOW, count

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
# Where a row has what `count` looks at.
AT = ("position", "desired_position", "orientation", "desired_orientation", "tension", "status")


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
