"""How numba makes the calls of `cdpr.model.address` and `cdpr.model.bound`: imported when something is compiled."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.registry import cpu_target
from numba.extending import intrinsic
from numba.np import arrayobj

from cdpr.model import lane_types, lanes
from cdpr.model.kinds import Kind, Signature
from cdpr.model.numba_kinds import numba_signature, numba_types

WORD = ir.IntType(64)


def type_of(made: Any) -> Any:
    """Return the type by which numba knows what is made here."""
    cpu_target.typing_context.refresh()
    return cpu_target.typing_context.resolve_value_type(made)


def caller(given: Signature) -> Callable[..., Any]:
    """Make what `cdpr.model.address.caller` returns."""
    signature = numba_signature(given)

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


def lanes_word(name: str) -> Any:
    """Return what one of the words of `cdpr.model.lanes` is made of."""
    return getattr(lane_types, name)


def c_caller(given: Signature) -> Callable[..., Any]:
    """Make what `cdpr.model.address.c_caller` returns."""
    signature = numba_signature(given)

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


def c_callback(given: Sequence[Kind], count: int) -> Callable[[], int]:
    """Make what `cdpr.model.address.c_callback` returns."""
    taken = numba_types(given)

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


def taker(kinds: Sequence[Kind], first: int) -> Callable[..., Any]:
    """Make what reads, in compiled code, arguments of these kinds from the words at an address, from `first` on."""
    whole = types.BaseTuple.from_types(numba_types(kinds))

    @intrinsic  # type: ignore[untyped-decorator]
    def take(typing: Any, place: Any) -> Any:
        def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
            start = builder.inttoptr(values[0], WORD.as_pointer())
            return context.make_tuple(builder, whole, read(context, builder, start, whole, first))

        return whole(types.intp), generate

    made: Callable[..., Any] = take
    return made


def read(context: Any, builder: Any, start: Any, wanted: Sequence[Any], first: int = 0) -> list[Any]:
    """Read values of these types of numba's from words of 8 bytes, an array from its address and its shape."""
    done = first

    def word() -> Any:
        nonlocal done
        done += 1
        return builder.load(builder.gep(start, [WORD(done - 1)]))

    def make(kind: Any) -> Any:
        if isinstance(kind, types.BaseTuple):
            return context.make_tuple(builder, kind, [make(each) for each in kind])
        if isinstance(kind, types.Float):
            return builder.bitcast(word(), ir.DoubleType())
        if not isinstance(kind, types.Array):
            return context.cast(builder, word(), types.intp, kind)
        data, shape = word(), [word() for _ in range(kind.ndim)]
        strides: list[Any] = []
        item = size = WORD(8 * lanes.WIDTH if kind.dtype == lane_types.LANES else 8)
        for length in reversed(shape):
            strides.insert(0, item)
            item = builder.mul(item, length)
        array = arrayobj.make_array(kind)(context, builder)
        at = builder.inttoptr(data, array.data.type)
        arrayobj.populate_array(array, at, shape, strides, size, meminfo=None)
        return array._getvalue()

    return [make(kind) for kind in wanted]


def write(context: Any, builder: Any, start: Any, kind: Any, value: Any) -> None:
    """Write a value, a number or a tuple of numbers, as words of 8 bytes."""
    values = [(kind, value)]
    if isinstance(kind, types.BaseTuple):
        values = list(zip(kind, cgutils.unpack_tuple(builder, value, len(kind)), strict=True))
    for i, (each, part) in enumerate(values):
        if isinstance(each, types.Float):
            part = builder.bitcast(part, WORD)
        elif not isinstance(each, types.NoneType):
            part = context.cast(builder, part, each, types.intp)
        else:
            continue
        builder.store(part, builder.gep(start, [WORD(i)]))
