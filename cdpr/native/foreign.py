"""Operations compiled elsewhere, for example by numba, a C compiler or Cython, with their arguments."""

from __future__ import annotations

import ctypes
import operator
from functools import lru_cache
from itertools import combinations
from pathlib import Path
from typing import Any, cast

import numpy as np

from cdpr.native.bind import Array
from cdpr.native.library import address

# Holds the GIL: the arrays of one object serve one call at a time.
OPERATION = ctypes.PYFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)
CTYPES_FUNCTION: type = ctypes.CFUNCTYPE(None).__mro__[1]  # base of all functions of ctypes
LOWEST_ADDRESS = 4096  # systems map no code below
MAPPINGS = Path("/proc/self/maps")  # memory of this process, on Linux
DTYPES = np.dtype(np.float64), np.dtype(np.int64)


class Foreign:
    """Compiled function `int f(void *place, double time)` with its arguments; called like the result of `bind`.

    `place` is the address of a struct of 8-byte members in the order of the arguments: a `double *` or `int64_t *` for
    an array, a `double` or an `int64_t` for a number. The function must remain valid as long as this object exists.

    Args:
        function: address, function of a ctypes library, or object with the address as `address`, such as a
            `numba.cfunc`. Objects are kept alive.
        arguments: C-contiguous arrays of float64 or int64, which must not move, and numbers. A writeable array must not
            share memory with another array.

    Raises:
        TypeError: if the function has no address, or an argument has another type.
        ValueError: if an array is not C-contiguous or not aligned to 8 bytes, or a writeable one shares memory with
            another one; or, on Linux, no code is at the address.

    Attributes:
        operation: address of the function.
        place: address of the struct.
        words: content of the struct.
        arrays: arrays among the arguments.

    Example:
        >>> import ctypes
        >>> import numpy as np
        >>> @ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.POINTER(ctypes.c_double)), ctypes.c_double)
        ... def halve(place, time):
        ...     place[1][0] = 0.5 * place[0][0]
        ...     return 0
        >>> call = Foreign(halve, np.array([3.0]), result := np.zeros(1))
        >>> call(), result
        (0, array([1.5]))
    """

    def __init__(self, function: Any, *arguments: Any) -> None:
        self.arrays: tuple[Array, ...] = tuple(each for each in arguments if isinstance(each, np.ndarray))
        self.words = np.array([_word(i, each) for i, each in enumerate(arguments)], dtype=np.int64)
        _check_apart(arguments)
        self.operation = _address(function)
        self._function = function  # keeps its code in memory
        self.place = address(self.words)
        self._call = OPERATION(self.operation)

    def __call__(self, time: float = 0.0, /) -> int:
        """Run it at a time, s; return its status code."""
        return int(self._call(self.place, time))


def _address(function: Any) -> int:
    if isinstance(function, CTYPES_FUNCTION):
        function = ctypes.cast(cast("Any", function), ctypes.c_void_p).value or 0
    try:
        found = operator.index(getattr(function, "address", function))
    except TypeError:
        kind = type(function).__name__
        raise TypeError(
            "function: expected an address, a function of ctypes, or an object with an attribute `address`, "
            f"got {kind}."
        ) from None
    _check_code(found)
    return found


@lru_cache(maxsize=1024)  # rollouts bind the same few functions for each case
def _check_code(found: int) -> None:
    """Raise ValueError if there is no code at an address."""
    if found < LOWEST_ADDRESS:
        raise ValueError(f"function: expected the address of a function, got {found}.")
    try:
        lines = MAPPINGS.read_text().splitlines()
    except OSError:  # not on Linux
        return
    for line in lines:
        span, access, _ = line.split(maxsplit=2)
        first, last = (int(number, 16) for number in span.split("-"))
        if first <= found < last and "x" in access:
            return
    raise ValueError(
        f"function: expected the address of a function, got {found:#x}, where no code is; keep its library loaded, and "
        "with ctypes use `ctypes.cast(function, ctypes.c_void_p).value`, not `addressof`."
    )


def _check_apart(arguments: tuple[Any, ...]) -> None:
    """Raise ValueError if a writeable array shares memory with another array."""
    given = [(i, each) for i, each in enumerate(arguments) if isinstance(each, np.ndarray) and each.size]
    spans = [(i, address(each), address(each) + each.nbytes, each.flags.writeable) for i, each in given]
    for (i, first, last, writes), (j, start, end, also) in combinations(spans, 2):
        if (writes or also) and first < end and start < last:
            raise ValueError(
                f"argument {j}: shares memory with argument {i}, and one of them is writeable; pass a separate array, "
                "or both read-only."
            )


def _word(i: int, argument: Any) -> int:
    """Return a member of the struct."""
    if isinstance(argument, np.ndarray):
        if argument.dtype not in DTYPES:
            raise TypeError(f"argument {i}: expected an array of float64 or int64, got {argument.dtype}.")
        if not argument.flags.c_contiguous or not argument.flags.aligned:
            raise ValueError(f"argument {i}: expected a C-contiguous, aligned array; make one with numpy.require.")
        return address(argument)
    if isinstance(argument, float | np.floating):
        return int(np.float64(argument).view(np.int64))
    try:
        found = operator.index(argument)
    except TypeError:
        raise TypeError(f"argument {i}: expected an array or a number, got {type(argument).__name__}.") from None
    if not -(2**63) <= found < 2**63:
        raise ValueError(f"argument {i}: expected an integer of 64 bits, got {found}.")
    return found
