"""Garbage values for a solver's memory: a call must not read what it has not written."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.plugins import CompiledSolver, TensionSolver

# NaN propagates, and comparisons with it are false; with a huge number they are true; zeros are the content of new
# memory and hide missing writes.
POISON = (np.nan, 1e30, 0.0)


class Memory:
    """Arrays of a solver that calls write: the work space of a compiled solver, changed arrays of others.

    Arrays that a solver only reads, and entries that no call has changed so far, are not included.
    """

    def __init__(self, solver: TensionSolver) -> None:
        self._solver = solver
        self._before = [(array, array.copy()) for array in self._arrays()]

    def fill(self, value: float) -> None:
        """Fill everything that calls have changed since this object was created."""
        if isinstance(self._solver, CompiledSolver):
            for array in self._solver.work:
                array[...] = value
            return
        for array, before in self._before:
            changed = array.view(np.uint8) != before.view(np.uint8) if array.size else np.zeros(0, bool)
            array[changed.reshape(*array.shape, -1).any(axis=-1)] = value

    def _arrays(self) -> list[NDArray[np.float64]]:
        """Return the arrays that are attributes of the solver, or elements of its lists and tuples."""
        found: dict[int, NDArray[np.float64]] = {}

        def visit(value: Any, depth: int) -> None:
            if isinstance(value, np.ndarray):
                if value.dtype == np.float64 and value.flags.writeable and value.flags.c_contiguous and value.ndim:
                    found[id(value)] = value
            elif isinstance(value, (list, tuple)) and depth:
                for each in value:
                    visit(each, depth - 1)

        for value in vars(self._solver).values():
            visit(value, 1)
        return list(found.values())
