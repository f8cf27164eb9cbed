"""The equation of `cdpr.cables.direct`."""

from __future__ import annotations

from cdpr.model.jit import kernel
from cdpr.model.robot import Array


@kernel
def held(numbers: Array, command: float, rate: float, swing: float) -> tuple[float, float]:
    """Return the command, and no mass."""
    return command, 0.0


@kernel
def turn(numbers: Array, command: float, tension: float, speed: float) -> float:
    """Return 0: it has no drum."""
    return 0.0
