"""What compiled code takes and returns, said without numba: kernels are found on disk by it, and called.

A kind that is called with others makes a signature: `NUMBER(ROW, VECTOR)` takes a row and a vector, returns a number.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np


class Kind:
    """Of one argument, or of what is returned."""

    def __call__(self, *args: Kind) -> Signature:
        """Return the signature of what returns this kind."""
        return Signature(self, args)


class Signature(NamedTuple):
    """What a function returns and takes."""

    result: Kind
    args: tuple[Kind, ...]


@dataclass(frozen=True)
class Plain(Kind):
    """A number or a truth value by numba's name of it; "none" is nothing."""

    name: str


@dataclass(frozen=True)
class Block(Kind):
    """An array in C's order of numbers of 8 bytes."""

    item: Plain
    dimensions: int


@dataclass(frozen=True)
class Group(Kind):
    """A tuple, or a named tuple of the class `made`."""

    items: tuple[Kind, ...]
    made: type | None = None


@dataclass(frozen=True)
class Function(Kind):
    """A kernel that is an argument."""

    signature: Signature


NUMBER, WHOLE, TRUTH, NOTHING, C_INT = map(Plain, ("float64", "int64", "boolean", "none", "int32"))
VECTOR, PAIR = Group((NUMBER,) * 3), Group((NUMBER,) * 2)
LED = Group((NUMBER,) * 4)  # a vector and a number
ROW, TABLE, CUBE = (Block(NUMBER, dimensions) for dimensions in (1, 2, 3))
LANES = Plain("lanes")  # eight numbers side by side: in arrays alone, of which they are the last axis
INDICES = Block(WHOLE, 1)


def kind_of(value: Any, wide: bool = False) -> Kind | None:
    """Return the kind under which compiled code takes an argument; None where it cannot without numba's help.

    If `wide`, the last axis of its arrays of float64 is that of lanes.
    """
    if isinstance(value, np.ndarray):
        block = _block(value.dtype, value.ndim) if value.flags.c_contiguous and value.flags.aligned else None
        return Block(LANES, value.ndim - 1) if wide and block is not None and block.item == NUMBER else block
    if isinstance(value, bool):
        return TRUTH
    if isinstance(value, int | np.signedinteger):
        return WHOLE
    if isinstance(value, float | np.floating):
        return NUMBER
    if isinstance(value, tuple):
        kinds = tuple(kind_of(each, wide) for each in value)
        known = tuple(kind for kind in kinds if kind is not None)
        return Group(known, type(value) if hasattr(value, "_fields") else None) if len(known) == len(kinds) else None
    return None


@cache
def _block(dtype: np.dtype[Any], dimensions: int) -> Block | None:
    known = {np.dtype(np.float64): NUMBER, np.dtype(np.int64): WHOLE}
    return Block(known[dtype], dimensions) if dtype in known else None


def text(kind: Kind) -> str:
    """Return a text that tells kinds apart, the same in all processes."""
    if isinstance(kind, Block):
        return f"{kind.item.name}[{kind.dimensions}]"
    if isinstance(kind, Group):
        made = "" if kind.made is None else f"{kind.made.__module__}.{kind.made.__qualname__}"
        return f"{made}({', '.join(map(text, kind.items))})"
    return kind.name if isinstance(kind, Plain) else repr(kind)


def packed(kind: Kind) -> Any:
    """Return a result's kind as JSON has it: a name, or a list of names of a tuple; ValueError for others."""
    if isinstance(kind, Plain):
        return kind.name
    if isinstance(kind, Group) and kind.made is None:
        return [packed(each) for each in kind.items]
    raise ValueError(kind)


def unpacked(packed_: Any) -> Kind:
    """Undo `packed`."""
    return Plain(packed_) if isinstance(packed_, str) else Group(tuple(map(unpacked, packed_)))
