"""How numba compiles the words of `cdpr.model.lanes`: imported when something is compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from cdpr.model import lane_types, lanes
from cdpr.model.lane_types import LANES, MASK, first, select

_told = 0


def tell_numba() -> None:
    """Tell numba what lanes call in place of what, as far as it has not been told."""
    global _told
    for single, eight in lanes.instead[_told:]:
        _told += 1
        _overload(single, eight)


def _overload(single: Callable[..., Any], eight: Callable[..., Any]) -> None:
    @overload(single, strict=False)  # type: ignore[untyped-decorator]
    def either(*arguments: Any) -> Any:
        return eight if arguments[0].dtype == LANES else single


@overload(lanes.some, strict=False)  # type: ignore[untyped-decorator]
def _some(condition: Any) -> Any:
    return (lambda condition: lane_types.bits(condition) != 0) if condition == MASK else (lambda condition: condition)


@overload(lanes.every, strict=False)  # type: ignore[untyped-decorator]
def _every(condition: Any) -> Any:
    return (lambda condition: lane_types.bits(condition) == 255) if condition == MASK else (lambda condition: condition)


@overload(lanes.choose, strict=False)  # type: ignore[untyped-decorator]
def _choose(condition: Any, a: Any, b: Any) -> Any:
    if condition == MASK:
        return lambda condition, a, b: select(condition, a, b)
    return lambda condition, a, b: a if condition else b


@overload(lanes.code, strict=False)  # type: ignore[untyped-decorator]
def _code(number: Any) -> Any:
    return (lambda number: lane_types.bits(number != 0.0)) if number == LANES else (lambda number: int(number))


@overload(lanes.whole, strict=False)  # type: ignore[untyped-decorator]
def _whole(number: Any) -> Any:
    return (lambda number: int(first(number))) if number == LANES else (lambda number: int(number))
