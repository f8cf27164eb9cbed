"""The equations of `cdpr.cables.drum`."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.robot import Array

RADIUS, INERTIA, VISCOUS, COULOMB, COULOMB_SPEED = range(5)


@kernel
def friction(numbers: Array, speed: float) -> float:
    """Torque, N m, that friction takes at a drum speed, rad/s."""
    torque: float = numbers[VISCOUS] * speed + numbers[COULOMB] * math.tanh(speed / numbers[COULOMB_SPEED])
    return torque


@kernel
def held(numbers: Array, command: float, rate: float, swing: float) -> tuple[float, float]:
    """Return the tension at which the drum goes with a cable, and the mass that its inertia is along it, I / r^2."""
    radius = numbers[RADIUS]
    mass = numbers[INERTIA] / (radius * radius)
    return command - friction(numbers, -rate / radius) / radius + mass * swing, mass


@kernel
def turn(numbers: Array, command: float, tension: float, speed: float) -> float:
    """Return w' = (r (u - T) - f(w)) / I, rad/s^2."""
    acceleration: float = (numbers[RADIUS] * (command - tension) - friction(numbers, speed)) / numbers[INERTIA]
    return acceleration
