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

import numpy as np
from numpy.typing import NDArray

from cdpr.model.address import address, caller
from cdpr.model.deferred import Deferred
from cdpr.model.jit import Kernel, kernel_of_kind
from cdpr.model.kinds import NOTHING, NUMBER, TRUTH, WHOLE, Kind, kind_of, text

ENTRY = WHOLE(WHOLE, NUMBER)
INTEGERS = "int", "uint"  # begin their names


@dataclass(frozen=True, eq=False)
class Bound:
    """A kernel with its arguments.

    Attributes:
        operation: address of what calls it.
        place: address of its arguments.
        call: what it was made of; holds the arguments.
    """

    operation: int
    words: NDArray[np.int64]
    call: Callable[..., Any]

    @property
    def place(self) -> int:
        """Where the arguments stand."""
        return self.words.ctypes.data


def bound(call: Callable[..., Any], timed: bool = False, wide: bool = False) -> Bound | None:
    """Return a `partial` of a kernel, or of such a partial, as compiled code calls it; None where it is none.

    Arguments are C-contiguous arrays of numbers of 8 bytes, numbers, and named tuples of these; all by place, none by
    name. Where it is `timed`, it takes the time (s) after them. What the kernel returns, if anything, is a whole
    number or a truth value. If `wide`, the last axis of its arrays of float64 is that of lanes.
    """
    function, arguments = taken_apart(call)
    if not isinstance(function, Kernel):
        return None
    kinds = tuple(kind_of(each, wide) for each in arguments)
    known = tuple(kind for kind in kinds if kind is not None)
    found = _found(function, known, timed) if len(known) == len(kinds) else None
    if found is None:
        return None
    entry, place = found
    return Bound(entry, np.array([place, *_words(arguments, wide)], dtype=np.int64), call)


def taken_apart(call: Callable[..., Any]) -> tuple[Callable[..., Any] | None, tuple[Any, ...]]:
    """Return what a `partial`, or a partial of such, calls, and with what; None where that is said by name."""
    function: Any = call
    arguments: tuple[Any, ...] = ()
    while isinstance(function, partial):
        if function.keywords:
            return None, ()
        function, arguments = function.func, function.args + arguments
    return function, arguments


@cache
def _found(function: Kernel, kinds: tuple[Kind, ...], timed: bool) -> tuple[int, int] | None:
    """Addresses of what calls a kernel with arguments of these kinds, and of the kernel; None where that cannot be."""
    taken = (*kinds, NUMBER) if timed else kinds
    result = function.native(taken).result
    if result is None or (result not in (NOTHING, TRUTH) and not getattr(result, "name", "").startswith(INTEGERS)):
        return None
    return _entry(kinds, result, timed), int(address(function, result(*taken)))


def _words(arguments: tuple[Any, ...], wide: bool) -> list[int]:
    """The arguments as `kind_of` has them, a word of 8 bytes each; an array is its address and its shape."""
    words: list[int] = []
    for value in arguments:
        if isinstance(value, np.ndarray):
            shape = value.shape[:-1] if wide and value.dtype == np.float64 else value.shape
            words += [value.ctypes.data, *shape]
        elif isinstance(value, tuple):
            words += _words(value, wide)
        elif isinstance(value, float | np.floating):
            words += struct.unpack("q", struct.pack("d", value))
        else:
            words.append(int(value))
    return words


@cache
def _entry(kinds: tuple[Kind, ...], result: Kind, timed: bool) -> int:
    """Return the address of what calls kernels of this kind."""
    kernel_at, take = Deferred("taker", (WHOLE,), 0), Deferred("taker", kinds, 1)
    call: Any = caller(result(*kinds, NUMBER) if timed else result(*kinds))
    nothing = result == NOTHING

    def entry_timed(place: int, time: float) -> int:
        code = call(kernel_at(place)[0], *take(place), time)
        return 0 if nothing else int(np.int64(code))  # some return C's int

    def entry(place: int, time: float) -> int:
        code = call(kernel_at(place)[0], *take(place))
        return 0 if nothing else int(np.int64(code))  # some return C's int

    kind = f"{', '.join(map(text, kinds))} to {text(result)}"
    return int(address(kernel_of_kind(entry_timed if timed else entry, kind), ENTRY))
