"""The equations of `cdpr.cables.elastic`."""

from __future__ import annotations

from cdpr.model.jit import kernel
from cdpr.model.robot import Array

STIFFNESS, DAMPING = range(2)


@kernel
def pull(numbers: Array, length: float, unwound: float, stretching: float, lowest: float) -> float:
    """Return the tension, N, none below `lowest`: 0, or minus infinity of a leg."""
    stretch = length - unwound
    if stretch <= 0.0 and lowest == 0.0:
        return 0.0
    tension: float = numbers[STIFFNESS] * stretch / unwound + numbers[DAMPING] * stretching
    return lowest if tension < lowest else tension


@kernel
def rest(numbers: Array, length: float, tension: float) -> float:
    """Return the unwound length, m, of a cable that has this tension at rest."""
    unwound: float = length / (1.0 + tension / numbers[STIFFNESS])
    return unwound
