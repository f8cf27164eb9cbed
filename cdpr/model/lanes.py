"""Words for a source that serves one problem or eight side by side: where it would branch on a number, it chooses.

A kernel that uses them compiles for float64 and for lanes, eight float64 in a register (`lane_types`). `if some(...)`
asks whether any of the eight goes this way; what those that do not would have done must then be left undone by `choose`,
or they stray: another answers them. With one number each word is what it says.
"""

from __future__ import annotations

from typing import Any

from numba.extending import overload

from cdpr.model.lane_types import LANES, MASK, WIDTH, bits, first, select, side_by_side

__all__ = ["WIDTH", "bits", "choose", "every", "side_by_side", "some", "whole"]


def some(condition: Any) -> bool:
    """Whether a condition holds, for any of eight."""
    return bool(condition)


def every(condition: Any) -> bool:
    """Whether a condition holds, for all of eight."""
    return bool(condition)


def choose(condition: Any, a: Any, b: Any) -> Any:
    """Return a where the condition holds, else b."""
    return a if condition else b


def whole(number: Any) -> int:
    """Return a whole number that is kept as a float, the same in all of eight."""
    return int(number)


@overload(some, strict=False)
def _some(condition: Any) -> Any:
    return (lambda condition: bits(condition) != 0) if condition == MASK else (lambda condition: condition)


@overload(every, strict=False)
def _every(condition: Any) -> Any:
    return (lambda condition: bits(condition) == 255) if condition == MASK else (lambda condition: condition)


@overload(choose, strict=False)
def _choose(condition: Any, a: Any, b: Any) -> Any:
    if condition == MASK:
        return lambda condition, a, b: select(condition, a, b)
    return lambda condition, a, b: a if condition else b


@overload(whole, strict=False)
def _whole(number: Any) -> Any:
    return (lambda number: int(first(number))) if number == LANES else (lambda number: int(number))
