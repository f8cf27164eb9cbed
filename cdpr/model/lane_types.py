"""Eight numbers side by side as a type of compiled code, so that one source serves one problem or eight at once.

LLVM makes poor vectors of arrays with an inner loop of eight, and good ones of its own type <8 x double>. Each number
of eight goes through the same operations in the same order as a float64 would, and none is contracted: the bits are the
same. Used by way of `cdpr.model.lanes`.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel.models import PrimitiveModel
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, lower_cast, overload, register_model
from numba.np.arrayobj import make_array, populate_array

from cdpr.model.lanes import WIDTH

NUMBERS = ir.VectorType(ir.DoubleType(), WIDTH)
ANSWERS = ir.VectorType(ir.IntType(1), WIDTH)
FIRST = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)

# What float64 does, too: comparisons with NaN are false, but for `!=`.
ARITHMETIC = {operator.add: "fadd", operator.sub: "fsub", operator.mul: "fmul", operator.truediv: "fdiv"}
IN_PLACE = {operator.iadd: "fadd", operator.isub: "fsub", operator.imul: "fmul", operator.itruediv: "fdiv"}
ORDERED = {operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">=", operator.eq: "=="}
LOGIC = {operator.and_: "and_", operator.or_: "or_"}


class Lanes(types.Type):  # type: ignore[misc]
    """Eight float64; a number beside it stands for eight of the same."""

    def __init__(self) -> None:
        super().__init__(name="lanes")

    def unify(self, typingctx: Any, other: Any) -> Any:
        """A variable that is first a number and then lanes is lanes."""
        return self if isinstance(other, (types.Float, types.Integer)) else None

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        """So is a number where lanes are expected."""
        return Conversion.safe if isinstance(other, (types.Float, types.Integer)) else None


class Mask(types.Type):  # type: ignore[misc]
    """Eight truth values; one beside it stands for eight of the same."""

    def __init__(self) -> None:
        super().__init__(name="mask")

    def unify(self, typingctx: Any, other: Any) -> Any:
        """Of variables that are lanes only where they are changed, numba first compares what they were before."""
        return self if isinstance(other, types.Boolean) else None

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        """So is one truth value where a mask is expected."""
        return Conversion.safe if isinstance(other, types.Boolean) else None


LANES, MASK = Lanes(), Mask()


def array_of(dimensions: int) -> Any:
    """Return the type of arrays of lanes."""
    return types.Array(LANES, dimensions, "C", aligned=False)


@register_model(Lanes)
class _LanesModel(PrimitiveModel):  # type: ignore[misc]
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, NUMBERS)


@register_model(Mask)
class _MaskModel(PrimitiveModel):  # type: ignore[misc]
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, ANSWERS)


@lower_cast(types.Float, Lanes)  # type: ignore[untyped-decorator]
@lower_cast(types.Integer, Lanes)  # type: ignore[untyped-decorator]
def _spread(context: Any, builder: Any, fromty: Any, toty: Any, value: Any) -> Any:
    number = context.cast(builder, value, fromty, types.float64)
    one = builder.insert_element(ir.Constant(NUMBERS, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(one, ir.Constant(NUMBERS, ir.Undefined), FIRST)


@lower_cast(types.Boolean, Mask)  # type: ignore[untyped-decorator]
def _spread_truth(context: Any, builder: Any, fromty: Any, toty: Any, value: Any) -> Any:
    true, false = (ir.Constant(ANSWERS, [bit] * WIDTH) for bit in (1, 0))
    return builder.select(context.cast(builder, value, fromty, types.boolean), true, false)


def _operator(what: Any, kind: type, result: Any, lower: Callable[[Any, Any], Any], count: int = 2) -> None:
    """Let an operator take `count` of a kind, or what stands for eight of it beside one, and give `result`."""
    taken, beside = (LANES, (types.Float, types.Integer)) if kind is Lanes else (MASK, (types.Boolean,))

    class Template(AbstractTemplate):  # type: ignore[misc]
        def generic(self, args: Any, kws: Any) -> Any:
            fitting = all(isinstance(each, (kind, *beside)) for each in args)
            mine = any(isinstance(each, kind) for each in args)
            return signature(result, *[taken] * count) if mine and fitting and len(args) == count else None

    infer_global(what)(Template)
    lower_builtin(what, *[kind] * count)(lambda context, builder, sig, args: lower(builder, args))


def _instruction(name: str, *first: str) -> Callable[[Any, Any], Any]:
    """One of llvmlite's builders of instructions, with what stands before its operands."""
    return lambda builder, args: getattr(builder, name)(*first, *args)


