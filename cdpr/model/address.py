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

import numba
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

NUMBER = types.float64
VECTOR = types.UniTuple(types.float64, 3)
PAIR = types.UniTuple(types.float64, 2)
LED = types.UniTuple(types.float64, 4)  # a vector and a number
ROW = types.Array(types.float64, 1, "C")

# Kernels by address, held as long as the process lives: an address is valid as long as its kernel.
_KEPT: dict[int, Callable[..., Any]] = {}


def address(kernel: Callable[..., Any], signature: Any) -> float:
    """Return the address of a kernel, compiled for a signature of numba's such as VECTOR(ROW, VECTOR)."""
    if numba.config.DISABLE_JIT:
        place = id(kernel)
    else:
        dispatcher: Any = kernel
        dispatcher.compile(signature.args)
        entry = dispatcher.overloads[signature.args]
        if types.unliteral(entry.signature.return_type) != signature.return_type:
            raise TypeError(f"{kernel} returns {entry.signature.return_type}, expected {signature.return_type}")
        place = entry.library.get_pointer_to_function(entry.fndesc.llvm_func_name)
    _KEPT[place] = kernel
    return float(place)


def caller(signature: Any) -> Callable[..., Any]:
    """Return what compiled code calls with an address (float) and arguments of this signature."""
    if numba.config.DISABLE_JIT:
        return lambda place, *args: _KEPT[int(place)](*args)

    @intrinsic  # type: ignore[untyped-decorator]
    def call(typing: Any, place: Any, *args: Any) -> Any:
        def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
            convention, result, taken = context.call_conv, signature.return_type, signature.args
            kind = convention.get_function_type(result, taken)
            whole = context.cast(builder, values[0], place, types.intp)
            function = builder.inttoptr(whole, kind.as_pointer())
            arguments = cgutils.unpack_tuple(builder, values[1], len(taken))
            status, answer = convention.call_function(builder, function, result, taken, arguments)
            with builder.if_then(status.is_error, likely=False):
                convention.return_status_propagate(builder, status)
            return answer

        return signature.return_type(place, types.StarArgTuple(signature.args)), generate

    called: Callable[..., Any] = call
    return called


def c_caller(signature: Any) -> Callable[..., Any]:
    """Return what compiled code, and no other, calls with a C function's address and arguments of this signature.

    What the C function finds wrong it must say by what it returns: no exception passes through.
    """

    @intrinsic  # type: ignore[untyped-decorator]
    def call(typing: Any, place: Any, *args: Any) -> Any:
        def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
            nothing = isinstance(signature.return_type, types.NoneType)
            result = ir.VoidType() if nothing else context.get_value_type(signature.return_type)
            kind = ir.FunctionType(result, [context.get_value_type(each) for each in signature.args])
            function = builder.inttoptr(context.cast(builder, values[0], place, types.intp), kind.as_pointer())
            answer = builder.call(function, cgutils.unpack_tuple(builder, values[1], len(signature.args)))
            return context.get_dummy_value() if nothing else answer

        return signature.return_type(place, types.StarArgTuple(signature.args)), generate

    called: Callable[..., Any] = call
    return called


def c_callback(taken: Sequence[Any], count: int) -> Callable[[], int]:
    """Return what gives compiled code the address of a C function, for a library that calls back what it is given.

    The function takes arguments of the types `taken`, of which the last is the address of words of 8 bytes: those are
    the address of another C function and the `count` whole numbers with which that is called.
    """

    @intrinsic  # type: ignore[untyped-decorator]
    def callback(typing: Any) -> Any:
        def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
            word = context.get_value_type(types.intp)
            kind = ir.FunctionType(ir.VoidType(), [context.get_value_type(each) for each in taken])
            function = ir.Function(builder.module, kind, builder.module.get_unique_name("c_callback"))
            function.linkage = "internal"
            within = ir.IRBuilder(function.append_basic_block())
            words = within.inttoptr(function.args[-1], word.as_pointer())
            called, *given = [within.load(within.gep(words, [word(i)])) for i in range(1 + count)]
            target = ir.FunctionType(ir.VoidType(), [word] * count).as_pointer()
            within.call(within.inttoptr(called, target), given)
            within.ret_void()
            return builder.ptrtoint(function, word)

        return types.intp(), generate

    made: Callable[[], int] = callback
    return made
