"""Drums, friction and elastic cables: the equations of `cdpr.cables`, cable by cable."""

from __future__ import annotations

import math

import numpy as np

from cdpr.errors import CdprError
from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array

# Columns of what `pack` returns.
RADIUS, INERTIA, VISCOUS, COULOMB, COULOMB_SPEED, STIFFNESS, DAMPING, LOWEST = range(8)


def pack(robot: Robot) -> Array:
    """Winches and cables for the kernels, (m, 8): SI units, columns as named above.

    LOWEST is the lowest tension there can be, 0 or, for rigid legs, minus infinity.
    """
    packed = np.zeros((robot.m, 8))
    for row, cable in zip(packed, robot.cables, strict=True):
        winch, stiffness = cable.winch, cable.axial_stiffness
        if winch is None or (stiffness is None and robot.cable_model == "elastic"):
            lacking = "winch" if winch is None else "axial_stiffness"
            raise CdprError(f"cable '{cable.name}' has no {lacking}, which cable.model {robot.cable_model} needs")
        row[:STIFFNESS] = (
            winch.drum_radius,
            winch.inertia,
            winch.viscous_friction,
            winch.coulomb_friction,
            winch.coulomb_speed,
        )
        row[STIFFNESS:] = stiffness or 0.0, cable.damping, 0.0 if robot.unilateral else -math.inf
    return packed


@kernel
def friction(cables: Array, i: int, speed: float) -> float:
    """Torque, N m, that friction takes from winch i at a drum speed, rad/s."""
    torque: float = cables[i, VISCOUS] * speed + cables[i, COULOMB] * math.tanh(speed / cables[i, COULOMB_SPEED])
    return torque


@kernel
def drum_acceleration(cables: Array, i: int, command: float, tension: float, speed: float) -> float:
    """Return w' = (r (u - T) - f(w)) / I of winch i, rad/s^2."""
    acceleration: float = (cables[i, RADIUS] * (command - tension) - friction(cables, i, speed)) / cables[i, INERTIA]
    return acceleration


@kernel
def elastic_tension(cables: Array, i: int, length: float, rate: float, unstretched: float, speed: float) -> float:
    """Return T of elastic cable i, N; length, m, and rate, m/s, between its anchors, drum speed in rad/s."""
    stretch = length - unstretched
    if stretch <= 0.0 and cables[i, LOWEST] == 0.0:
        return 0.0
    pull: float = cables[i, STIFFNESS] * stretch / unstretched + cables[i, DAMPING] * (rate + cables[i, RADIUS] * speed)
    lowest: float = cables[i, LOWEST]
    return lowest if pull < lowest else pull


@kernel
def start_elastic(cables: Array, command: Array, length: Array, rate: Array, winch: Array) -> None:
    """Write unstretched lengths and drum speeds, (2 m,), at which each tension is its command (m,)."""
    m = cables.shape[0]
    for i in range(m):
        winch[i] = length[i] / (1.0 + command[i] / cables[i, STIFFNESS])
        winch[m + i] = -rate[i] / cables[i, RADIUS]
