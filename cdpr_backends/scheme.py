"""Classical Runge-Kutta of order four, as far as the reference's integrators share it: each has its own variables.

A step of h goes through four stages. Each takes the slope k at its point y and adds weight * k to a sum; the next point
is y_0 + reach * k, and the result of the step y_0 + h/6 * sum.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

from cdpr.model.jit import kernel
from cdpr.model.kernels import Quaternion, Vector
from cdpr.native.bind import bind

if TYPE_CHECKING:
    from cdpr.native.library import Bound

STAGES = 4


def steps_of(operation: str, **given: Any) -> Callable[[int], Bound]:
    """Return a function of n that returns an integrator's operation, bound to `given`, for n physics steps.

    Each is bound when it is first needed, and kept.
    """
    return cache(lambda n: bind(operation, **given, steps=n))


@kernel
def weight(stage: int) -> float:
    """Return what a stage counts for in the sum of the slopes."""
    return 1.0 if stage == 0 or stage == 3 else 2.0


@kernel
def reach(stage: int, h: float) -> float:
    """Return how far the next stage lies from the start of the step; nothing comes after the last."""
    return h if stage == 2 else 0.5 * h


@kernel
def turning(q: Quaternion, w: Vector) -> Quaternion:
    """Return the rate of the attitude q of a body that turns with w, rad/s, world axes: w q / 2."""
    return (
        -0.5 * (w[0] * q[1] + w[1] * q[2] + w[2] * q[3]),
        0.5 * (w[0] * q[0] + w[1] * q[3] - w[2] * q[2]),
        0.5 * (w[1] * q[0] + w[2] * q[1] - w[0] * q[3]),
        0.5 * (w[2] * q[0] + w[0] * q[2] - w[1] * q[1]),
    )


@kernel
def normalised(q: Quaternion) -> Quaternion:
    """Return q / |q|."""
    norm = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return (q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm)
