"""Snapshots of the arrays that a backend keeps its plant in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cdpr.model.robot import Array

Saved = tuple[Array, ...]


def save(arrays: Sequence[Array]) -> Saved:
    """Copy the arrays."""
    return tuple(array.copy() for array in arrays)


def put_back(saved: Saved, arrays: Sequence[Array]) -> None:
    """Write the copies that `save` made into the arrays."""
    for copy, array in zip(saved, arrays, strict=True):
        array[:] = copy


class SnapshotOfArrays:
    """For a backend whose future depends on its `arrays` alone."""

    arrays: tuple[Array, ...]

    def snapshot(self) -> object:
        """Return a copy of everything."""
        return save(self.arrays)

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot."""
        put_back(snapshot, self.arrays)
