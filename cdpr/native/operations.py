"""Operations of the kernel library for the instruction set in use."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from functools import cache, cached_property
from math import prod
from typing import Any

from cdpr.base.errors import CdprError

VARIABLE = "CDPR_NATIVE_TARGET"
FIELD = re.compile(r"[^,()]+(?:\([^()]*\))?")
LANES = 8  # numbers side by side; the last axis of arrays of lanes


class Dimension:
    """Length of an array along one axis: a sum of products of sizes and integers, or a size with a lower limit.

    Attributes:
        text: declaration, such as "2*m + 1" or "w >= 6".
        symbol: name of a size, such as "m"; None for an expression or an integer.
        symbols: names of the sizes in it.
        least: smallest length.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        sums, _, least = (part.strip() for part in text.partition(">="))
        self.least = int(least or 0)
        self.symbol = sums if sums.isidentifier() else None
        terms = [[factor.strip() for factor in term.split("*")] for term in sums.split("+")]
        self.symbols = frozenset(factor for term in terms for factor in term if not factor.isdigit())
        self._terms = [
            (prod(int(factor) for factor in term if factor.isdigit()), [each for each in term if not each.isdigit()])
            for term in terms
        ]
        self._length = None if self.symbols else self.evaluate({})

    def evaluate(self, sizes: Mapping[str, int]) -> int:
        """Return the length for given sizes."""
        if self.symbol is not None:
            return sizes[self.symbol]
        length = 0
        for product, symbols in self._terms:
            for symbol in symbols:
                product *= sizes[symbol]
            length += product
        return length

    def allows(self, length: int) -> bool:
        """Return whether an array may have this length for some sizes."""
        return length >= self.least and self._length in (None, length)


class Field:
    """Member of an operation's struct, as `field.hpp` describes it.

    Attributes:
        name: name of the argument.
        type: "double", "int64", "double*", "int64*" or "lanes*".
        role: "in", "out", "both", "work", "size" or "value".
        shape: dimensions of an array; the last one of lanes is 8.
        least: lower limit of a number; None if it has none.
        is_array: True if the struct holds an address.
    """

    def __init__(self, text: str, type: str) -> None:
        head, _, shape = text.rstrip(")").partition("(")
        head, _, least = head.partition(" >= ")
        *words, self.name = head.split()
        self.type = type.removeprefix("const ")
        self.is_array = type.endswith("*")
        self.role = words[0] if words else "value" if not self.is_array else "out" if type == self.type else "in"
        self.least = float(least) if least else None
        lanes = (str(LANES),) if self.type == "lanes*" else ()
        self.shape = tuple(Dimension(text) for text in (*shape.split(", "), *lanes)) if self.is_array else ()

    def __str__(self) -> str:
        """Return the shape, such as "(n, 3)"."""
        return shape_text(dimension.text for dimension in self.shape)


class Operation:
    """Compiled function `int f(void *place, double time)` and the struct of its arguments.

    Attributes:
        name: name of the operation.
        address: address of the function.
        plans: previous bindings, by names and shapes; for `cdpr.native.bind`.
    """

    def __init__(self, name: str, address: int, fields: str, types: tuple[str, ...]) -> None:
        self.name = name
        self.address = address
        self.plans: dict[object, Any] = {}
        self._described = fields, types

    # A process uses few of the operations, so each is parsed when it is first bound.

    @cached_property
    def fields(self) -> tuple[Field, ...]:
        """Members in the order of the struct."""
        text, types = self._described
        fields = tuple(Field(each, type) for each, type in zip(FIELD.findall(text), types, strict=True))
        sizes = {size for field in fields for each in field.shape for size in each.symbols}
        for field in fields:
            if field.name in sizes:
                field.role = "size"
        return fields

    @cached_property
    def sizes(self) -> frozenset[str]:
        """Names of sizes."""
        return frozenset(size for field in self.fields for each in field.shape for size in each.symbols)

    @cached_property
    def names(self) -> frozenset[str]:
        """Names of all arguments."""
        return frozenset(field.name for field in self.fields)

    @cached_property
    def required(self) -> frozenset[str]:
        """Names of the required arguments."""
        return frozenset(field.name for field in self.fields if field.role not in ("size", "work"))

    @cached_property
    def layout(self) -> str:
        """Format of the struct, for `struct.pack`."""
        return "=" + "".join("d" if field.type == "double" else "q" for field in self.fields)


def shape_text(shape: Iterable[object]) -> str:
    """Return a shape of numbers or symbols in the notation of Python."""
    lengths = [str(length) for length in shape]
    return f"({', '.join(lengths)}{',' if len(lengths) == 1 else ''})"


def targets() -> tuple[str, ...]:
    """Return the instruction sets of the library that this processor supports, the fastest last."""
    return tuple(_tables())


def target() -> str:
    """Return the instruction set in use: the fastest, or that of the environment variable CDPR_NATIVE_TARGET.

    Raises:
        CdprError: if the variable names none that this processor supports.
    """
    wanted = os.environ.get(VARIABLE)
    if wanted is None:
        return targets()[-1]
    if wanted not in targets():
        raise CdprError(f"{VARIABLE}: expected one of {', '.join(targets())}, got '{wanted}'; correct or unset it")
    return wanted


def operations() -> dict[str, Operation]:
    """Return the operations for the instruction set in use, by name."""
    return _tables()[target()]


def kernels_version() -> str:
    """Return the version of the kernel library: a digest of its sources."""
    from cdpr.native import library

    return library.sources[:16]


@cache
def _tables() -> dict[str, dict[str, Operation]]:
    from cdpr.native import library

    return {
        target: {name: Operation(name, address, fields, types) for name, address, fields, types in entries}
        for target, entries in library.tables()
    }
