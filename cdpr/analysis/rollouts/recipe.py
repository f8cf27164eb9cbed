"""Memory layout of a case's operations: arrays that are stored side by side with those of other cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cdpr.model.robot import Array
from cdpr.native.bind import Compiled
from cdpr.native.library import Bound
from cdpr.native.operations import operations


class UnfitError(Exception):
    """Cases that cannot share a block."""


class View(NamedTuple):
    """View of an array: its root, the first number in it, and the shape."""

    root: int
    first: int
    shape: tuple[int, ...]


class Root(NamedTuple):
    """Whole array, with views on it."""

    size: int
    word: int  # word of a case with its address
    offset: int  # offset of the root from that address, in bytes


def whole(array: Array) -> Array:
    """Return the array that owns the memory of this one."""
    while isinstance(array.base, np.ndarray):
        array = array.base
    return array


class Recipe:
    """Meaning of a case's words: addresses of the arrays that steps change, then the structs of its operations.

    A word is 8 bytes: an address, a size, or a number, as in the struct of an operation.

    Attributes:
        roots: arrays, each once.
        again: further words with the address of a root: word, root, offset in bytes.
        fixed: words that are equal in all cases of a block.
        shared: arrays with equal content in all cases: the operation, and the name of the argument.
        given: other arrays, likewise.
        moved: roots that steps change, which therefore move between the lanes and the case's own arrays.
    """

    def __init__(self, memory: Sequence[Array]) -> None:
        self.roots: list[Root] = []
        self.again: list[tuple[int, int, int]] = []
        self.fixed: list[int] = []
        self.shared: list[tuple[int, str]] = []
        self.given: list[tuple[int, str]] = []
        self._word = 0
        self._known: dict[int, int] = {}
        self._held: list[Array] = []  # while these exist no other array has their id
        for array in memory:
            self.view(array)
            self._word += 1
        if [root.size for root in self.roots] != [array.size for array in memory]:
            raise UnfitError  # some are parts of others
        self.moved = list(range(len(memory)))

    def read(self, at: int, call: Bound) -> dict[str, Any]:
        """Return the arguments of the operation at this index for its vector form, with views in place of arrays."""
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
        """Record the roots that an operation writes, in either form; for one compiled elsewhere, all its roots."""
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
        """Return the view for an array, with the address in the next word.

        Raises:
            UnfitError: if the array is not C-contiguous.
        """
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
        """Return the number of a root, None for another array."""
        return self._known.get(id(array))

    @property
    def words(self) -> list[int]:
        """Return the index of the word with the address of each root."""
        return [root.word for root in self.roots]

    @property
    def offsets(self) -> list[int]:
        """Return the offset of each root from that address, in bytes."""
        return [root.offset for root in self.roots]
