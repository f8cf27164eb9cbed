"""Adaptive evaluation of a region's cells; the others are interpolated.

A box of cells is interpolated from its corners if they are all inside or all outside, and farther from the edge than a
share of their spread. Any other box is divided into eight. Of the new corners, only the corners that may lie on the
other side are evaluated. The interpolation error there is estimated from the error of the parent box, at half the
distance. Features thinner than the initial boxes that no corner touches are missed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace.regions import Region
from cdpr.model.robot import Array
from cdpr.native.bind import bind

Cells = NDArray[np.int64]
Flags = NDArray[np.bool_]

START = 16  # minimum number of initial boxes along the longest side
NEAR = 0.25  # minimum distance of a box's corners from the edge, as a share of their spread
# Estimated ratio of successive interpolation errors: a quarter for smooth values, half for values with kinks, more if
# the last box revealed less of its error. On CoGiRo, Caroca and IPAnema 1 with 160^3 cells, 1 in 4000 inside cells is
# wrong and a 60th is evaluated; with 0.5, 1 in 800; with 1.0, 1 in 10 000 and a quarter more evaluations.
ERROR = 0.75

UNKNOWN, OUTSIDE, INSIDE = -1, 0, 1  # sides of the edge, as in octree.hpp

CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
AXES = np.arange(3)


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
        self._value, self._limit = np.full(cells, np.nan), np.full(cells, -1, dtype=np.int64)
        self._side = np.full(cells, UNKNOWN)  # INSIDE or OUTSIDE once evaluated or interpolated
        self._strides = np.array([self._shape[1] * self._shape[2], self._shape[2], 1])
        self._table = {
            "strides": self._strides,
            "value": self._value,
            "limit": self._limit,
            "side": self._side,
            "edge": edge,
        }
        self._evaluated, self._boundary = np.zeros(cells, dtype=bool), np.zeros(cells, dtype=bool)

    def found(self) -> tuple[CellResults, Flags]:
        boxes, error = self._first()
        while len(boxes):
            left = self._settle(boxes)
            boxes, error = self._divide(boxes[left], error[left])
            self._progress(int(np.count_nonzero(self._side != UNKNOWN)), len(self._side))
        return CellResults(self._value, self._limit, self._side == INSIDE, self._boundary), self._evaluated

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
            self._value[new], self._limit[new], self._side[new], self._boundary[new] = self._evaluate(new)
            self._evaluated[new] = True

    def _settle(self, boxes: Cells) -> Flags:
        """Interpolate boxes whose corners determine the cells in between; return True for the others, (n,)."""
        need = self._reach(boxes) / 2.0  # each cell is closer to a corner than half a diagonal
        settled = np.empty(len(boxes), dtype=np.int64)
        bind("settle_boxes", **self._table, boxes=boxes, need=need, near=NEAR, settled=settled)()
        return np.asarray(settled == 0)

    def _reach(self, boxes: Cells) -> Array:
        """Return the largest change of the value along the diagonals of boxes, (n,); 0 if unknown."""
        slope = self._slope or 0.0
        return np.asarray(slope * np.linalg.norm((boxes[:, :, 1] - boxes[:, :, 0]) * self._spacing, axis=1))

    def _divide(self, boxes: Cells, error: Array) -> tuple[Cells, Array]:
        """Divide boxes into up to eight with known corners; return those with other cells, and their errors.

        The error is the interpolation error observed in the parent box.
        """
        longest = (boxes[:, :, 1] - boxes[:, :, 0]).max(axis=1)
        boxes, error, longest = boxes[longest > 1], error[longest > 1], longest[longest > 1]
        need = ERROR * error
        if self._slope is not None:
            need = np.maximum(need, self._reach(boxes))  # an interpolated value is a mean of the corners
            need[longest > 2] = np.inf  # interpolated values must not become corners of other boxes
        n, count = len(boxes), np.empty(1, dtype=np.int64)
        values, doubtful = np.empty((n, 27)), np.empty(27 * n, dtype=np.int64)
        bind("box_points", **self._table, boxes=boxes, need=need, values=values, doubtful=doubtful, count=count)()
        self._answer(doubtful[: count[0]])
        parts, errors = np.empty((8 * n, 3, 2), dtype=np.int64), np.empty(8 * n)
        bind("divide_boxes", **self._table, boxes=boxes, values=values, parts=parts, error=errors, count=count)()
        return parts[: count[0]], errors[: count[0]]


def _corners(boxes: Cells) -> Cells:
    """Return the corner cells, (n, 8, 3), of boxes (n, 3, 2)."""
    return boxes[:, AXES, CORNERS]
