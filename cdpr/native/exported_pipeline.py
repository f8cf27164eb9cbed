"""Exported pipeline: arrays, and the compiled operations on them, for FMUs and real-time controllers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.native.operations import operations

Array = NDArray[Any]

Kind = Literal["constant", "memory", "work"]

# Meanings of a status other than 0, numbered as in cdpr/calls.hpp.
IGNORED, ANSWER, FINITE, ESTIMATE = range(4)


@dataclass(frozen=True, eq=False)
class Stored:
    """Array of the pipeline.

    Attributes:
        name: name in the C++ code; "-" for none.
        kind: `memory` for a part of the state, `work` for scratch space.
        content: initial content, float64 or int64.
    """

    name: str
    kind: Kind
    content: Array


@dataclass(frozen=True)
class Link:
    """Numbers of an FMU's variable that are also in an array: an output is copied from it, others into it.

    Attributes:
        variable: name of the variable.
        first: index of the first number in it.
        size: number of numbers.
        array: index of the array.
        to: index of the first number in the array.
        positive: True if they must be greater than 0.
        per_step: True if they are multiplied by the control step.
    """

    variable: str
    first: int
    size: int
    array: int
    to: int
    positive: bool = False
    per_step: bool = False


@dataclass(frozen=True, eq=False)
class Call:
    """Compiled operation with its arguments, bound by `cdpr.native.bind` or `Foreign`.

    Attributes:
        bound: bound operation.
        vital: meaning of a status other than 0, one of the constants.
        skip: number of calls to skip then.
        repair: bound operation that is then called with the status; if it returns 0 the pipeline continues.
        entry: name of the operation in the pipeline; by default that in the kernel library.
    """

    bound: Any
    vital: int = IGNORED
    skip: int = 0
    repair: Any = None
    entry: str = ""

    @property
    def name(self) -> str:
        """Return the name of the operation."""
        return self.entry or operation_name(self.bound)


class Member(NamedTuple):
    """Member of an operation's struct: the address of an array's element, or a number.

    Attributes:
        array: index of the array; None for a number.
        value: index of the element, or the 64 bits of the number.
        is_number: True for a float64; False if unknown.
    """

    array: int | None
    value: int
    is_number: bool = False


@dataclass(frozen=True)
class Operation:
    """Operation of the pipeline.

    Attributes:
        name: name of the operation.
        in_order: True if it is called in each control step; others are repairs, or called by the surrounding code.
        vital: meaning of a status other than 0.
        skip: number of operations to skip then.
        repair: index of the operation that is then called; -1 for none.
        members: members of its struct.
    """

    name: str
    in_order: bool
    vital: int
    skip: int
    repair: int
    members: tuple[Member, ...]


@dataclass(eq=False)
class ExportedPipeline:
    """Arrays, and the operations on them.

    Attributes:
        arrays: arrays of the pipeline.
        links: variables of an FMU that are also in arrays.
        operations: those of a control step in order, the repairs, and those called by the surrounding code.
    """

    arrays: list[Stored] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)
    operations: list[Operation] = field(default_factory=list)

    @property
    def names(self) -> list[str]:
        """Return the names of the called operations."""
        return [operation.name for operation in self.operations]

    def add(self, name: str, content: Array, kind: Kind = "constant") -> int:
        """Add an array and return its index."""
        self.arrays.append(Stored(name, kind, content))
        return len(self.arrays) - 1

    def find(self, name: str) -> int | None:
        """Return the index of an array by its name."""
        return next((i for i, array in enumerate(self.arrays) if array.name == name), None)


def operation_name(bound: Any) -> str:
    """Return the name of a bound operation of the kernel library."""
    return next(name for name, known in operations().items() if known.address == bound.operation)


def address(array: Array) -> int:
    """Return the address of an array's first element."""
    return int(array.__array_interface__["data"][0])


def root(array: Array) -> Array:
    """Return the array that owns the memory of a view."""
    while isinstance(array.base, np.ndarray) and array.base.flags.c_contiguous and array.base.itemsize == 8:
        array = array.base
    return array


class Translation:
    """Translation of bound operations into a pipeline.

    Args:
        named: arrays that the surrounding code reads or writes, by name.
        shared: named arrays that replace every read-only array of the same content.
    """

    def __init__(self, named: dict[str, Array], shared: Sequence[str] = ()) -> None:
        self.pipeline = ExportedPipeline()
        self._places: dict[int, int] = {}  # by address of an array's memory: index of the stored array
        self._named = named
        self._shared = shared
        self._kept: list[Array] = []  # so that no other array gets their addresses

    def translate(self, calls: Sequence[Call], aside: Sequence[Call] = ()) -> ExportedPipeline:
        """Return the pipeline of these calls; its last operations, `aside`, are for the surrounding code."""
        every = [*calls, *(Call(call.repair) for call in calls if call.repair is not None), *aside]
        for name, array in self._named.items():
            self._store(name, array, "memory")
        roles: dict[int, set[str]] = {}
        found: dict[int, Array] = {}
        for call in every:
            for role, given in members(call):
                if given is not None:
                    owner = root(given)
                    roles.setdefault(address(owner), set()).add(role)
                    found.setdefault(address(owner), owner)
        for place, owner in found.items():
            if place not in self._places:
                self._store_by_roles(owner, roles[place])
        repairs = iter(range(len(calls), len(every)))
        for i, call in enumerate(every):
            repair = next(repairs) if call.repair is not None else -1
            self._call(call, i < len(calls), repair)
        return self.pipeline

    def where(self, array: Array) -> tuple[int, int]:
        """Return the index of the stored array that contains an array, and its position there."""
        owner = root(array)
        index = self._places[address(owner)]
        return index, (address(array) - address(owner)) // 8

    def _store(self, name: str, array: Array, kind: Kind) -> None:
        owner = root(array)
        self._kept.append(owner)
        self._places[address(owner)] = self.pipeline.add(name, owner, kind)

    def _store_by_roles(self, owner: Array, roles: set[str]) -> None:
        if roles == {"in"}:
            for name in self._shared:
                if owner.shape == self._named[name].shape and np.array_equal(owner, self._named[name]):
                    self._places[address(owner)] = self.pipeline.find(name) or 0
                    self._kept.append(owner)
                    return
        # An array that no operation reads is no state, and its initial content is rubbish.
        unread = roles <= {"work", "out"}
        self._store("-", owner, "constant" if roles == {"in"} else "work" if unread else "memory")

    def _call(self, call: Call, in_order: bool, repair: int) -> None:
        words = np.frombuffer(call.bound.words, dtype=np.int64)
        found = []
        for word, (role, array) in zip(words.tolist(), members(call), strict=True):
            if array is None:
                found.append(Member(None, word & (2**64 - 1), role == "number"))
            else:
                found.append(Member(*self.where(array)))
        self.pipeline.operations.append(Operation(call.name, in_order, call.vital, call.skip, repair, tuple(found)))


def members(call: Call) -> Iterable[tuple[str, Array | None]]:
    """Return role and array of each member of an operation's struct; for values "number" or "integer", and None."""
    bound = call.bound
    arrays = iter(bound.arrays)
    if not call.entry:
        for known in operations()[call.name].fields:
            kind = "number" if known.type == "double" else "integer"
            yield (known.role, next(arrays)) if known.is_array else (kind, None)
        return
    # The roles of an operation compiled elsewhere are unknown: any array may be its memory.
    ahead = next(arrays, None)
    for word in np.frombuffer(bound.words, dtype=np.int64).tolist():
        if ahead is not None and word == address(ahead):
            yield "both", ahead
            ahead = next(arrays, None)
        else:
            yield "integer", None
