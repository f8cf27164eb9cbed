"""Words for a source that serves one problem or eight side by side: where it would branch on a number, it chooses.

A kernel that uses them compiles for float64 and for lanes, eight float64 in a register (`lane_types`). `if some(...)`
asks whether any of the eight goes this way; for those that do not, `choose` must leave undone what is done there, or
they stray: another answers them. With one number each word is what it says.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

from numba.extending import overload

from cdpr.model import lane_types
from cdpr.model.lane_types import LANES, MASK, WIDTH, first, select
from cdpr.model.robot import Array

P = ParamSpec("P")
R = TypeVar("R")

# Only compiled code calls these.
bits: Callable[[bool], int] = lane_types.bits
side_by_side: Callable[[Array], Array] = lane_types.side_by_side

__all__ = ["WIDTH", "bits", "choose", "every", "of_lanes", "side_by_side", "some", "whole"]


def of_lanes(single: Callable[P, R]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Have kernels call the decorated function in place of `single`, if the first argument is an array of lanes.

    For the few places where eight at once must go another way to the same numbers. Neither is itself a kernel.
    """

    def decorate(eight: Callable[P, R]) -> Callable[P, R]:
        @overload(single, strict=False)  # type: ignore[untyped-decorator]
        def either(*arguments: Any) -> Any:
            return eight if arguments[0].dtype == LANES else single

        return eight

    return decorate


def some(condition: bool) -> bool:
    """Whether a condition holds, for any of eight."""
    return bool(condition)


def every(condition: bool) -> bool:
    """Whether a condition holds, for all of eight."""
    return bool(condition)


def choose(condition: bool, a: float, b: float) -> float:
    """Return a where the condition holds, else b."""
    return a if condition else b


def whole(number: float) -> int:
    """Return a whole number that is kept as a float, the same in all of eight."""
    return int(number)


@overload(some, strict=False)  # type: ignore[untyped-decorator]
def _some(condition: Any) -> Any:
    return (lambda condition: lane_types.bits(condition) != 0) if condition == MASK else (lambda condition: condition)


@overload(every, strict=False)  # type: ignore[untyped-decorator]
def _every(condition: Any) -> Any:
    return (lambda condition: lane_types.bits(condition) == 255) if condition == MASK else (lambda condition: condition)


@overload(choose, strict=False)  # type: ignore[untyped-decorator]
def _choose(condition: Any, a: Any, b: Any) -> Any:
    if condition == MASK:
        return lambda condition, a, b: select(condition, a, b)
    return lambda condition, a, b: a if condition else b


@overload(whole, strict=False)  # type: ignore[untyped-decorator]
def _whole(number: Any) -> Any:
    return (lambda number: int(first(number))) if number == LANES else (lambda number: int(number))
