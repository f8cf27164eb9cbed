"""Electrical side of the motors of winches: current, voltage and power.

A DC motor with the torque constant k_t (N m/A), which is also its voltage constant in V s/rad, and the winding
resistance R (ohm) turns N times per turn of the drum. With the torque tau (N m) about the drum's axis, and the speed w
(rad/s) of the drum, in steady state

    i = tau / (k_t N),   u = R i + k_t N w,   P = u i = R i^2 + tau w

(Hughes and Drury: Electric motors and drives, 5th ed., 2019, ch. 3). The copper loss is R i^2. P is negative when the
motor feeds back power. The equations also hold for brushless motors with block commutation, with values between two
terminals. The inductance of the winding is neglected: its voltage is L di/dt, and its energy returns. Iron losses and
losses of the amplifier are not included; friction of the motor is that of the winch.

These values do not change a run: motors have the torque that their winch demands.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from cdpr.base.fields import NonNegative, Positive
from cdpr.cables.chain import Number
from cdpr.cables.stepper import TYPE as STEPPER
from cdpr.cables.transmission import GEAR_RATIO
from cdpr.model import Cable, Robot
from cdpr.model.robot import Array
from cdpr.native.arrays import real
from cdpr.native.bind import bind

TorqueConstant = Annotated[Positive, Field(ge=1e-9)]  # far below all motors; squares of currents stay finite
TORQUE_CONSTANT = Number("winch.torque_constant", TorqueConstant, "N m/A", "torque constant of the motor, at its shaft")
RESISTANCE = Number("winch.resistance", NonNegative, "ohm", "resistance of the motor's winding, between two terminals")
SUPPLY = Number(
    "winch.supply_voltage", Positive, "V", "voltage of the motor's supply; `cdpr size` compares it with the demand"
)
RATED_CURRENT = Number(
    "winch.rated_current", Positive, "A", "continuous current of the motor; `cdpr size` compares it with the rms value"
)
NUMBERS = (TORQUE_CONSTANT, RESISTANCE, SUPPLY, RATED_CURRENT)


def motor_table(robot: Robot) -> Array:
    """Return the motors of a robot's winches, (m, 2): k_t N [N m/A] and R [ohm]; NaN for unknown ones."""
    return np.array([_motor(cable) for cable in robot.cables])


def _motor(cable: Cable) -> tuple[float, float]:
    other = cable.winch is None or cable.winch.type == STEPPER  # the driver of a stepper keeps its current constant
    constant = math.nan if other else TORQUE_CONSTANT.of(cable, math.nan)
    if math.isnan(constant):
        return math.nan, math.nan
    return constant * GEAR_RATIO.of(cable), RESISTANCE.of(cable, math.nan)


def is_electrical(robot: Robot) -> bool:
    """Return True if torque constant and resistance of some motor are known."""
    return bool(np.isfinite(motor_table(robot)).all(axis=1).any())


def motor_readings(robot: Robot, torque: ArrayLike, speed: ArrayLike) -> tuple[Array, Array, Array]:
    """Return the electrical quantities of motors at given torques and speeds.

    Args:
        robot: the robot.
        torque: (K, m) N m, of the motors about the drums' axes.
        speed: (K, m) rad/s, of the drums, positive when winding in.

    Returns:
        Currents [A], voltages [V] and electrical powers [W], each (K, m); NaN for motors that are not known.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> motor = {"drum_radius": 0.05, "inertia": 0.002, "torque_constant": 0.1, "resistance": 0.5}
        >>> robot = cdpr.load_robot("caroca_winches", overrides={"winch": motor})
        >>> current, voltage, power = motor_readings(robot, [[2.0] * 8], [[10.0] * 8])
        >>> current[0, 0], voltage[0, 0], power[0, 0]
        (np.float64(20.0), np.float64(11.0), np.float64(220.0))
    """
    given = {"torque": real(torque, "torque"), "speed": real(speed, "speed")}
    found = {name: np.empty(given["torque"].shape) for name in ("current", "voltage", "power")}
    bind("read_motors", motors=motor_table(robot), **given, **found)()
    return found["current"], found["voltage"], found["power"]
