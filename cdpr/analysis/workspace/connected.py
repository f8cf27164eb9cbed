"""Number of connected parts of the inside of a workspace, from cells in order, with one layer in memory."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr.native.bind import bind

PIECES = 1  # index in the state, after the number of labels in use


class Connected:
    """Counter of connected parts; cells with a common face belong to the same part.

    Union-find over the labels of the last layer only (Hoshen and Kopelman, Phys. Rev. B 14, 1976): five integers per
    cell of a layer, for any number of layers.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        """Start with no cell of a table of this shape, (nx, ny, nz)."""
        self.rows, self.columns = layer(shape)
        size = self.rows * self.columns
        self._above, self._parent = np.full(size, -1, dtype=np.int64), np.empty(2 * size, dtype=np.int64)
        self._state = np.zeros(2, dtype=np.int64)
        self._reported = 0

    def add(self, inside: NDArray[np.bool_]) -> None:
        """Add the next cells, (n,), True if inside, the last axis fastest."""
        cells = inside.astype(np.int64)
        bind(
            "connected_cells",
            inside=cells,
            above=self._above,
            parent=self._parent,
            state=self._state,
            first=self._reported,
            columns=self.columns,
        )()
        self._reported += len(cells)

    @property
    def pieces(self) -> int:
        """Number of parts of the cells so far."""
        return int(self._state[PIECES])


def layer(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the numbers of cells along both sides of a layer across the first axis that has several."""
    sides = [n for n in shape if n > 1][1:]
    return (1, 1, *sides)[-2], (1, 1, *sides)[-1]
