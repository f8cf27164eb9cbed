"""Points of a study's axes: labels and changes."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import reduce
from itertools import product
from typing import Any

from cdpr.analysis.jobs.draw import MAX_COUNT, drawn
from cdpr.analysis.study.schema import Axis, Range, Spaced
from cdpr.base import tolerances
from cdpr.base.problems import Path
from cdpr.config.document import Document
from cdpr.config.overrides import Change, marked_changes
from cdpr.config.problems import Problems

DIGITS = 12  # significant digits of computed values: 0.1 + 2 * 0.1 must give 0.3

Label = bool | int | float | str | None


@dataclass(frozen=True)
class Point:
    """Point on an axis, or on the product of several."""

    labels: dict[str, Label] = field(default_factory=dict)  # by axis
    changes: tuple[Change, ...] = ()

    def __add__(self, other: Point) -> Point:
        return Point({**self.labels, **other.labels}, (*self.changes, *other.changes))


def product_of(columns: Sequence[Sequence[Point]]) -> Iterator[Point]:
    """Yield the points of a grid; the last axis varies fastest."""
    for points in product(*columns):
        yield reduce(Point.__add__, points, Point())


@dataclass(frozen=True)
class Reader:
    """Reader of the axes of one study file; errors are collected in `problems`."""

    document: Document
    problems: Problems
    seed: int

    def axis(self, axis: Axis, path: Path) -> list[Point]:
        """Return the points of an axis with its section at `path`."""
        seen: set[tuple[str, ...]] = set()
        points = self._points(axis, path)
        for place, point in points:
            labels = tuple(map(str, point.labels.values()))
            if labels in seen:
                self.problems.add(self.document.mark(place), place, f"the axis contains {', '.join(labels)} twice")
            seen.add(labels)
        return [point for _, point in points]

    def changes(self, given: dict[str, Any], path: Path) -> tuple[Change, ...]:
        """Return the changes in a mapping at `path`."""
        rows = [(key, value, self.document.mark((*path, key))) for key, value in given.items()]
        return tuple(marked_changes(rows, self.problems))

    def _points(self, axis: Axis, path: Path) -> list[tuple[Path, Point]]:
        """Return the points of an axis, each with its position in the file."""
        points = []
        if axis.zip is not None:
            return self._zipped(axis.zip, (*path, "zip"))
        if axis.points is not None:
            for name, given in axis.points.items():
                place: Path = (*path, "points", name)
                points.append((place, Point({axis.label: name}, self.changes(given, place))))
            return points
        for place, value in self._values(axis, path):
            label = value if isinstance(value, Label) else json.dumps(value, ensure_ascii=False)
            rows = [(key, value, self.document.mark(place)) for key in axis.targets]
            points.append((place, Point({axis.label: label}, tuple(marked_changes(rows, self.problems)))))
        return points

    def _zipped(self, axes: Sequence[Axis], path: Path) -> list[tuple[Path, Point]]:
        columns = [[point for _, point in self._points(axis, (*path, i))] for i, axis in enumerate(axes)]
        lengths = [len(column) for column in columns]
        if len(set(lengths)) != 1:
            found = ", ".join(map(str, lengths))
            self.problems.add(self.document.mark(path), path, f"expected axes of equal length, got {found} values")
        return [(path, reduce(Point.__add__, points)) for points in zip(*columns, strict=False)]

    def _values(self, axis: Axis, path: Path) -> list[tuple[Path, Any]]:
        """Return the values of an axis, each with its position in the file."""
        if axis.values is not None:
            return [((*path, "values", i), value) for i, value in enumerate(axis.values)]
        found: Sequence[float]
        try:
            if axis.range is not None:
                place, found = (*path, "range"), _stepped(axis.range)
            elif axis.linspace is not None:
                place, found = (*path, "linspace"), _linear(axis.linspace)
            elif axis.logspace is not None:
                place, found = (*path, "logspace"), _logarithmic(axis.logspace)
            else:
                assert axis.random is not None
                place, found = (*path, "random"), drawn(axis.random, f"{self.seed} {axis.label}")
        except ValueError as error:
            place, found = path, ()
            self.problems.add(self.document.mark(path), path, str(error))
        return [(place, value) for value in found]


def _stepped(given: Range) -> list[float]:
    start, stop, step = given.start, given.stop, given.step
    steps = (stop - start) / step if step else -1.0
    if steps < 0:
        raise ValueError(f"steps of {step:g} do not lead from {start:g} to {stop:g}")
    if steps > MAX_COUNT:  # perhaps infinite, with a denormal step
        raise ValueError(f"{steps:g} steps; at most {MAX_COUNT} values are allowed")
    count = math.floor(steps + tolerances.TIME) + 1
    if all(isinstance(value, int) for value in (start, stop, step)):
        return [start + i * step for i in range(count)]
    return [_rounded(start + i * step) for i in range(count)]


def _linear(given: Spaced) -> list[float]:
    width = (given.stop - given.start) / (given.count - 1)
    return [_rounded(given.start + i * width) for i in range(given.count - 1)] + [given.stop]


def _logarithmic(given: Spaced) -> list[float]:
    if min(given.start, given.stop) <= 0:
        raise ValueError(f"logspace needs values greater than 0, got {min(given.start, given.stop):g}")
    ratio = given.stop / given.start
    if ratio == math.inf:
        raise ValueError(f"{given.start:g} and {given.stop:g} are too far apart")
    inner = [_rounded(given.start * ratio ** (i / (given.count - 1))) for i in range(1, given.count - 1)]
    return [given.start, *inner, given.stop]


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
