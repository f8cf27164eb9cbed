"""Check of a plugin's columns, provided as in a simulation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cdpr.model import Robot
from cdpr.plugins import Backend, Column, Controller, Estimator, TensionSolver
from cdpr.testing.check import expect, needs

GUARD = 1234.5  # separates the columns and must not be overwritten
SAMPLES = 5


def expect_written(
    columns: tuple[Column, ...],
    robot: Robot,
    part: Backend | Controller | Estimator | TensionSolver,
    start: Callable[[], object],
    work: Callable[[int], object],
) -> str:
    """Fail unless a plugin writes finite numbers into all its columns and nothing else.

    Args:
        columns: its declared columns.
        robot: its robot.
        part: the plugin.
        start: function that resets it.
        work: function that lets it process a sample, given the sample number.
    """
    needs(columns, "it declares no columns")
    row = np.full(1 + sum(1 + (column.width or robot.m) for column in columns), GUARD)
    views, first = {}, 1
    for column in columns:
        views[column.name] = row[first : first + (column.width or robot.m)]
        first += len(views[column.name]) + 1
    for view in views.values():
        view[:] = np.nan
    outside = row == GUARD
    part.log(dict(views))
    start()
    for k in range(SAMPLES):
        work(k)
        for name, view in views.items():
            expect(np.isfinite(view).all(), f"column '{name}' is {view.tolist()} after sample {k}")
        expect((row[outside] == GUARD).all(), f"sample {k}: other columns were written")
    return f"{', '.join(views)}: {row.size - int(outside.sum())} numbers a sample"
