"""Kernels that are called by their address, which may stand in data.

What is compiled then needs not know which kernel it will call: one compiled plant serves all parts of cables, those of
later add-ons too. A call costs some nanoseconds more than one by name. An address fits a float without rounding, since
addresses of processes have at most 48 bits, so that it can stand in a row beside the part's numbers; it means nothing
in another process.

C functions of other libraries are called by their address, too. They take numbers, and addresses as whole numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from cdpr.model.deferred import Deferred
from cdpr.model.jit import DISABLED, Kernel
from cdpr.model.kinds import Kind, Signature

# Kernels by address, held as long as the process lives: an address is valid as long as its kernel.
_KEPT: dict[int, Callable[..., Any]] = {}


def address(kernel: Callable[..., Any], signature: Signature) -> float:
    """Return the address of a kernel, compiled for a signature such as VECTOR(ROW, VECTOR)."""
    if isinstance(kernel, Kernel):
        found = kernel.native(signature.args)
        if found.result != signature.result:
            raise TypeError(f"{kernel} returns {found.result}, expected {signature.result}")
        place = found.address
    else:
        place = id(kernel)
    _KEPT[place] = kernel
    return float(place)


def caller(signature: Signature) -> Callable[..., Any]:
    """Return what compiled code calls with an address (float) and arguments of this signature."""
    return (lambda place, *args: _KEPT[int(place)](*args)) if DISABLED else Deferred("caller", signature)


def c_caller(signature: Signature) -> Callable[..., Any]:
    """Return what compiled code, and no other, calls with a C function's address and arguments of this signature.

    What the C function finds wrong it must say by what it returns: no exception passes through.
    """
    return Deferred("c_caller", signature)


def c_callback(taken: Sequence[Kind], count: int) -> Callable[[], int]:
    """Return what gives compiled code the address of a C function, for a library that calls back what it is given.

    The function takes arguments of the kinds `taken`, of which the last is the address of words of 8 bytes: those are
    the address of another C function and the `count` whole numbers with which that is called.
    """
    return Deferred("c_callback", tuple(taken), count)
