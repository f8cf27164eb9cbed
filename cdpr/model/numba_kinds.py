"""Kinds as numba's types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from numba import types

from cdpr.model import lane_types
from cdpr.model.kinds import LANES, NOTHING, Block, Function, Group, Kind, Plain, Signature


def numba_type(kind: Kind) -> Any:
    """Return numba's type of a kind."""
    if isinstance(kind, Block):
        if kind.item == LANES:
            return lane_types.array_of(kind.dimensions)
        return types.Array(numba_type(kind.item), kind.dimensions, "C")
    if isinstance(kind, Group):
        return types.BaseTuple.from_types(numba_types(kind.items), kind.made)
    if isinstance(kind, Function):
        return types.FunctionType(numba_signature(kind.signature))
    assert isinstance(kind, Plain)
    return types.none if kind == NOTHING else getattr(types, kind.name)


def numba_types(kinds: Sequence[Kind]) -> tuple[Any, ...]:
    """Return numba's types of kinds."""
    return tuple(map(numba_type, kinds))


def numba_signature(signature: Signature) -> Any:
    """Return numba's signature."""
    return numba_type(signature.result)(*numba_types(signature.args))


def kind_from(found: Any) -> Kind | None:
    """Return the kind that a type of numba's is; None where there is none."""
    found = types.unliteral(found)
    if isinstance(found, types.NoneType):
        return NOTHING
    if isinstance(found, types.Array):
        if found == lane_types.array_of(found.ndim):
            return Block(LANES, found.ndim)
        item = kind_from(found.dtype)
        plain = found.layout == "C" and found.aligned and isinstance(item, Plain) and found.dtype.bitwidth == 64
        return Block(item, found.ndim) if plain and isinstance(item, Plain) else None
    if isinstance(found, types.BaseTuple):
        kinds = tuple(map(kind_from, found))
        known = tuple(kind for kind in kinds if kind is not None)
        return Group(known, getattr(found, "instance_class", None)) if len(known) == len(kinds) else None
    if found in (types.float64, types.boolean) or isinstance(found, types.Integer):
        return Plain(found.name if found != types.boolean else "boolean")
    return None
