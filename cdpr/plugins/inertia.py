"""Checks that a physics engine simulates the specified body."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cdpr.base.errors import CdprError, PluginError
from cdpr.mechanics.body_frame import BodyFrame
from cdpr.model.robot import Array
from cdpr.model.rotations import matrix

# Relative tolerance of an engine's values: a few operations in float64, such as the rotation of a tensor.
ROUND_OFF = 1e-12
# The same for single-precision engines.
SINGLE_ROUND_OFF = 1e-6

REMEDY = "choose another backend, such as simulation.backend: reference"


class Inertia(NamedTuple):
    """Inertia of a body as stored by an engine.

    Attributes:
        mass: kg.
        inertia: (3, 3), tensor about the centre of mass, axes of the body frame, kg m^2.
        center: (3,), centre of mass in the body frame, m; None if the engine does not store it.
        tolerance: relative tolerance of the values: `SINGLE_ROUND_OFF` in single precision.
    """

    mass: float
    inertia: Array
    center: Array | None = None
    tolerance: float = ROUND_OFF


def turned(moments: Array, axes: Array) -> Array:
    """Return the tensor (3, 3) of principal moments (3,), kg m^2, along axes with the attitude w, x, y, z (4,)."""
    R = matrix(np.asarray(axes, dtype=np.float64))
    tensor: Array = R * moments @ R.T
    return tensor


def check_range(frame: BodyFrame, engine: str, smallest: float, slimmest: float) -> None:
    """Raise CdprError if an engine does not simulate such a body correctly.

    Args:
        frame: the body.
        engine: its name, for the message.
        smallest: smallest supported mass, kg, and principal moment, kg m^2.
        slimmest: smallest supported radius of gyration, m, if the body rotates.
    """
    for key, what, value, unit in (
        ("mass", "mass", frame.mass, "kg"),
        ("inertia", "smallest principal moment", float(np.min(frame.moments)), "kg m^2"),
    ):
        if not value >= smallest:
            raise CdprError(
                f"robot.platform.{key}: the {what} is {value:.6g} {unit}, and {engine} does not move a body correctly "
                f"below {smallest:.3g} {unit}: use a larger value, or {REMEDY}"
            )
    guide = frame.guide
    if guide is None or guide.spherical:
        moment = float(np.min(frame.moments))
    elif guide.hinge is not None:
        moment = float(turned(frame.moments, frame.axes)[guide.hinge, guide.hinge])
    else:
        return
    if not moment >= slimmest**2 * frame.mass:
        raise CdprError(
            f"robot.platform.inertia: a moment of {moment:.6g} kg m^2 with a mass of {frame.mass:.6g} kg is a radius "
            f"of gyration of {np.sqrt(moment / frame.mass):.3g} m, and {engine} rounds the motion of bodies below "
            f"{slimmest:g} m too coarsely: use a larger inertia, or {REMEDY}"
        )


def check_held(frame: BodyFrame, held: Inertia, engine: str) -> None:
    """Raise PluginError if an engine's body differs from the frame's."""
    share = held.tolerance
    given = turned(frame.moments, frame.axes)
    _compare("mass", "mass", "kg", np.array([frame.mass]), np.array([held.mass]), share * frame.mass, engine)
    moment = float(np.max(frame.moments))
    _compare("inertia", "inertia tensor", "kg m^2", given, np.asarray(held.inertia), share * moment, engine)
    if held.center is not None:
        size = float(np.abs(frame.center).max()) + float(np.sqrt(moment / frame.mass))
        _compare("center_of_mass", "centre of mass", "m", frame.center, np.asarray(held.center), share * size, engine)


def _compare(key: str, what: str, unit: str, given: Array, held: Array, tolerance: float, engine: str) -> None:
    if held.shape == given.shape and (np.abs(held - given) <= tolerance).all():  # also if NaN
        return
    raise PluginError(
        f"robot.platform.{key}: {engine} holds the {what} {_numbers(held)} {unit} in place of {_numbers(given)} {unit} "
        f"(axes of the body that the engine integrates), so its motion would be wrong: {REMEDY}, "
        "and report this to the author of the backend"
    )


def _numbers(values: Array) -> str:
    flat = np.ravel(values)
    return f"{flat[0]:.12g}" if flat.size == 1 else "[" + ", ".join(f"{value:.12g}" for value in flat) + "]"
