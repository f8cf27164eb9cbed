"""Snapshots of plugins with their state in arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

Saved = tuple[NDArray[Any], ...]


def save(arrays: Sequence[NDArray[Any]]) -> Saved:
    """Return copies of the arrays."""
    return tuple(array.copy() for array in arrays)


def put_back(saved: Saved, arrays: Sequence[NDArray[Any]]) -> None:
    """Write the copies of `save` back into the arrays."""
    for copy, array in zip(saved, arrays, strict=True):
        array[:] = copy


class SnapshotOfArrays:
    """Mixin for plugins whose state is in their `arrays`; () without state.

    Example:
        >>> import numpy as np
        >>> from cdpr.plugins import SnapshotOfArrays
        >>> class Integral(SnapshotOfArrays):
        ...     def __init__(self):
        ...         self.total = np.zeros(3)
        ...         self.arrays = (self.total,)
        >>> part = Integral()
        >>> saved = part.snapshot()
        >>> part.total += 1.0
        >>> part.restore(saved)
        >>> part.total
        array([0., 0., 0.])
    """

    arrays: tuple[NDArray[Any], ...]

    def snapshot(self) -> object:
        """Return a copy of all arrays."""
        return save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot.

        Args:
            snapshot: result of `snapshot` of the same object.
        """
        put_back(snapshot, self.arrays)
