"""How many pieces the inside of a workspace is in, its cells told one after the other: a layer is remembered."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr.model.jit import kernel

Whole = NDArray[np.int64]

USED, PIECES = 0, 1  # places in the state: labels that are given, pieces so far


class Connected:
    """Counts pieces: cells that share a face are of the same one.

    Union and find over labels, of which those alone are kept that the last layer has (Hoshen and Kopelman, Phys. Rev. B
    14, 1976): five whole numbers for each of its cells, however many layers there are.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        """Begin with no cell of a table of this shape, (nx, ny, nz)."""
        self.rows, self.columns = layer(shape)
        size = self.rows * self.columns
        self._above = np.full(size, -1, dtype=np.int64)
        self._parent, self._fresh = np.empty(2 * size, dtype=np.int64), np.empty(2 * size, dtype=np.int64)
        self._state = np.zeros(2, dtype=np.int64)
        self._told = 0

    def add(self, inside: NDArray[np.bool_]) -> None:
        """Tell whether the next cells are inside, (n,), the last axis fastest."""
        cells = inside.astype(np.int64)
        follow(cells, self._told, self.rows, self.columns, self._above, self._parent, self._fresh, self._state)
        self._told += len(cells)

    @property
    def pieces(self) -> int:
        """How many there are, of the cells so far."""
        return int(self._state[PIECES])


def layer(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the cells along both sides of a layer across the first axis that has several."""
    sides = [n for n in shape if n > 1][1:]
    return (1, 1, *sides)[-2], (1, 1, *sides)[-1]


@kernel
def root(parent: Whole, label: int) -> int:
    """Return by which label a piece goes that has this one, and shorten the way there."""
    while parent[label] != label:
        parent[label] = parent[parent[label]]
        label = parent[label]
    return label


@kernel
def renumber(above: Whole, parent: Whole, fresh: Whole, used: int) -> int:
    """Give the labels of a layer numbers from 0 on, forget all others, and return how many there are."""
    for k in range(used):
        fresh[k] = -1
    count = 0
    for r in range(above.shape[0]):
        if above[r] >= 0:
            label = root(parent, above[r])
            if fresh[label] < 0:
                fresh[label] = count
                count += 1
            above[r] = fresh[label]
    for k in range(count):
        parent[k] = k
    return count


@kernel
def follow(
    inside: Whole, first: int, rows: int, columns: int, above: Whole, parent: Whole, fresh: Whole, state: Whole
) -> None:
    """Go on with cells from number `first` on; `above` (rows * columns) has the last label in each place."""
    used, pieces = state[USED], state[PIECES]
    size = rows * columns
    for k in range(inside.shape[0]):
        r = (first + k) % size
        if r == 0:
            used = renumber(above, parent, fresh, used)
        mine = -1
        if inside[k] != 0:
            for side in range(3):
                other = -1
                if side == 0:
                    other = above[r]
                elif side == 1 and r >= columns:
                    other = above[r - columns]
                elif side == 2 and r % columns > 0:
                    other = above[r - 1]
                if other >= 0:
                    other = root(parent, other)
                    if mine >= 0 and other != mine:
                        parent[max(mine, other)] = min(mine, other)
                        pieces -= 1
                        other = min(mine, other)
                    mine = other
            if mine < 0:
                mine = used
                parent[mine] = mine
                used += 1
                pieces += 1
        above[r] = mine
    state[USED], state[PIECES] = used, pieces
