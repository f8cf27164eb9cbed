"""Adaptive evaluation of a region's cells; the others are interpolated.

A box of cells is interpolated from its corners if they are all inside or all outside, and farther from the edge than a
share of their spread. Any other box is divided into eight. Of the new corners, only the corners that may lie on the
other side are evaluated. The interpolation error there is estimated from the error of the parent box, at half the
distance. Features thinner than the initial boxes that no corner touches are missed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace.regions import Region
from cdpr.model.robot import Array

Cells = NDArray[np.int64]
Flags = NDArray[np.bool_]

START = 16  # minimum number of initial boxes along the longest side
NEAR = 0.25  # minimum distance of a box's corners from the edge, as a share of their spread
# Estimated ratio of successive interpolation errors: a quarter for smooth values, half for values with kinks, more if
# the last box revealed less of its error. On CoGiRo, Caroca and IPAnema 1 with 160^3 cells, 1 in 4000 inside cells is
# wrong and a 60th is evaluated; with 0.5, 1 in 800; with 1.0, 1 in 10 000 and a quarter more evaluations.
ERROR = 0.75

POINTS_AT_ONCE = 16_384  # points interpolated together: their tables fit into the processor's cache

CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
AXES = np.arange(3)
POINTS = np.array([[i, j, k] for i in (0, 1, 2) for j in (0, 1, 2) for k in (0, 1, 2)])  # of a divided box


class CellResults(NamedTuple):
    """Results of cells, each (n,): value, limiting cause, True if inside, True if round-off decides."""

    value: Array
    limit: NDArray[np.int64]
    inside: Flags
    boundary: Flags


def octree(
    evaluate: Callable[[Cells], CellResults],
    region: Region,
    edge: float,
    slope: float | None,
    progress: Callable[[int, int], None],
) -> tuple[CellResults, Flags]:
    """Return the results of all cells of a table, (cells,), and True for the evaluated cells.

    Args:
        evaluate: function that evaluates cells, (n,), by number.
        region: region with the cells.
        edge: value between inside and outside.
        slope: largest change of the value per metre, which makes the result exact; None if unknown.
        progress: called with the number of known cells and their total.
    """
    return _Octree(evaluate, region, edge, slope, progress).found()


class _Octree:
    def __init__(
        self,
        evaluate: Callable[[Cells], CellResults],
        region: Region,
        edge: float,
        slope: float | None,
        progress: Callable[[int, int], None],
    ) -> None:
        cells = region.cells
        self._evaluate, self._shape, self._edge, self._progress = evaluate, region.shape, edge, progress
        self._slope, self._spacing = slope, region.spacing
        self._all = CellResults(
            np.full(cells, np.nan), np.full(cells, -1, dtype=np.int64), np.zeros(cells, bool), np.zeros(cells, bool)
        )
        self._evaluated = np.zeros(cells, dtype=bool)
        self._known = np.zeros(cells, dtype=bool)  # evaluated or interpolated
        self._strides = np.array([self._shape[1] * self._shape[2], self._shape[2], 1])

    def found(self) -> tuple[CellResults, Flags]:
        boxes, error = self._first()
        while len(boxes):
            settled = self._settled(boxes)
            self._interpolate(boxes[settled])
            boxes, error = boxes[~settled], error[~settled]
            boxes, error = self._cut(boxes, error)
            self._progress(int(np.count_nonzero(self._known)), len(self._known))
        return self._all, self._evaluated

    def _numbers(self, places: Cells) -> Cells:
        return np.asarray(places @ self._strides, dtype=np.int64)

    def _first(self) -> tuple[Cells, Array]:
        """Return the initial boxes, (n, 3, 2), lowest and highest cells, after evaluation of their corners."""
        step = 1
        while max(self._shape) // (2 * step) >= START:
            step *= 2
        ends = [np.unique([*range(0, n, step), n - 1]) for n in self._shape]
        spans = [np.stack([e[:-1], e[1:]], axis=1) if len(e) > 1 else np.array([[0, 0]]) for e in ends]
        index = np.stack(np.meshgrid(*(np.arange(len(s)) for s in spans), indexing="ij"), axis=-1).reshape(-1, 3)
        boxes = np.stack([spans[i][index[:, i]] for i in range(3)], axis=1)
        self._answer(self._numbers(_corners(boxes)).ravel())
        return boxes, np.full(len(boxes), np.inf)

    def _answer(self, numbers: Cells) -> None:
        """Evaluate the cells that are not evaluated yet."""
        wanted = np.zeros(len(self._evaluated), dtype=bool)
        wanted[numbers] = True
        new = np.flatnonzero(wanted & ~self._evaluated)
        if len(new):
            for kept, found in zip(self._all, self._evaluate(new), strict=True):
                kept[new] = found
            self._evaluated[new] = self._known[new] = True

    def _settled(self, boxes: Cells) -> Flags:
        """Return True for boxes whose corners determine the cells in between, (n,)."""
        numbers = self._numbers(_corners(boxes))
        inside, off = self._all.inside[numbers], self._all.value[numbers] - self._edge
        same = np.asarray((inside == inside[:, :1]).all(axis=1))
        with np.errstate(invalid="ignore"):
            far = np.abs(off).min(axis=1) > NEAR * (off.max(axis=1) - off.min(axis=1))
        alike = np.isnan(off).all(axis=1) | np.isposinf(off).all(axis=1) | np.isneginf(off).all(axis=1)
        if self._slope is not None:  # each cell is closer to a corner than half a diagonal
            far &= np.abs(off).min(axis=1) > self._slope * self._diagonal(boxes) / 2.0
        return np.asarray(same & (far | alike))

    def _diagonal(self, boxes: Cells) -> Array:
        """Return the lengths of the diagonals of boxes, (n,), m."""
        return np.asarray(np.linalg.norm((boxes[:, :, 1] - boxes[:, :, 0]) * self._spacing, axis=1))

    def _interpolate(self, boxes: Cells) -> None:
        """Interpolate the cells of boxes from their corners."""
        sizes = boxes[:, :, 1] - boxes[:, :, 0]
        for size, some in _alike(sizes):
            steps = np.stack(np.meshgrid(*(np.arange(s + 1) for s in size), indexing="ij"), axis=-1).reshape(-1, 3)
            count = max(1, POINTS_AT_ONCE // len(steps))
            for first in reversed(range(0, len(some), count)):  # on common faces, the last box applies
                self._between(boxes[some[first : first + count]], size, steps)

    def _between(self, boxes: Cells, size: Cells, steps: Cells) -> None:
        """Write the interpolated values at steps (p, 3) from the lowest cells of boxes of one size (3,)."""
        share, lowest = steps / np.maximum(size, 1), self._numbers(boxes[:, :, 0])[:, None]
        corners, numbers = lowest + self._numbers(CORNERS * size), lowest + self._numbers(steps)
        new = ~self._known[numbers]
        here = numbers[new]
        self._all.value[here] = _mix(self._all.value[corners], share)[new]
        self._all.limit[here] = self._all.limit[corners][:, _nearest(share)][new]
        self._all.inside[here] = np.broadcast_to(self._all.inside[corners[:, :1]], numbers.shape)[new]
        self._known[here] = True

    def _cut(self, boxes: Cells, error: Array) -> tuple[Cells, Array]:
        """Divide boxes into up to eight with known corners; return those with inner cells, and their errors.

        The error is the interpolation error observed in the parent box.
        """
        size = boxes[:, :, 1] - boxes[:, :, 0]
        whole = size.max(axis=1) > 1
        boxes, error, size = boxes[whole], error[whole], size[whole]
        middle = boxes[:, :, 0] + size // 2
        thirds = np.stack([boxes[:, :, 0], middle, boxes[:, :, 1]], axis=2)  # lowest, middle, highest
        numbers = self._numbers(thirds[:, AXES, POINTS])
        corners = self._numbers(_corners(boxes))
        value, nearest = np.empty(numbers.shape), np.empty_like(numbers)
        for one, some in _alike(size):
            share = np.stack([np.zeros(3), one // 2, one])[POINTS, np.arange(3)] / np.maximum(one, 1)
            value[some] = _mix(self._all.value[corners[some]], share)
            nearest[some] = corners[some][:, _nearest(share)]
        with np.errstate(invalid="ignore"):
            sure = np.abs(value - self._edge) > ERROR * error[:, None]
        if self._slope is not None:  # the interpolated value is a mean of the corners
            sure &= np.abs(value - self._edge) > self._slope * self._diagonal(boxes)[:, None]
            sure &= size.max(axis=1)[:, None] == 2  # interpolated values must not become corners of other boxes
        self._answer(numbers[~sure])
        given = sure & ~self._known[numbers]
        here = numbers[given]
        self._all.value[here], self._all.inside[here] = value[given], value[given] > self._edge
        self._all.limit[here] = self._all.limit[nearest[given]]
        self._known[here] = True
        with np.errstate(invalid="ignore"):
            missed = np.abs(self._all.value[numbers] - value)
        missed[~np.isfinite(missed)] = np.inf
        children = np.stack([thirds[:, AXES, CORNERS], thirds[:, AXES, CORNERS + 1]], axis=3)
        parts, errors = children.reshape(-1, 3, 2), np.repeat(missed.max(axis=1, initial=0.0), 8)
        extent = parts[:, :, 1] - parts[:, :, 0]
        proper = (extent.max(axis=1) > 1) & ~((extent == 0) & (np.repeat(size, 8, axis=0) > 0)).any(axis=1)
        return parts[proper], errors[proper]


def _corners(boxes: Cells) -> Cells:
    """Return the corner cells, (n, 8, 3), of boxes (n, 3, 2)."""
    return boxes[:, AXES, CORNERS]


def _alike(sizes: Cells) -> Iterator[tuple[Cells, Cells]]:
    """Yield each distinct size (3,) of sizes (n, 3) in order, with the indices of its occurrences."""
    number = sizes @ (np.int64(sizes.max(initial=0)) + 1) ** np.array([2, 1, 0])  # few are distinct
    for kind in np.unique(number):
        some = np.flatnonzero(number == kind)
        yield sizes[some[0]], some


def _mix(corners: Array, share: Array) -> Array:
    """Return trilinear interpolations of corner values (n, 8) at shares (p, 3), (n, p).

    Corners with zero weight are ignored, even if not finite.
    """
    weights = np.prod(np.where(CORNERS == 1, share[:, None, :], 1.0 - share[:, None, :]), axis=-1)
    finite = np.isfinite(corners).all(axis=1)
    mixed = np.empty((len(corners), len(share)))
    with np.errstate(invalid="ignore"):
        others = np.where(weights == 0.0, 0.0, weights * corners[~finite][:, None, :])
    mixed[~finite] = others.sum(axis=-1)
    if finite.all():
        _sum(corners, weights, mixed)
    else:
        sound = np.empty((int(finite.sum()), len(share)))
        _sum(corners[finite], weights, sound)
        mixed[finite] = sound
    return mixed


def _sum(corners: Array, weights: Array, out: Array) -> None:
    """Write the products of corners (n, 8) and weights (p, 8), summed in a fixed order, to (n, p)."""
    columns, rows, product = corners.T[:, :, None], np.ascontiguousarray(weights.T), np.empty_like(out)
    np.multiply(columns[0], rows[0], out=out)
    for column, row in zip(columns[1:], rows[1:], strict=True):
        np.multiply(column, row, out=product)
        out += product


def _nearest(share: Array) -> Cells:
    """Return the index of the nearest corner."""
    return np.asarray((share >= 0.5) @ np.array([4, 2, 1]), dtype=np.int64)
