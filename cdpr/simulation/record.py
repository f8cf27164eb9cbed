"""Record of external commands, written by compiled code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array
from cdpr.scenario.events.commands import Kind

BLOCK = 1024  # commands recorded in one table


class Block(NamedTuple):
    """Commands of one kind, and the block before.

    Attributes:
        rows: (k, 2 + n) first sample, number of steps, and values.
    """

    kind: Kind
    rows: Array
    before: Block | None


class Record:
    """Commands of all kinds, in blocks that are shared with snapshots."""

    def __init__(self) -> None:
        self._tables: dict[Kind, tuple[Array, NDArray[np.int64]]] = {}
        self._block: Block | None = None

    def table(self, kind: Kind, n: int) -> tuple[Array, NDArray[np.int64]]:
        """Return the live table (rows, 2 + n) for commands of n values, and the number of used rows, (1,)."""
        if kind not in self._tables:
            self._tables[kind] = np.empty((BLOCK, 2 + n)), np.zeros(1, dtype=np.int64)
        return self._tables[kind]

    def complete(self) -> Block | None:
        """Empty the tables; return the last block."""
        for kind, (rows, used) in self._tables.items():
            if used[0]:
                self._block = Block(kind, rows[: used[0]].copy(), self._block)
                used[0] = 0
        return self._block

    def restore(self, block: Block | None) -> None:
        """Discard the commands after a block."""
        self._block = block
        for _, used in self._tables.values():
            used[0] = 0
