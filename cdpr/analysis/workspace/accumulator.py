"""Figures of a workspace, counted in batches, with the same bits for tables in memory and in folders."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace.kinds import WorkspaceKind
from cdpr.analysis.workspace.octree import CellResults
from cdpr.analysis.workspace.question import Question
from cdpr.analysis.workspace.regions import Region


class Detail(Protocol):
    """Result of a method that is finer than cells."""

    @property
    def volume(self) -> float:
        """Size of the inside, m^3, m^2 or m."""
        ...

    def figures(self) -> dict[str, Any]:
        """Return its figures."""
        ...


Corner = tuple[int, ...]


@dataclass(frozen=True)
class Accumulator:
    """Counts over some cells.

    Attributes:
        cells, inside, boundary, unlimited, without: numbers of all cells, of those inside, decided by round-off, inside
            with infinite value, and without value.
        corners: smallest and greatest index along each axis of the inside cells.
        known: number of inside cells with finite value.
        sums: sums of these values, one per batch, because the bits of a sum depend on its order.
        least, most: smallest and largest of these values.
        outside: number of outside cells by the number of their limiting cause.
        limits: numbers of all limiting causes.
    """

    cells: int = 0
    inside: int = 0
    boundary: int = 0
    unlimited: int = 0
    without: int = 0
    corners: tuple[Corner, Corner] | None = None
    known: int = 0
    sums: tuple[float, ...] = ()
    least: float | None = None
    most: float | None = None
    outside: Mapping[str, int] = field(default_factory=dict)
    limits: tuple[int, ...] = ()

    @property
    def mean(self) -> float | None:
        """Mean of the known values."""
        return math.fsum(self.sums) / self.known if self.known else None


def tally(cells: NDArray[np.int64], shape: tuple[int, ...], found: CellResults) -> Accumulator:
    """Return the counts of one batch: cells (n,) of a table of this shape, by number, with their results."""
    value, limit, inside, boundary = found
    values = value[inside]
    known = values[np.isfinite(values)]
    corners = None
    if len(values):
        along = np.unravel_index(cells[inside], shape)
        corners = (tuple(int(i.min()) for i in along), tuple(int(i.max()) for i in along))
    numbers, counts = np.unique(limit[~inside], return_counts=True)
    return Accumulator(
        len(cells),
        len(values),
        int(boundary.sum()),
        int(np.isposinf(values).sum()),
        int(np.isnan(value).sum()),
        corners,
        len(known),
        (float(known.sum()),),
        float(known.min()) if len(known) else None,
        float(known.max()) if len(known) else None,
        {str(n): count for n, count in zip(numbers.tolist(), counts.tolist(), strict=True)},
        tuple(np.unique(limit).tolist()),
    )


def total(parts: Iterable[Accumulator]) -> Accumulator:
    """Return the total of all parts, given in the order of their cells."""
    every = list(parts)
    corners = [part.corners for part in every if part.corners is not None]
    outside: dict[str, int] = {}
    for part in every:
        for number, count in part.outside.items():
            outside[number] = outside.get(number, 0) + count
    return Accumulator(
        sum(part.cells for part in every),
        sum(part.inside for part in every),
        sum(part.boundary for part in every),
        sum(part.unlimited for part in every),
        sum(part.without for part in every),
        (_each(min, (low for low, _ in corners)), _each(max, (high for _, high in corners))) if corners else None,
        sum(part.known for part in every),
        tuple(each for part in every for each in part.sums),
        min((part.least for part in every if part.least is not None), default=None),
        max((part.most for part in every if part.most is not None), default=None),
        outside,
        tuple(sorted({number for part in every for number in part.limits})),
    )


def figures(
    kind: WorkspaceKind,
    robot: str,
    region: Region,
    question: Question,
    about: Mapping[str, Any],
    counted: Accumulator,
    *,
    evaluated: int,
    components: int,
    detail: Detail | None = None,
) -> dict[str, Any]:
    """Return the figures of a workspace as plain numbers.

    `evaluated` is the number of evaluated cells, `components` the number of connected parts, and `detail` the finer
    result, if any.
    """
    volume = float(counted.inside) * region.cell if detail is None else detail.volume
    bounds = None
    if counted.corners is not None:
        low, high = np.array(counted.corners[0]), np.array(counted.corners[1])
        bounds = [(region.lower + low * region.spacing).tolist(), (region.lower + (high + 1) * region.spacing).tolist()]
    names = about["limited_by"]
    outside = {names[number]: count for number, count in counted.outside.items() if number in names}
    spread = {"min": counted.least, "mean": counted.mean, "max": counted.most}
    return {
        "kind": kind.name,
        "robot": robot,
        "volume": volume,
        "unit": region.unit,
        "share": counted.inside / counted.cells if detail is None else volume / (region.cell * region.cells),
        "bounds": bounds,
        "components": components,
        "value": {"name": kind.value, "unit": kind.unit_of(question), **spread},
        "at_least": question.at_least,
        "outside_by": dict(sorted(outside.items(), key=lambda each: (-each[1], each[0]))),
        "cells": list(region.shape),
        "method": about["method"],
        "evaluated": evaluated * len(region.orientations),
        "orientations": len(region.orientations),
        "unlimited": counted.unlimited,
        "notes": about.get("notes", []),
        "on_boundary": counted.boundary,
        "without_value": counted.without,
        "box": [region.lower.tolist(), region.upper.tolist()],
        "found": None if detail is None else detail.figures(),
        "oracle": about.get("oracle"),
    }


def _each(choose: Any, corners: Iterator[Corner]) -> Corner:
    """Return the smallest or the greatest index along each axis."""
    return tuple(choose(along) for along in zip(*corners, strict=True))
