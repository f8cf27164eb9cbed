"""Snapshots of the arrays that a plugin keeps its state in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

Saved = tuple[NDArray[Any], ...]


def save(arrays: Sequence[NDArray[Any]]) -> Saved:
    """Copy the arrays."""
    return tuple(array.copy() for array in arrays)


def put_back(saved: Saved, arrays: Sequence[NDArray[Any]]) -> None:
    """Write the copies that `save` made into the arrays."""
    for copy, array in zip(saved, arrays, strict=True):
        array[:] = copy


class SnapshotOfArrays:
    """For a plugin whose future depends on its `arrays` alone; () where it has no memory."""

    arrays: tuple[NDArray[Any], ...]

    def snapshot(self) -> object:
        """Return a copy of everything."""
        return save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot."""
        put_back(snapshot, self.arrays)
