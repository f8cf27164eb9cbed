"""The figures of a workspace, told piece by piece: the same bits whether its table is in memory or in a folder."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cdpr.workspace.kinds import WorkspaceKind
from cdpr.workspace.octree import Asked
from cdpr.workspace.question import Question
from cdpr.workspace.regions import Region


class Detail(Protocol):
    """What a method found that is finer than cells."""

    @property
    def volume(self) -> float:
        """What it says is inside, m^3, m^2 or m."""
        ...

    def told(self) -> dict[str, Any]:
        """Return its figures."""
        ...


Corner = tuple[int, ...]


@dataclass(frozen=True)
class Tally:
    """What is counted of some cells.

    Attributes:
        cells, inside, boundary, unlimited, without: of the cells: all, those inside, those that round-off decides,
            those inside whose value is infinite, those without one.
        corners: least and greatest number along each axis of the cells inside.
        known: how many inside have a finite value.
        sums: of those, one for each piece: what is added in another order has other bits.
        least, most: of those.
        outside: of the cells outside, how many are limited by what, by its number.
        limits: numbers of all that limits a cell.
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
        """Of the known values."""
        return math.fsum(self.sums) / self.known if self.known else None


def tally(cells: NDArray[np.int64], shape: tuple[int, ...], found: Asked) -> Tally:
    """Count one piece: cells (n,) of a table of this shape, by their numbers, and what was found there."""
    value, limit, inside, boundary = found
    values = value[inside]
    known = values[np.isfinite(values)]
    corners = None
    if len(values):
        along = np.unravel_index(cells[inside], shape)
        corners = (tuple(int(i.min()) for i in along), tuple(int(i.max()) for i in along))
    numbers, counts = np.unique(limit[~inside], return_counts=True)
    return Tally(
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


def total(parts: Iterable[Tally]) -> Tally:
    """Return what all parts count together, given in the order of their cells."""
    every = list(parts)
    corners = [part.corners for part in every if part.corners is not None]
    outside: dict[str, int] = {}
    for part in every:
        for number, count in part.outside.items():
            outside[number] = outside.get(number, 0) + count
    return Tally(
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
    counted: Tally,
    *,
    evaluated: int,
    components: int,
    detail: Detail | None = None,
) -> dict[str, Any]:
    """Return the figures of a workspace as plain numbers.

    `evaluated` of its cells were looked at, those inside are in so many pieces, and `detail` says more where there is.
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
        "found": None if detail is None else detail.told(),
        "oracle": about.get("oracle"),
    }


def _each(choose: Any, corners: Iterator[Corner]) -> Corner:
    """The least or the greatest along each axis."""
    return tuple(choose(along) for along in zip(*corners, strict=True))
