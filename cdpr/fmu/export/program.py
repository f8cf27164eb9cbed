"""Arrays and compiled operations of an exported FMU, and the variables that go into the arrays."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from cdpr.model.robot import Array
from cdpr.native.operations import operations

Kind = Literal["constant", "memory", "work"]

# Meanings of a status other than 0, numbered as in source/model.h.
IGNORED, ANSWER, FINITE = range(3)


@dataclass(frozen=True, eq=False)
class Stored:
    """An array of the FMU.

    Attributes:
        name: By which its code finds it; "-" for none.
        kind: `memory` is part of the FMU's state, `work` scratch space.
        content: At the start, float64 or int64.
    """

    name: str
    kind: Kind
    content: Array


@dataclass(frozen=True)
class Link:
    """Numbers of a variable that are also in an array.

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
        repair: Bound operation that is called then with the status; if it returns 0 the FMU goes on.
        entry: Name of the operation in the FMU; that in the kernel library unless given.
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


@dataclass(eq=False)
class Program:
    """Contents of an FMU beside its variables.

    Attributes:
        arrays, links: As said there.
        lines: Of the operations, as source/config.cpp reads them.
        names: The operations that these call.
    """

    arrays: list[Stored] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    names: list[str] = field(default_factory=list)

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
    """Translates calls into those of an FMU.

    Args:
        named: Arrays that the FMU's code reads or writes, by name.
        shared: Of these, arrays that stand for every array of the same content that is only read.
    """

    def __init__(self, named: dict[str, Array], shared: Sequence[str] = ()) -> None:
        self.program = Program()
        self._places: dict[int, int] = {}  # of an array's memory: index of the stored array
        self._named = named
        self._shared = shared
        self._kept: list[Array] = []  # so that no other array gets their addresses

    def translate(self, calls: Sequence[Call]) -> Program:
        """Return the program that makes these calls."""
        every = [*calls, *(Call(call.repair) for call in calls if call.repair is not None)]
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
        self._store("-", owner, "constant" if roles == {"in"} else "work" if roles == {"work"} else "memory")

    def _call(self, call: Call, in_order: bool, repair: int) -> None:
        words = np.frombuffer(call.bound.words, dtype=np.int64)
        texts = []
        for word, (_, array) in zip(words.tolist(), members(call), strict=True):
            if array is None:
                texts.append(f"value {word & (2**64 - 1):016x}")
            else:
                texts.append("array {} {}".format(*self.where(array)))
        head = f"{call.name} {int(in_order)} {call.vital} {call.skip} {repair} {len(texts)}"
        self.program.lines.append(" ".join([head, *texts]))
        self.program.names.append(call.name)


def members(call: Call) -> Iterable[tuple[str, Array | None]]:
    """Return role and array of each member of an operation's struct; None for numbers."""
    bound = call.bound
    arrays = iter(bound.arrays)
    if not call.entry:
        for known in operations()[call.name].fields:
            yield (known.role, next(arrays)) if known.is_array else ("value", None)
        return
    # Of an operation that was compiled elsewhere no roles are known: any array may be its memory.
    ahead = next(arrays, None)
    for word in np.frombuffer(bound.words, dtype=np.int64).tolist():
        if ahead is not None and word == address(ahead):
            yield "both", ahead
            ahead = next(arrays, None)
        else:
            yield "value", None


def words_of(content: Array) -> list[str]:
    """Return the numbers of an array as config.cpp reads them."""
    if content.dtype == np.int64:
        return [f"{value:016x}" for value in np.ravel(content).view(np.uint64).tolist()]
    return [number(value) for value in np.ravel(content).tolist()]


def number(value: float) -> str:
    """Return the bits of a number as hexadecimal digits."""
    return f"{struct.unpack('>Q', struct.pack('>d', value))[0]:016x}"
