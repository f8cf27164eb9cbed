"""Servos on tendons of an MJCF model as winches that take lengths or rates.

A servo with control c, gear g, gain k and bias b0 + b1 g l + b2 g l' pulls a tendon of length l with the tension
T = -g (k c + b0 + b1 g l + b2 g l'). A position servo (b1 < 0) is a spring of stiffness kp = -b1 g^2 towards the length
L = (k c + b0) / (-b1 g), with the damping kv = -b2 g^2:

    T = kp (l - L) + kv l'

This is the law of a servo of ours (`cdpr.cables.servo`) with position_gain kp / kv and velocity_gain kv r^2, on a
cable that does not stretch. A velocity servo (b1 = 0) is T = kv (l' - V), with V = (k c + b0) / (-b2 g). Tendons have
no drum: a radius of 1 m makes torques and angles of ours equal to forces and lengths.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from cdpr.cables import ACTUATED, servo

RADIUS = 1.0  # m
SHARE = 0.02  # assumed mass of a winch, moved along the cable, per mass of the platform
STIFFER = 100.0  # stiffness of the cable relative to that of its servo
STRETCH = 1e-3  # stretch of the cable at its largest tension
POSITION_GAIN = servo.POSITION_GAIN.default or 1.0  # 1/s, without kv


@dataclass(frozen=True)
class Servo:
    """Servo of a tendon.

    Attributes:
        kind: type of the winch, "position" or "velocity".
        stiffness: kp, N/m; 0 for a velocity servo.
        damping: kv, N s/m.
        integrates: True if its control is a rate that it integrates to a length (`intvelocity`).
        scale: length, m, or rate, m/s, per unit of control.
        offset: length or rate at control 0.
        controls: lowest and highest control; infinite without a range.
        lags: True if it filters its control.
    """

    kind: str
    stiffness: float
    damping: float
    integrates: bool
    scale: float
    offset: float
    controls: tuple[float, float]
    lags: bool

    @property
    def speed_max(self) -> float:
        """Highest rate that it commands, m/s."""
        ends = [abs(self.scale * control + self.offset) for control in self.controls]
        return max(ends) if self.kind == "velocity" else math.inf


def servo_of(mujoco: Any, model: Any, motor: int) -> Servo | None:
    """Return the servo of an actuator on a tendon, or None if its force depends on its state in another way."""
    dynamics = mujoco.mjtDyn(model.actuator_dyntype[motor])
    integrates = dynamics == mujoco.mjtDyn.mjDYN_INTEGRATOR
    lags = dynamics in (mujoco.mjtDyn.mjDYN_FILTER, mujoco.mjtDyn.mjDYN_FILTEREXACT)
    affine = model.actuator_biastype[motor] == mujoco.mjtBias.mjBIAS_AFFINE
    fixed = model.actuator_gaintype[motor] == mujoco.mjtGain.mjGAIN_FIXED
    gear, gain = float(model.actuator_gear[motor, 0]), float(model.actuator_gainprm[motor, 0])
    b0, b1, b2 = (float(value) for value in model.actuator_biasprm[motor, :3])
    known = integrates or lags or dynamics == mujoco.mjtDyn.mjDYN_NONE
    if not (affine and fixed and known) or gear * gain == 0.0 or b1 > 0.0 or b2 > 0.0 or (integrates and b1 == 0.0):
        return None
    if b1 == b2 == 0.0:
        return None
    per = -gear * (b1 or b2)
    limited = bool(model.actuator_ctrllimited[motor])
    low, high = model.actuator_ctrlrange[motor].tolist() if limited else (-math.inf, math.inf)
    kind = "velocity" if integrates or b1 == 0.0 else "position"
    return Servo(kind, -b1 * gear**2, -b2 * gear**2, integrates, gain / per, b0 / per, (low, high), lags)


@dataclass
class Driven:
    """Winches and cables of a robot with servos.

    Attributes:
        winches: section of each cable, None for a cable with a motor.
        cable: section of all cables.
        warnings: assumed values.
    """

    winches: list[dict[str, Any] | None]
    cable: dict[str, Any]
    warnings: list[str] = field(default_factory=list)


def driven(model: Any, tendons: Sequence[int], servos: dict[int, Servo], high: Sequence[float], mass: float) -> Driven:
    """Return the winches of tendons, and their cables, which hardly stretch.

    Args:
        model: MuJoCo's model.
        tendons: tendon of each cable.
        servos: servo of each tendon that has one.
        high: largest tension of each cable, N.
        mass: mass of the platform, kg.
    """
    rows: list[dict[str, Any] | None] = []
    stiffness, damping, assumed, undamped = 0.0, 0.0, False, False
    for tendon, most in zip(tendons, high, strict=True):
        servo = servos.get(tendon)
        if servo is None:
            rows.append(None)
            continue
        length = float(model.tendon_length0[tendon])
        inertia = float(model.tendon_armature[tendon])
        assumed |= inertia <= 0.0
        inertia = inertia if inertia > 0.0 else _rounded(SHARE * mass)
        undamped |= servo.damping <= 0.0
        kv = servo.damping or servo.stiffness / POSITION_GAIN
        stiff = max(most / STRETCH, STIFFER * servo.stiffness * length)
        stiffness = max(stiffness, stiff)
        damping = max(damping, math.sqrt(stiff / length * inertia))
        loops = {"position_gain": servo.stiffness / kv} if servo.kind == "position" else {}
        if servo.integrates:
            loops = {"integral_gain": servo.stiffness}
        friction = {
            "viscous_friction": _first(model.tendon_damping[tendon]),
            "coulomb_friction": _first(model.tendon_frictionloss[tendon]),
        }
        rows.append(
            {"type": servo.kind, "drum_radius": RADIUS, "inertia": inertia}
            | {key: value for key, value in friction.items() if value > 0.0}
            | loops
            | {"velocity_gain": kv}
            | ({"speed_max": servo.speed_max} if 0.0 < servo.speed_max < math.inf else {})
            | {"torque_max": most * RADIUS}
        )
    cable = {"model": ACTUATED, "axial_stiffness": _rounded(stiffness), "damping": _rounded(damping)}
    text = (
        f"assumed, as MuJoCo's tendons do not stretch and have no drum: axial_stiffness {cable['axial_stiffness']:g} N "
        f"and damping {cable['damping']:g} N s/m of the cables"
    )
    mine = [f"inertia {_rounded(SHARE * mass):g} kg m^2 of the winches"] if assumed else []
    mine += [f"velocity gains of servos without kv, so that position_gain is {POSITION_GAIN:g} 1/s"] if undamped else []
    return Driven(rows, cable, ["; ".join([text, *mine])])


def _first(value: Any) -> float:
    """Return the value of a number or an array, whose further coefficients cdpr does not have."""
    return float(value.flat[0]) if hasattr(value, "flat") else float(value)


def _rounded(value: float) -> float:
    return float(f"{value:.2g}")
