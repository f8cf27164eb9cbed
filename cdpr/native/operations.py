"""Operations of the kernel library for the instruction set in use."""

from __future__ import annotations

import os
from collections.abc import Iterable
from functools import cache
from typing import Any

from cdpr.errors import CdprError
from cdpr.native.sizes import Dimension

VARIABLE = "CDPR_NATIVE_TARGET"
LANES = 8  # numbers side by side; the last axis of arrays of lanes


class Field:
    """Member of an operation's struct, as `table.h` describes it.

    Attributes:
        name: Of the argument.
        type: "double", "int64", "double*", "int64*" or "lanes*".
        role: "in", "out", "both", "work", "size" or "value".
        shape: The dimensions of an array; the last one of lanes is 8.
        is_array: Whether the struct holds an address.
    """

    def __init__(self, name: str, type: str, role: str, shape: tuple[str, ...]) -> None:
        self.name = name
        self.type = type
        self.role = role
        self.is_array = type.endswith("*")
        lanes = (str(LANES),) if type == "lanes*" else ()
        self.shape = tuple(Dimension(text) for text in (*shape, *lanes))

    def __str__(self) -> str:
        """Return the shape, such as "(n, 3)"."""
        return shape_text(dimension.text for dimension in self.shape)


class Operation:
    """Compiled function `int f(void *place, double time)` and the struct of its arguments.

    Attributes:
        name: Of the operation.
        address: Of the function.
        fields: In the order of the struct.
        names: Of all arguments.
        required: The names without which it cannot be bound.
        sizes: The names of sizes.
        layout: Of the struct, for `struct.pack`.
        plans: How it was bound, by names and shapes; for `cdpr.native.bind`.
    """

    def __init__(self, name: str, address: int, fields: tuple[Field, ...]) -> None:
        self.name = name
        self.address = address
        self.fields = fields
        self.names = frozenset(field.name for field in fields)
        self.required = frozenset(field.name for field in fields if field.role not in ("size", "work"))
        declared = (field.name for field in fields if field.role == "size")
        used = (symbol for field in fields for dimension in field.shape for symbol in dimension.symbols)
        self.sizes = frozenset((*declared, *used))
        self.plans: dict[object, Any] = {}
        self.layout = "=" + "".join("d" if field.type == "double" else "q" for field in fields)


def shape_text(shape: Iterable[object]) -> str:
    """Return a shape as Python writes it, of numbers or of symbols."""
    lengths = [str(length) for length in shape]
    return f"({', '.join(lengths)}{',' if len(lengths) == 1 else ''})"


def targets() -> tuple[str, ...]:
    """Return the instruction sets of the library that this processor can run, the fastest last."""
    return tuple(_tables())


def target() -> str:
    """Return the instruction set in use: the fastest, or that of the environment variable CDPR_NATIVE_TARGET.

    Raises:
        CdprError: The variable names none that this processor can run.
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
    """Return what tells states of the kernel library apart: a digest of its sources."""
    from cdpr.native import library

    return library.sources[:16]


@cache
def _tables() -> dict[str, dict[str, Operation]]:
    from cdpr.native import library

    return {
        target: {
            name: Operation(name, address, tuple(Field(*field) for field in fields))
            for name, address, _, fields in entries
        }
        for target, entries in library.tables()
    }
