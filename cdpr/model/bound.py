"""Kernels together with their arguments, for compiled code that calls one after the other and knows none of them.

A part of the loop is a kernel of its own kind and arguments, bound as `functools.partial` does. What runs them all
takes two addresses of each: of a function, `entry(place, time)`, and of the `place` in memory where the kernel's
address and its arguments stand. That function is compiled once for all kernels whose arguments are of the same kind: a
stranger's solver joins without anything being compiled for it.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numba.np import arrayobj
from numpy.typing import NDArray

from cdpr.model.address import NUMBER, address, caller
from cdpr.model.jit import is_kernel, kernel_of_kind

ENTRY = types.intp(types.intp, NUMBER)
WORD = ir.IntType(64)


@dataclass(frozen=True, eq=False)
class Bound:
    """A kernel with its arguments.

    Attributes:
        entry: address of what calls it.
        place: address of its arguments.
        call: what it was made of; holds the arguments.
    """

    entry: int
    words: NDArray[np.int64]
    call: Callable[..., Any]

    @property
    def place(self) -> int:
        """Where the arguments stand."""
        return self.words.ctypes.data


def bound(call: Callable[..., Any], timed: bool = False) -> Bound | None:
    """Return a `partial` of a kernel, or of such a partial, as compiled code calls it; None where it is none.

    Arguments are C-contiguous arrays of numbers of 8 bytes, numbers, and named tuples of these; all by place, none by
    name. Where it is `timed`, it takes the time (s) after them. What the kernel returns, if anything, is a whole
    number or a truth value.
    """
    function: Any = call
    arguments: tuple[Any, ...] = ()
    while isinstance(function, partial):
        if function.keywords:
            return None
        function, arguments = function.func, function.args + arguments
    if not is_kernel(function):
        return None
    kinds = tuple(_kind(each) for each in arguments)
    found = None if None in kinds else _found(function, kinds, timed)
    if found is None:
        return None
    entry, place = found
    return Bound(entry, np.array([place, *_words(arguments)], dtype=np.int64), call)


@cache
def _found(function: Any, kinds: tuple[Any, ...], timed: bool) -> tuple[int, int] | None:
    """Addresses of what calls a kernel with arguments of these kinds, and of the kernel; None where that cannot be."""
    kinds = tuple(map(_type, kinds))
    taken = (*kinds, NUMBER) if timed else kinds
    function.compile(taken)
    result = types.unliteral(function.overloads[taken].signature.return_type)
    if not isinstance(result, types.Integer | types.Boolean | types.NoneType):
        return None
    return _entry(kinds, result, timed), int(address(function, result(*taken)))


def _kind(value: Any) -> Any:
    """The kind of an argument, for `_type`; None where compiled code cannot take it.

    Plain data, since numba's own types take a long time to be looked for in a table.
    """
    if isinstance(value, np.ndarray):
        plain = value.dtype.isnative and value.dtype.itemsize == 8 and value.dtype.kind in "fi"
        return (value.dtype, value.ndim) if plain and value.flags.c_contiguous else None
    if isinstance(value, bool):
        return bool
    if isinstance(value, int | np.integer):
        return int
    if isinstance(value, float | np.floating):
        return float
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        kinds = tuple(_kind(each) for each in value)
        return None if None in kinds else (type(value), kinds)
    return None


SCALARS = {bool: types.boolean, int: types.intp, float: NUMBER}


def _type(kind: Any) -> Any:
    """The type under which compiled code takes an argument of this kind."""
    if kind in SCALARS:
        return SCALARS[kind]
    what, inner = kind
    if isinstance(what, type):
        return types.BaseTuple.from_types([_type(each) for each in inner], what)
    return types.Array(numba.from_dtype(what), inner, "C")


def _words(arguments: tuple[Any, ...]) -> list[int]:
    """The arguments as `_kind` has them, a word of 8 bytes each; an array is its address and its shape."""
    words: list[int] = []
    for value in arguments:
        if isinstance(value, np.ndarray):
            words += [value.ctypes.data, *value.shape]
        elif isinstance(value, tuple):
            words += _words(value)
        elif isinstance(value, float | np.floating):
            words += struct.unpack("q", struct.pack("d", value))
        else:
            words.append(int(value))
    return words


@cache
def _entry(kinds: tuple[Any, ...], result: Any, timed: bool) -> int:
    """Return the address of what calls kernels of this kind."""
    kernel_at, take = _taker((types.intp,), 0), _taker(kinds, 1)
    call: Any = caller(result(*kinds, NUMBER) if timed else result(*kinds))
    nothing = isinstance(result, types.NoneType)

    def entry_timed(place: int, time: float) -> int:
        code = call(kernel_at(place)[0], *take(place), time)
        return 0 if nothing else int(np.int64(code))  # some return C's int

    def entry(place: int, time: float) -> int:
        code = call(kernel_at(place)[0], *take(place))
        return 0 if nothing else int(np.int64(code))  # some return C's int

    return int(address(kernel_of_kind(entry_timed if timed else entry, (kinds, result)), ENTRY))


def _taker(kinds: tuple[Any, ...], first: int) -> Any:
    """Return what reads, in compiled code, arguments of these kinds from the words at an address, from `first` on."""
    whole = types.BaseTuple.from_types(kinds)

    @intrinsic  # type: ignore[untyped-decorator]
    def take(typing: Any, place: Any) -> Any:
        def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
            start = builder.inttoptr(values[0], WORD.as_pointer())
            read = first

            def word() -> Any:
                nonlocal read
                read += 1
                return builder.load(builder.gep(start, [WORD(read - 1)]))

            def make(kind: Any) -> Any:
                if isinstance(kind, types.BaseTuple):
                    return context.make_tuple(builder, kind, [make(each) for each in kind])
                if isinstance(kind, types.Float):
                    return builder.bitcast(word(), ir.DoubleType())
                if not isinstance(kind, types.Array):
                    return context.cast(builder, word(), types.intp, kind)
                data, shape = word(), [word() for _ in range(kind.ndim)]
                strides: list[Any] = []
                item = WORD(8)
                for size in reversed(shape):
                    strides.insert(0, item)
                    item = builder.mul(item, size)
                array = arrayobj.make_array(kind)(context, builder)
                at = builder.inttoptr(data, array.data.type)
                arrayobj.populate_array(array, at, shape, strides, WORD(8), meminfo=None)
                return array._getvalue()

            return context.make_tuple(builder, whole, [make(kind) for kind in whole])

        return whole(types.intp), generate

    return take
