"""Number of pieces that the cells inside a workspace form, cells in order: only the last layer is kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr.native.bind import bind

PIECES = 1  # place in the state, after the number of labels in use


class Connected:
    """Counts pieces: cells that share a face are of the same one.

    Union and find over labels, of which those alone are kept that the last layer has (Hoshen and Kopelman, Phys. Rev. B
    14, 1976): five whole numbers for each of its cells, however many layers there are.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        """Begin with no cell of a table of this shape, (nx, ny, nz)."""
        self.rows, self.columns = layer(shape)
        size = self.rows * self.columns
        self._above, self._parent = np.full(size, -1, dtype=np.int64), np.empty(2 * size, dtype=np.int64)
        self._state = np.zeros(2, dtype=np.int64)
        self._told = 0

    def add(self, inside: NDArray[np.bool_]) -> None:
        """Tell whether the next cells are inside, (n,), the last axis fastest."""
        cells = inside.astype(np.int64)
        bind(
            "connected_cells",
            inside=cells,
            above=self._above,
            parent=self._parent,
            state=self._state,
            first=self._told,
            columns=self.columns,
        )()
        self._told += len(cells)

    @property
    def pieces(self) -> int:
        """How many there are, of the cells so far."""
        return int(self._state[PIECES])


def layer(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the cells along both sides of a layer across the first axis that has several."""
    sides = [n for n in shape if n > 1][1:]
    return (1, 1, *sides)[-2], (1, 1, *sides)[-1]
