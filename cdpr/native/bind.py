"""Binding of compiled operations to numpy arrays.

    product = numpy.empty_like(left)
    call = bind("cross_products", left=left, right=right, product=product)
    status = call()  # or call(time), time in s

All checks are made once, here; the call itself only runs the kernel. The arrays are kept alive, and the kernel reads
what they hold when it is called.
"""

from __future__ import annotations

import operator
import struct
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from cdpr.native.operations import LANES, Field, Operation, operations, shape_text

if TYPE_CHECKING:
    from cdpr.native.library import Bound

__all__ = ["LANES", "Compiled", "bind"]

Array = np.ndarray[Any, Any]
DTYPES = {"double*": np.dtype(np.float64), "int64*": np.dtype(np.int64), "lanes*": np.dtype(np.float64)}
ALIGNMENT = 8  # bytes
MOST_PLANS = 64  # plans of an operation, for different shapes

Span = tuple[int, int, Field]  # first and last address of an array, and its purpose


class Compiled(Protocol):
    """Operation with its arguments, as compiled code calls it."""

    @property
    def operation(self) -> int:
        """Return the address of the function `int f(void *place, double time)`."""

    @property
    def place(self) -> int:
        """Return the address of its struct."""

    @property
    def words(self) -> bytes | Array:
        """Return the content of the struct, 8 bytes per field."""


def bind(name: str, /, **given: Any) -> Bound:
    """Bind an operation to its arrays and numbers.

    Args:
        name: operation, a key of `operations()`.
        given: arrays and values by name. Sizes follow from the shapes. Omitted work arrays are allocated.

    Returns:
        A callable `call()` or `call(time)`, time in s, that returns the kernel's status code; `call.unlocked(time)`
        does the same while other threads of Python run. Its attributes `operation` and `place` are the addresses of the
        function and of its struct, `name` and `given` the arguments of this function.

    Raises:
        TypeError: if a name is missing or unknown, or a value has the wrong type.
        ValueError: if the operation is unknown, an array's shape, memory layout, alignment or write access is wrong, or
            a written array shares memory with another array.
    """
    from cdpr.native.library import Bound, address

    operation = operations().get(name)
    if operation is None:
        raise ValueError(f"Unknown operation '{name}'; the library has {', '.join(sorted(operations()))}.")
    shapes = [value.shape for value in given.values() if type(value) is np.ndarray]
    key = (*given, *shapes)
    plan: Plan | None = operation.plans.get(key) if len(operation.fields) < 256 else None
    if plan is not None and (bound := plan.bind(operation, given)) is not None:
        return bound
    if not operation.required <= given.keys() <= operation.names:
        raise TypeError(f"{name}: {_wrong_names(operation, given)}")
    sizes = _sizes(operation, given)
    values: list[float] = []
    spans: list[Span] = []
    arrays: list[Array] = []
    for field in operation.fields:
        if field.is_array:
            array = _sized(operation, field, given, sizes)
            arrays.append(array)
            start = address(array)
            values.append(start)
            spans.append((start, start + array.nbytes, field))
        elif field.role == "size":
            values.append(sizes[field.name])
        else:
            values.append(_number(f"{name}: {field.name}", field, given[field.name]))
    _check_overlaps(name, spans)
    if given.keys().isdisjoint(sizes):
        if len(operation.plans) >= MOST_PLANS:
            operation.plans.clear()
        operation.plans[key] = Plan(operation, given, sizes, arrays)
    return Bound(operation.address, struct.pack(operation.layout, *values), given, tuple(arrays))


class Plan:
    """Binding of an operation for arrays of known names and shapes, computed once."""

    def __init__(self, operation: Operation, given: dict[str, Any], sizes: dict[str, int], arrays: list[Array]) -> None:
        fields = list(enumerate(operation.fields))
        found = [(i, field) for i, field in fields if field.is_array]
        self._arrays = [
            (field.name, None if field.name in given else (array.shape, array.dtype))
            for (_, field), array in zip(found, arrays, strict=True)
        ]
        self._values = [(i, field) for i, field in fields if field.role == "value"]
        words = [sizes[field.name] if field.role == "size" else 0 for _, field in fields]
        self._words = struct.pack(operation.layout, *words)
        self._about = bytes(
            number
            for (i, field), array in zip(found, arrays, strict=True)
            for number in (field.type == "int64*", field.role != "in", min(i, 255), array.ndim)
        )
        self._shapes = np.array([length for array in arrays for length in array.shape], dtype=np.int64).tobytes()

    def bind(self, operation: Operation, given: dict[str, Any]) -> Bound | None:
        """Bind it; return None if an argument differs from the plan."""
        from cdpr.native.library import Bound, fill

        arrays = tuple(given[name] if work is None else np.empty(*work) for name, work in self._arrays)
        words = fill(np.ndarray, self._words, self._about, self._shapes, arrays)
        if words is None:
            return None
        if self._values:
            filled = bytearray(words)
            for i, field in self._values:
                value = _number(f"{operation.name}: {field.name}", field, given[field.name])
                struct.pack_into("=q" if field.type == "int64" else "=d", filled, 8 * i, value)
            words = bytes(filled)
        return Bound(operation.address, words, given, arrays)


