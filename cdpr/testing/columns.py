"""The columns of a plugin as a simulation would give them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cdpr.model import Robot
from cdpr.plugins import Backend, Column, Controller, TensionSolver
from cdpr.testing.check import expect, needs

GUARD = 1234.5  # stands between the columns, which nobody may write over
SAMPLES = 5


def expect_written(
    columns: tuple[Column, ...],
    robot: Robot,
    part: Backend | Controller | TensionSolver,
    start: Callable[[], object],
    work: Callable[[int], object],
) -> str:
    """Fail unless a plugin writes finite numbers into all columns that it was given, and nothing beside them.

    Args:
        columns: what it declares.
        robot: the one that it was made for.
        part: the plugin.
        start: resets it.
        work: makes it do what a sample asks for, given the number of the sample.
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
        expect((row[outside] == GUARD).all(), f"something beside the columns was written in sample {k}")
    return f"{', '.join(views)}: {row.size - int(outside.sum())} numbers a sample"
