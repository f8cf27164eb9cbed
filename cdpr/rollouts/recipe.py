"""What the arguments of a case's acts are made of: arrays that stand side by side with those of other cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cdpr.model.robot import Array


class UnfitError(Exception):
    """Cases that cannot go side by side."""


class View(NamedTuple):
    """An array: which of the roots it is a part of, from which number on, and its shape."""

    root: int
    first: int
    shape: tuple[int, ...]


class Root(NamedTuple):
    """A whole array, of which others are views."""

    size: int
    word: int  # which of a case's words tells where it is
    offset: int  # by how many bytes that is further


class Recipe:
    """Which words of a case say what: those of arrays that steps change, then those of its acts, one after the other.

    A word is 8 bytes: an address, a size, or a number, as in `Bound.words`.

    Attributes:
        roots: the arrays, each once.
        again: words that tell of a root once more: word, root, bytes by which it is further.
        fixed: words that are the same in all cases that go side by side.
        indices: arrays of whole numbers, likewise: which act's, and which argument.
    """

    def __init__(self, memory: Sequence[Array]) -> None:
        self.roots: list[Root] = []
        self.again: list[tuple[int, int, int]] = []
        self.fixed: list[int] = []
        self.indices: list[tuple[int, int]] = []
        self._word = 0
        self._known: dict[int, int] = {}
        self._held: list[Array] = []  # as long as they are here no other array has their id
        for array in memory:
            self.view(array)
            self._word += 1
        if [root.size for root in self.roots] != [array.size for array in memory]:
            raise UnfitError  # some are parts of others

    def read(self, at: int, arguments: Sequence[Any], used: int | None = None) -> list[Any]:
        """Take the arguments of the act at this place; return them with views in place of arrays of numbers.

        Of those beyond so many that are `used` nothing is said, and nothing returned.
        """
        self._same(1)  # the kernel's address
        found = [self._one(at, i, value) for i, value in enumerate(arguments[:used])]
        if used is not None:
            self._word += sum(1 + getattr(value, "ndim", 0) for value in arguments[used:])
        return found

    def view(self, array: Array) -> View:
        """Return what an array is, of which the next word tells; raises UnfitError if not laid out in C's order."""
        root = array
        while isinstance(root.base, np.ndarray):
            root = root.base
        if not (root.flags.c_contiguous and root.flags.aligned and root.dtype == np.float64):
            raise UnfitError
        offset = array.ctypes.data - root.ctypes.data
        known = self._known.get(id(root))
        if known is None:
            known = self._known[id(root)] = len(self.roots)
            self._held.append(root)
            self.roots.append(Root(root.size, self._word, offset))
        else:
            self.again.append((self._word, known, offset))
        return View(known, offset // array.itemsize, array.shape)

    def _one(self, at: int, i: int, value: Any) -> Any:
        if isinstance(value, tuple):
            parts = [self._one(at, i, each) for each in value]
            return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
        if not isinstance(value, np.ndarray):
            self._same(1)
            return value
        view = None
        if value.dtype == np.float64:
            view = self.view(value)
        else:
            self.indices.append((at, i))
        self._word += 1
        self._same(value.ndim)
        return value if view is None else view

    def _same(self, count: int) -> None:
        self.fixed += range(self._word, self._word + count)
        self._word += count