def _called(name: str) -> Callable[[Any, Any], Any]:
    """LLVM's own function of a vector."""

    def lower(builder: Any, args: Any) -> Any:
        kind = ir.FunctionType(NUMBERS, [NUMBERS])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64"), args)

    return lower


def _one_by_one(name: str, count: int) -> Callable[[Any, Any], Any]:
    """A C library's function, of each of eight."""

    def lower(builder: Any, args: Any) -> Any:
        kind = ir.FunctionType(ir.DoubleType(), [ir.DoubleType()] * count)
        function, found = cgutils.get_or_insert_function(builder.module, kind, name), ir.Constant(NUMBERS, ir.Undefined)
        for i in range(WIDTH):
            at = ir.Constant(ir.IntType(32), i)
            one = builder.call(function, [builder.extract_element(each, at) for each in args])
            found = builder.insert_element(found, one, at)
        return found

    return lower


for what, name in {**ARITHMETIC, **IN_PLACE}.items():
    _operator(what, Lanes, LANES, _instruction(name))
for what, sign in ORDERED.items():
    _operator(what, Lanes, MASK, _instruction("fcmp_ordered", sign))
_operator(operator.ne, Lanes, MASK, _instruction("fcmp_unordered", "!="))
for what, name in LOGIC.items():
    _operator(what, Mask, MASK, _instruction(name))
_operator(operator.neg, Lanes, LANES, _instruction("fneg"), 1)
_operator(operator.invert, Mask, MASK, _instruction("not_"), 1)
_operator(math.sqrt, Lanes, LANES, _called("sqrt"), 1)
_operator(abs, Lanes, LANES, _called("fabs"), 1)
_operator(math.atan2, Lanes, LANES, _one_by_one("atan2", 2))


@intrinsic  # type: ignore[untyped-decorator]
def select(typing: Any, mask: Any, a: Any, b: Any) -> Any:
    """Of each of eight, a where the mask is true, else b."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(*args)

    return signature(LANES, MASK, LANES, LANES), generate


@intrinsic  # type: ignore[untyped-decorator]
def bits(typing: Any, mask: Any) -> Any:
    """A mask as a whole number: 1 for the first of eight, 2 for the second, and so on."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.zext(builder.bitcast(args[0], ir.IntType(WIDTH)), ir.IntType(64))

    return signature(types.int64, MASK), generate


@intrinsic  # type: ignore[untyped-decorator]
def first(typing: Any, lanes: Any) -> Any:
    """The first of eight."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.extract_element(args[0], ir.Constant(ir.IntType(32), 0))

    return signature(types.float64, LANES), generate


@intrinsic  # type: ignore[untyped-decorator]
def side_by_side(typing: Any, array: Any) -> Any:
    """A C-contiguous float64 array whose last axis has eight numbers, as an array of lanes in the same memory.

    It need not lie at a multiple of 64 bytes, but is faster there.
    """
    if not (isinstance(array, types.Array) and array.dtype == types.float64 and array.layout == "C" and array.ndim > 1):
        return None
    made = array_of(array.ndim - 1)

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        given, view = make_array(array)(context, builder, args[0]), make_array(made)(context, builder)
        populate_array(
            view,
            data=builder.bitcast(given.data, NUMBERS.as_pointer()),
            shape=cgutils.unpack_tuple(builder, given.shape)[:-1],
            strides=cgutils.unpack_tuple(builder, given.strides)[:-1],
            itemsize=context.get_constant(types.intp, 8 * WIDTH),
            meminfo=None,  # whoever made the array holds it
        )
        return view._getvalue()

    return signature(made, array), generate


@overload(max, strict=False)  # type: ignore[untyped-decorator]
def _max(a: Any, b: Any, c: Any = None) -> Any:
    """As Python's: the first that none later exceeds, whatever NaN is among them."""
    if LANES not in (a, b, c):
        return None
    if c is None or isinstance(c, types.Omitted):
        return lambda a, b, c=None: select(b > a, b, a)
    return lambda a, b, c=None: max(max(a, b), c)


@overload(min, strict=False)  # type: ignore[untyped-decorator]
def _min(a: Any, b: Any) -> Any:
    return (lambda a, b: select(b < a, b, a)) if LANES in (a, b) else None
