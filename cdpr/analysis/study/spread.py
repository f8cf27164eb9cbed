"""Mean and spread of a study's figures over the seeds of its runs, for each combination of the other axes.

An axis of seeds (`simulation.seed`) makes a study a Monte Carlo simulation: runs that differ only in the seed are
samples of one random experiment.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cdpr.analysis.study.plan import SEED, Grid, Study
from cdpr.analysis.study.points import Label
from cdpr.analysis.study.table import Cell, Table
from cdpr.log.consistency import band

WITHOUT_FIGURES = ("diverged", "failed", "died", "hung", "not run")  # statuses whose values are meaningless
BAND = 2.5, 97.5  # percentiles
SQUARES = ("nis", "nees")
PARTS = ("mean", "std", "low", "high")


class Distribution(NamedTuple):
    """Distribution of one figure over the runs.

    Attributes:
        mean: mean.
        std: standard deviation of the runs (n - 1); None for a single run.
        low, high: 2.5th and 97.5th percentiles, interpolated linearly: between them are 95 % of many runs.
    """

    mean: float
    std: float | None
    low: float
    high: float


class Consistent(NamedTuple):
    """Last NIS or NEES of all runs, which is independent from run to run.

    If the model of the estimator is right, the sum over the runs has a chi-square distribution: Bar-Shalom, Li,
    Kirubarajan (2001), section 5.4.2.

    Attributes:
        mean: mean per value.
        low, high: band that contains this mean with a probability of 95 %.
    """

    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Spread:
    """Figures of the runs that differ only in the seed.

    Attributes:
        block: name of the block; None without blocks.
        labels: their common values, by axis.
        runs: number of runs.
        used: number of runs that have figures.
        figures: distributions by column of the table.
        consistent: last "nis" and "nees" of all runs, if the estimator provides them.
    """

    block: str | None
    labels: Mapping[str, Label]
    runs: int
    used: int
    figures: Mapping[str, Distribution]
    consistent: Mapping[str, Consistent]


def seed_axis(grid: Grid) -> str | None:
    """Return the label of the axis that varies only the seed of the simulation; None without such an axis."""
    for axis, points in zip(grid.axes, grid.columns, strict=True):
        leaves = axis.leaves()
        if (
            len(points) > 1
            and len(leaves) == 1
            and {change.path for each in points for change in each.changes} == {SEED}
        ):
            return leaves[0].label
    return None


def spreads(study: Study, table: Table) -> list[Spread]:
    """Return the spreads of all parts of a study that vary the seed, in the order of their cases."""
    records = table.records()
    return [each for grid in study.blocks for each in _spreads(grid, table, records)]


def _spreads(grid: Grid, table: Table, records: Sequence[Mapping[str, Cell]]) -> Iterator[Spread]:
    seeds = seed_axis(grid)
    if seeds is None:
        return
    axes = [leaf.label for axis in grid.axes for leaf in axis.leaves() if leaf.label != seeds]
    groups: dict[tuple[Label, ...], list[Mapping[str, Cell]]] = {}
    for record in records:
        if record.get("block") == grid.name:
            groups.setdefault(tuple(record[axis] for axis in axes), []).append(record)
    for labels, runs in groups.items():
        used = [run for run in runs if run["status"] not in WITHOUT_FIGURES]
        found = {name: values for name in table.figures if (values := _numbers(used, name))}
        yield Spread(
            grid.name,
            dict(zip(axes, labels, strict=True)),
            len(runs),
            len(used),
            {name: distribution(values) for name, values in found.items()},
            {name: consistent(*squares) for name in SQUARES if all(squares := _last(used, name))},
        )


def distribution(values: Sequence[float]) -> Distribution:
    """Return mean and spread of values; at least one."""
    low, high = np.percentile(values, BAND).tolist()
    std = float(np.std(values, ddof=1)) if len(values) > 1 else None
    return Distribution(float(np.mean(values)), std, low, high)


def consistent(squares: Sequence[float], sizes: Sequence[float]) -> Consistent:
    """Return the mean per value of normalised squares with these degrees of freedom, and its 95 % band."""
    size = round(sum(sizes))
    low, high = band(size)
    return Consistent(sum(squares) / size, low / size, high / size)


def spread_table(study: Study, table: Table) -> Table | None:
    """Return the spreads as a table, a row per combination; None for a study that does not vary the seed."""
    found = spreads(study, table)
    if not found:
        return None
    axes = tuple(axis for axis in table.axes if any(axis in each.labels for each in found))
    names = [name for name in table.figures if any(name in each.figures for each in found)]
    kinds = [name for name in SQUARES if any(name in each.consistent for each in found)]
    columns = [f"{name}_{part}" for name in names for part in PARTS]
    columns += [f"estimate_{kind}_of_runs_{part}" for kind in kinds for part in Consistent._fields]
    blocks = ["block"] if "block" in table.columns else []
    rows = []
    for each in found:
        cells: list[Any] = [each.block] if blocks else []
        cells += [*(each.labels.get(axis) for axis in axes), each.runs, each.used]
        for name in names:
            cells += each.figures.get(name, [None] * len(PARTS))
        for kind in kinds:
            cells += each.consistent.get(kind, [None] * len(Consistent._fields))
        rows.append(tuple(cells))
    return Table(axes, tuple(columns), (*blocks, *axes, "runs", "runs_with_figures", *columns), tuple(rows))


def _numbers(runs: Sequence[Mapping[str, Cell]], name: str) -> list[float]:
    """Return the values of a figure that are numbers."""
    cells = (run[name] for run in runs)
    return [float(cell) for cell in cells if isinstance(cell, int | float) and not isinstance(cell, bool)]


def _last(runs: Sequence[Mapping[str, Cell]], kind: str) -> tuple[list[float], list[float]]:
    """Return the last normalised squares of runs, and their degrees of freedom."""
    name = f"estimate_{kind}_last"
    known = [run for run in runs if run.get(name) is not None]
    return _numbers(known, name), _numbers(known, f"{name}_values")
