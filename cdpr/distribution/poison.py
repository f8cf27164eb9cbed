"""Rubbish in a solver's memory: what a call has not written itself, it must not read."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.plugins import CompiledSolver, TensionSolver

# NaN shows in whatever is computed from it, comparisons with it are false; with a huge number they are true; and zeros
# are what a new work space holds, and what hides that nothing was written.
POISON = (np.nan, 1e30, 0.0)


class Memory:
    """The arrays of a solver that calls write: of a compiled one its work space, of others what calls have changed.

    Arrays that a solver only reads are its own, as are those entries of an array that no call has changed so far.
    """

    def __init__(self, solver: TensionSolver) -> None:
        self._solver = solver
        self._before = [(array, array.copy()) for array in self._arrays()]

    def fill(self, value: float) -> None:
        """Fill all that calls have changed since the memory was looked at first."""
        if isinstance(self._solver, CompiledSolver):
            for array in self._solver.work:
                array[...] = value
            return
        for array, before in self._before:
            changed = array.view(np.uint8) != before.view(np.uint8) if array.size else np.zeros(0, bool)
            array[changed.reshape(*array.shape, -1).any(axis=-1)] = value

    def _arrays(self) -> list[NDArray[np.float64]]:
        """The arrays that are attributes of the solver, or stand in lists and tuples that are."""
        found: dict[int, NDArray[np.float64]] = {}

        def look(value: Any, depth: int) -> None:
            if isinstance(value, np.ndarray):
                if value.dtype == np.float64 and value.flags.writeable and value.flags.c_contiguous and value.ndim:
                    found[id(value)] = value
            elif isinstance(value, (list, tuple)) and depth:
                for each in value:
                    look(each, depth - 1)

        for value in vars(self._solver).values():
            look(value, 1)
        return list(found.values())
