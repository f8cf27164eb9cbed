"""Compensated lengths along the motion of a scenario, as a table."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cdpr.analysis.equilibrium.compensation import Compensation, compensated_lengths
from cdpr.base.errors import CdprError
from cdpr.log.csv_lines import csv_lines
from cdpr.model.robot import Array
from cdpr.scenario import Scenario

MOST_SAMPLES = 10_000_000


@dataclass(frozen=True, eq=False)
class CompensatedPath:
    """Compensated lengths at K samples of a motion.

    Attributes:
        time: (K,) times [s].
        poses: (K, 7) desired positions [m] and quaternions w, x, y, z.
        found: lengths, tensions and statuses of the samples.
    """

    time: Array
    poses: Array
    found: Compensation

    def csv(self, names: list[str]) -> bytes:
        """Return the table as CSV; `names` are those of the cables."""
        header = [
            "t",
            *(f"position_{axis}_m" for axis in "xyz"),
            *(f"orientation_{axis}" for axis in "wxyz"),
            *(f"length_{name}_m" for name in names),
            *(f"tension_{name}_N" for name in names),
            "status",
        ]
        status = np.asarray(self.found.status, dtype=float)
        rows = np.column_stack([self.time, self.poses, self.found.lengths, self.found.tension, status])
        return ",".join(header).encode() + b"\n" + csv_lines(rows)


def compensated_path(scenario: Scenario, step: float | None, solver: str) -> CompensatedPath:
    """Compute compensated lengths along the desired motion, from its start to its end.

    Args:
        scenario: robot, motion and gravity.
        step: time between two samples [s]. Default: the control step.
        solver: name of an installed tension solver.

    Raises:
        CdprError: if there would be more than MOST_SAMPLES samples.
    """
    step = scenario.simulation.control_step if step is None else step
    begin, end = scenario.desired.start, scenario.desired.end
    if not math.isfinite(end):
        end = scenario.simulation.duration
    count = (end - begin) / step
    if not count < MOST_SAMPLES:
        raise CdprError(
            f"--step: expected at most {MOST_SAMPLES} samples of the motion, got {count:.3g}: use a longer step"
        )
    time = np.append(begin + step * np.arange(math.ceil(count - 1e-9)), end)
    poses = np.array([scenario.desired.sample(float(t))[:7] for t in time])
    return CompensatedPath(time, poses, compensated_lengths(scenario, poses, solver=solver))
