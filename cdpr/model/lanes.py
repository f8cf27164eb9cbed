"""Words for a source that serves one problem or eight side by side: where it would branch on a number, it chooses.

A kernel that uses them compiles for float64 and for lanes, eight float64 in a register (`lane_types`). `if some(...)`
asks whether any of the eight goes this way; for those that do not, `choose` must leave undone what is done there, or
they stray: another answers them. With one number each word is what it says.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numpy as np

from cdpr.model.deferred import Deferred
from cdpr.model.robot import Array

P = ParamSpec("P")
R = TypeVar("R")

WIDTH = 8  # of the widest registers there are; where they are narrower, several take the place of one

# Only compiled code calls these; what they do stands in `lane_types`.
bits: Callable[..., int] = Deferred("lanes_word", "bits")
side_by_side: Callable[..., Any] = Deferred("lanes_word", "side_by_side")

# What numba is to be told of, when it first compiles a kernel: what one calls, and what lanes call in place of it.
instead: list[tuple[Callable[..., Any], Callable[..., Any]]] = []


def aligned(shape: tuple[int, ...]) -> Array:
    """Return space for numbers, the last axis of which is that of eight; it begins where a register is read at once."""
    raw = np.empty(math.prod(shape) + WIDTH)
    start = -(raw.ctypes.data // raw.itemsize) % WIDTH
    return raw[start : start + math.prod(shape)].reshape(shape)


def of_lanes(single: Callable[P, R]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Have kernels call the decorated function in place of `single`, if the first argument is an array of lanes.

    For the few places where eight at once must go another way to the same numbers. Neither is itself a kernel.
    """

    def decorate(eight: Callable[P, R]) -> Callable[P, R]:
        instead.append((single, eight))
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


def code(number: float) -> int:
    """Return a whole number that is 0 where all is well; of eight, the bits of those of which it is not 0."""
    return int(number)


def whole(number: float) -> int:
    """Return a whole number that is kept as a float, the same in all of eight."""
    return int(number)