def _wrong_names(operation: Operation, given: dict[str, Any]) -> str:
    if unknown := sorted(given.keys() - operation.names):
        return f"unknown arguments {', '.join(unknown)}; expected {', '.join(sorted(operation.names))}."
    return f"missing arguments {', '.join(sorted(operation.required - given.keys()))}."


def _sizes(operation: Operation, given: dict[str, Any]) -> dict[str, int]:
    """Check each array alone, and compute the sizes from the shapes."""
    name = operation.name
    sizes: dict[str, int] = {}
    sources: dict[str, str] = {}
    for field in operation.fields:
        value = given.get(field.name)
        if field.role == "size" and value is not None:
            sizes[field.name] = _integer(f"{name}: {field.name}", value)
            if sizes[field.name] < 0:
                raise ValueError(f"{name}: {field.name}: expected a size of at least 0, got {value}.")
            sources[field.name] = f"the argument '{field.name}'"
    for field in operation.fields:
        if not field.is_array or field.name not in given:
            continue
        array = given[field.name]
        _check_array(name, field, array)
        for dimension, length in zip(field.shape, array.shape, strict=True):
            symbol = dimension.symbol
            if symbol is not None and sizes.setdefault(symbol, length) != length:
                raise ValueError(
                    f"{name}: {field.name}: expected shape {field} with {symbol} = {sizes[symbol]} from "
                    f"{sources[symbol]}, got {shape_text(array.shape)}."
                )
            if symbol is not None:
                sources.setdefault(symbol, f"'{field.name}'")
    if unknown := sorted(operation.sizes - sizes.keys()):
        raise TypeError(f"{name}: missing sizes {', '.join(unknown)}, which follow from no array.")
    return sizes


def _check_array(name: str, field: Field, array: Any) -> None:
    if not isinstance(array, np.ndarray):
        raise TypeError(f"{name}: {field.name}: expected a numpy array, got {type(array).__name__}.")
    dtype = DTYPES[field.type]
    if array.dtype != dtype:
        raise TypeError(f"{name}: {field.name}: expected dtype {dtype}, got {array.dtype}; convert it with astype.")
    flags = array.flags
    if not (flags.carray if field.role != "in" else flags.carray or (flags.c_contiguous and flags.aligned)):
        raise ValueError(f"{name}: {field.name}: {_wrong_memory(flags)}")
    shape = array.shape
    fits = len(shape) == len(field.shape)
    if not fits or not all(dimension.allows(length) for dimension, length in zip(field.shape, shape, strict=True)):
        raise ValueError(f"{name}: {field.name}: expected shape {field}, got {shape_text(shape)}.")


def _wrong_memory(flags: Any) -> str:
    if not flags.c_contiguous:
        return "expected a C-contiguous array; make one with numpy.ascontiguousarray."
    if not flags.aligned:
        return f"expected an address that is a multiple of {ALIGNMENT} bytes; copy the array."
    return "expected a writeable array, got a read-only one."


def _sized(operation: Operation, field: Field, given: dict[str, Any], sizes: dict[str, int]) -> Array:
    """Return the array of a field if it has the expected shape, or a new one for work."""
    shape = tuple([dimension.evaluate(sizes) for dimension in field.shape])
    array: Array | None = given.get(field.name)
    if array is None:
        return np.empty(shape, DTYPES[field.type])
    if array.shape != shape:
        expected = f"{field} = {shape_text(shape)}"
        raise ValueError(f"{operation.name}: {field.name}: expected shape {expected}, got {shape_text(array.shape)}.")
    return array


def _check_overlaps(name: str, spans: list[Span]) -> None:
    """Reject a written array that shares memory with another one: the kernel would read overwritten values."""
    last = 0
    for start, end in sorted([(start, end) for start, end, _ in spans if start != end]):
        if start < last:
            break
        last = end
    else:
        return
    for start, end, field in spans:
        if field.role == "in" or start == end:
            continue
        for other_start, other_end, other in spans:
            if start < other_end and other_start < end and other is not field and other_start != other_end:
                raise ValueError(f"{name}: {field.name}: shares memory with {other.name}; write to a separate array.")


def _number(where: str, field: Field, value: Any) -> float:
    number = _integer(where, value) if field.type == "int64" else _real(where, value)
    if field.least is not None and not number >= field.least:
        raise ValueError(f"{where}: expected at least {field.least:g}, got {value}.")
    return number


def _real(where: str, value: Any) -> float:
    if not isinstance(value, float | int | np.floating | np.integer):
        raise TypeError(f"{where}: expected a number, got {type(value).__name__}.")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{where}: expected a number of at most 1.8e308 in size, got a larger one.") from None


def _integer(where: str, value: Any) -> int:
    try:
        whole = operator.index(value)
    except TypeError:
        raise TypeError(f"{where}: expected an integer, got {type(value).__name__}.") from None
    if not -(2**63) <= whole < 2**63:
        raise ValueError(f"{where}: expected an integer of 64 bits, got {whole}.")
    return whole
