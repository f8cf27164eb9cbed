"""Exported program: arrays, and the compiled operations that work on them, for FMUs and real-time controllers."""

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
IGNORED, ANSWER, FINITE = range(3)


@dataclass(frozen=True, eq=False)
class Stored:
    """An array of the program.

    Attributes:
        name: By which its code finds it; "-" for none.
        kind: `memory` is part of the state, `work` scratch space.
        content: At the start, float64 or int64.
    """

    name: str
    kind: Kind
    content: Array


@dataclass(frozen=True)
class Link:
    """Numbers of an FMU's variable that are also in an array.

    Attributes:
        variable: Its name.
        first: Index of the first number in it.
        size: How many.
        array: Index of the array.
        to: Where they go in it.
        positive: Whether they must be greater than 0.
        per_step: Whether they are multiplied by the control step.
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
    """A compiled operation with its arguments, as `cdpr.native.bind` or `Foreign` bound it.

    Attributes:
        bound: The bound operation.
        vital: What a status other than 0 means, one of the constants.
        skip: How many of the calls that follow are skipped then.
        repair: Bound operation that is called then with the status; if it returns 0 the program continues.
        entry: Name of the operation in the program; that in the kernel library unless given.
    """

    bound: Any
    vital: int = IGNORED
    skip: int = 0
    repair: Any = None
    entry: str = ""

    @property
    def name(self) -> str:
        """Name of the operation."""
        return self.entry or operation_name(self.bound)


class Member(NamedTuple):
    """A member of an operation's struct: the address of an array's element, or a number.

    Attributes:
        array: Index of the array; None for a number.
        value: Index of the element, or the 64 bits of the number.
        is_number: Whether it is a float64; False if unknown.
    """

    array: int | None
    value: int
    is_number: bool = False


@dataclass(frozen=True)
class Operation:
    """A call of the program.

    Attributes:
        name: Of the operation.
        in_order: Whether it is called in each control step; others only repair, or are called by the code around.
        vital: Meaning of a status other than 0.
        skip: Number of operations skipped then.
        repair: Index of the operation that is called then; -1 for none.
        members: Of its struct.
    """

    name: str
    in_order: bool
    vital: int
    skip: int
    repair: int
    members: tuple[Member, ...]


@dataclass(eq=False)
class Program:
    """Arrays, and the operations that work on them.

    Attributes:
        arrays: The arrays.
        links: Variables of an FMU that are also in arrays.
        operations: The calls: those of a control step in order, those that only repair, those of the code around.
    """

    arrays: list[Stored] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)
    operations: list[Operation] = field(default_factory=list)

    @property
    def names(self) -> list[str]:
        """Names of the operations that are called."""
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
    """Translation of bound operations into a program.

    Args:
        named: Arrays that the code around the program reads or writes, by name.
        shared: Of these, arrays that stand for every array of the same content that is only read.
    """

    def __init__(self, named: dict[str, Array], shared: Sequence[str] = ()) -> None:
        self.program = Program()
        self._places: dict[int, int] = {}  # of an array's memory: index of the stored array
        self._named = named
        self._shared = shared
        self._kept: list[Array] = []  # so that no other array gets their addresses

    def translate(self, calls: Sequence[Call], aside: Sequence[Call] = ()) -> Program:
        """Return the program that makes these calls; its last operations, `aside`, it leaves to the code around."""
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
        return self.program

    def where(self, array: Array) -> tuple[int, int]:
        """Return the index of the stored array that holds an array, and its place there."""
        owner = root(array)
        index = self._places[address(owner)]
        return index, (address(array) - address(owner)) // 8

    def _store(self, name: str, array: Array, kind: Kind) -> None:
        owner = root(array)
        self._kept.append(owner)
        self._places[address(owner)] = self.program.add(name, owner, kind)

    def _store_by_roles(self, owner: Array, roles: set[str]) -> None:
        if roles == {"in"}:
            for name in self._shared:
                if owner.shape == self._named[name].shape and np.array_equal(owner, self._named[name]):
                    self._places[address(owner)] = self.program.find(name) or 0
                    self._kept.append(owner)
                    return
        # What no operation reads is no state, and its content at the start is rubbish.
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
        self.program.operations.append(Operation(call.name, in_order, call.vital, call.skip, repair, tuple(found)))


def members(call: Call) -> Iterable[tuple[str, Array | None]]:
    """Return role and array of each member of an operation's struct; of values "number" or "integer", and None."""
    bound = call.bound
    arrays = iter(bound.arrays)
    if not call.entry:
        for known in operations()[call.name].fields:
            kind = "number" if known.type == "double" else "integer"
            yield (known.role, next(arrays)) if known.is_array else (kind, None)
        return
    # Of an operation that was compiled elsewhere no roles are known: any array may be its memory.
    ahead = next(arrays, None)
    for word in np.frombuffer(bound.words, dtype=np.int64).tolist():
        if ahead is not None and word == address(ahead):
            yield "both", ahead
            ahead = next(arrays, None)
        else:
            yield "integer", None
