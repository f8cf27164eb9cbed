"""What the arguments of a case's acts are made of: arrays that stand side by side with those of other cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cdpr.model.robot import Array
from cdpr.native.bind import Compiled
from cdpr.native.library import Bound
from cdpr.native.operations import operations


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


def whole(array: Array) -> Array:
    """Return the array of which this one is a part."""
    while isinstance(array.base, np.ndarray):
        array = array.base
    return array


class Recipe:
    """Which words of a case say what: those of arrays that steps change, then those of its acts, one after the other.

    A word is 8 bytes: an address, a size, or a number, as in the struct of an operation.

    Attributes:
        roots: the arrays, each once.
        again: words that tell of a root once more: word, root, bytes by which it is further.
        fixed: words that are the same in all cases that go side by side.
        shared: arrays whose content is the same in all cases: the act, and the name of the argument.
        given: the other arrays, likewise.
        moved: roots that steps change, in lanes or of a case alone, which therefore go from the one to the other.
    """

    def __init__(self, memory: Sequence[Array]) -> None:
        self.roots: list[Root] = []
        self.again: list[tuple[int, int, int]] = []
        self.fixed: list[int] = []
        self.shared: list[tuple[int, str]] = []
        self.given: list[tuple[int, str]] = []
        self._word = 0
        self._known: dict[int, int] = {}
        self._held: list[Array] = []  # as long as they are here no other array has their id
        for array in memory:
            self.view(array)
            self._word += 1
        if [root.size for root in self.roots] != [array.size for array in memory]:
            raise UnfitError  # some are parts of others
        self.moved = list(range(len(memory)))

    def read(self, at: int, call: Bound) -> dict[str, Any]:
        """Return the arguments of the act at this place for the operation in lanes, with views in place of arrays."""
        own, lanes = operations()[call.name], operations()[f"{call.name}_lanes"]
        types = {field.name: field.type for field in lanes.fields}
        found: dict[str, Any] = {}
        for field in own.fields:
            value = call.given.get(field.name)
            if not field.is_array:
                self.fixed.append(self._word)
                if value is not None:
                    found[field.name] = value
            elif value is not None and field.role != "work":
                if types[field.name] == "lanes*":
                    self.given.append((at, field.name))
                    found[field.name] = self.view(value)
                else:
                    self.shared.append((at, field.name))
                    found[field.name] = value
            self._word += 1
        return found

    def note(self, call: Compiled | None) -> None:
        """Note which roots an operation writes, whichever way it is run; all that one compiled elsewhere has."""
        if isinstance(call, Bound):
            fields = operations()[call.name].fields
            arrays = [call.given.get(field.name) for field in fields if field.is_array and field.role != "in"]
        else:
            arrays = list(getattr(call, "arrays", ()))
        for array in arrays:
            root = None if array is None else self._known.get(id(whole(array)))
            if root is not None and root not in self.moved:
                self.moved.append(root)

    def view(self, array: Array) -> View:
        """Return what an array is, of which the next word tells; raises UnfitError if not laid out in C's order."""
        root = whole(array)
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

    def known(self, array: Array) -> int | None:
        """Return the number of a root, None of another array."""
        return self._known.get(id(array))

    @property
    def words(self) -> list[int]:
        """Index of the word with the address of each root."""
        return [root.word for root in self.roots]

    @property
    def offsets(self) -> list[int]:
        """By how many bytes that is further."""
        return [root.offset for root in self.roots]
