"""Binding of compiled operations to numpy arrays.

    product = numpy.empty_like(left)
    call = bind("cross_products", left=left, right=right, product=product)
    status = call()  # or call(time), time in s

All checks are made once, here; the call itself only runs the kernel. The arrays are kept alive, and the kernel sees
what they hold when it is called.
"""

from __future__ import annotations

import operator
import struct
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.native.operations import Field, operations
from cdpr.native.sizes import evaluate, symbols

if TYPE_CHECKING:
    from cdpr.native.library import Bound

LANES = 8  # the last axis of arrays of lanes
DTYPES = {"double*": np.dtype(np.float64), "int64*": np.dtype(np.int64), "lanes*": np.dtype(np.float64)}
ALIGNMENT = 8  # bytes


def bind(name: str, /, **given: Any) -> Bound:
    """Bind an operation to its arrays and numbers.

    Args:
        name: The operation, a key of `operations()`.
        given: Its arrays and values by name. Sizes follow from the shapes. Work arrays are made if left out.

    Returns:
        A callable `call()` or `call(time)`, time in s, that returns the kernel's status code. Its attributes
        `operation` and `place` are the addresses of the function and of its struct.

    Raises:
        TypeError: A name is missing or unknown, or a value has the wrong type.
        ValueError: The operation is unknown, or an array's shape, memory layout, alignment or write access is wrong.
    """
    from cdpr.native.library import Bound

    found = operations().get(name)
    if found is None:
        raise ValueError(f"Unknown operation '{name}'; the library has {', '.join(sorted(operations()))}.")
    arguments = _complete(name, found.fields, given)
    for field in found.fields:
        if field.is_array and field.name in arguments:
            _check_array(f"{name}: {field.name}", field, arguments[field.name])
    sizes = _sizes(name, found.fields, arguments)
    words, arrays = [], []
    for field in found.fields:
        if field.is_array:
            array = _sized(name, field, arguments, sizes)
            arrays.append(array)
            words.append(struct.pack("=q", address(array)))
        elif field.role == "size":
            words.append(struct.pack("=q", sizes[field.name]))
        else:
            words.append(_number(f"{name}: {field.name}", field, arguments[field.name]))
    return Bound(found.address, b"".join(words), tuple(arrays))


def address(array: np.ndarray[Any, Any]) -> int:
    """Return the address of an array's first element."""
    return int(array.__array_interface__["data"][0])


def _complete(name: str, fields: tuple[Field, ...], given: dict[str, Any]) -> dict[str, Any]:
    known = {field.name for field in fields}
    if unknown := sorted(given.keys() - known):
        raise TypeError(f"{name}: unknown arguments {', '.join(unknown)}; expected {', '.join(sorted(known))}.")
    needed = [field.name for field in fields if field.role not in ("size", "work")]
    if missing := [word for word in needed if word not in given]:
        raise TypeError(f"{name}: missing arguments {', '.join(missing)}.")
    return given


def _check_array(where: str, field: Field, array: Any) -> None:
    if not isinstance(array, np.ndarray):
        raise TypeError(f"{where}: expected a numpy array, got {type(array).__name__}.")
    dtype = DTYPES[field.type]
    if array.dtype != dtype:
        raise TypeError(f"{where}: expected dtype {dtype}, got {array.dtype}; convert it with astype.")
    if not array.flags.c_contiguous:
        raise ValueError(f"{where}: expected a C-contiguous array; make one with numpy.ascontiguousarray.")
    if address(array) % ALIGNMENT:
        raise ValueError(f"{where}: expected an address that is a multiple of {ALIGNMENT}; copy the array.")
    if field.role != "in" and not array.flags.writeable:
        raise ValueError(f"{where}: expected a writeable array, got a read-only one.")
    if array.ndim != len(_shape(field)):
        raise ValueError(f"{where}: expected shape {_text(_shape(field))}, got {_text(array.shape)}.")


def _shape(field: Field) -> tuple[str, ...]:
    return (*field.shape, str(LANES)) if field.type == "lanes*" else field.shape


def _sizes(name: str, fields: tuple[Field, ...], arguments: dict[str, Any]) -> dict[str, int]:
    """Compute the sizes from the shapes of the arrays, and check them against each other."""
    sizes: dict[str, int] = {}
    source: dict[str, str] = {}
    for field in fields:
        if field.role == "size" and field.name in arguments:
            sizes[field.name] = _whole(f"{name}: {field.name}", arguments[field.name])
            source[field.name] = field.name
    for field in fields:
        if not field.is_array or field.name not in arguments:
            continue
        for dimension, length in zip(_shape(field), arguments[field.name].shape, strict=True):
            if dimension.isidentifier() and sizes.setdefault(dimension, length) != length:
                raise ValueError(
                    f"{name}: {field.name}: expected {dimension} = {sizes[dimension]} as in {source[dimension]}, "
                    f"got shape {_text(arguments[field.name].shape)} for {_text(_shape(field))}."
                )
            source.setdefault(dimension, field.name)
    needed = {field.name for field in fields if field.role == "size"}
    needed |= {symbol for field in fields for dimension in field.shape for symbol in symbols(dimension)}
    if unknown := sorted(needed - sizes.keys()):
        raise TypeError(f"{name}: missing sizes {', '.join(unknown)}, which follow from no array.")
    return sizes


def _sized(name: str, field: Field, arguments: dict[str, Any], sizes: dict[str, int]) -> np.ndarray[Any, Any]:
    """Return the array of a field with the expected shape, or a new one for work."""
    shape = tuple(evaluate(dimension, sizes) for dimension in _shape(field))
    array: np.ndarray[Any, Any] | None = arguments.get(field.name)
    if array is None:
        return np.empty(shape, DTYPES[field.type])
    if array.shape != shape:
        wanted = _text(_shape(field))
        raise ValueError(f"{name}: {field.name}: expected shape {wanted} = {_text(shape)}, got {_text(array.shape)}.")
    return array


def _number(where: str, field: Field, value: Any) -> bytes:
    if field.type == "int64":
        return struct.pack("=q", _whole(where, value))
    try:
        return struct.pack("=d", value)
    except (struct.error, TypeError):
        raise TypeError(f"{where}: expected a number, got {type(value).__name__}.") from None


def _whole(where: str, value: Any) -> int:
    try:
        return operator.index(value)
    except TypeError:
        raise TypeError(f"{where}: expected an integer, got {type(value).__name__}.") from None


def _text(shape: tuple[object, ...]) -> str:
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
