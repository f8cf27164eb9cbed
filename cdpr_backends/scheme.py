"""Integrators of the reference, bound for any number of steps. See `include/cdpr/scheme.hpp` for their scheme."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

from cdpr.native.bind import bind

if TYPE_CHECKING:
    from cdpr.native.library import Bound


def steps_of(operation: str, **given: Any) -> Callable[[int], Bound]:
    """Return a function of n that returns an integrator's operation, bound to `given`, for n physics steps.

    Each operation is bound at its first use and kept.
    """
    return cache(lambda n: bind(operation, **given, steps=n))
