"""CASPR joints: conversion of joint coordinates q into poses and velocities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin
from typing import Any

import numpy as np

from cdpr.formats.read.xml import Element
from cdpr.model import rotations
from cdpr.model.robot import Array

# Direction of each joint's coordinates, in order.
KINDS: dict[str, tuple[str, ...]] = {
    "R_X": ("rx",),
    "R_Y": ("ry",),
    "R_Z": ("rz",),
    "P_X": ("x",),
    "P_Y": ("y",),
    "P_Z": ("z",),
    "P_XY": ("x", "y"),
    "P_XZ": ("x", "z"),
    "P_YZ": ("y", "z"),
    "T_XYZ": ("x", "y", "z"),
    "PLANAR_XY": ("x", "y", "rz"),
    "PLANAR_XZ": ("x", "z", "ry"),
    "PLANAR_YZ": ("y", "z", "rx"),
    "S_EULER_XYZ": ("rx", "ry", "rz"),
    "S_FIXED_XYZ": ("rx", "ry", "rz"),
    "SPATIAL_EULER_XYZ": ("x", "y", "z", "rx", "ry", "rz"),
}
FIXED = "S_FIXED_XYZ"
AXES = ("x", "y", "z")
QUATERNION = "has a quaternion among its coordinates; the same joint with three angles is known"
REFUSED = {
    "U_XY": "rotates about two axes, for which there is no guide",
    "U_YZ": "rotates about two axes, for which there is no guide",
    "U_XZ": "rotates about two axes, for which there is no guide",
    "R_AXIS": "rotates about another axis; guides support only world axes",
    "S_QUATERNION": QUATERNION,
    "SPHERICAL": QUATERNION,
    "SPATIAL_QUATERNION": QUATERNION,
    "SPATIAL": QUATERNION,
    "P_AXIS": "moves along another axis; guides support only world axes",
}


@dataclass(frozen=True)
class Joint:
    """Joint between the world and the body.

    Attributes:
        type: name in CASPR.
        dof: directions of motion, one per coordinate.
        at: (3,), position in the parent, m.
        initial: initial coordinates, m and rad.
    """

    type: str
    dof: tuple[str, ...]
    at: tuple[float, float, float]
    initial: tuple[float, ...]

    @property
    def turns(self) -> int:
        """Number of rotation axes."""
        return sum(name.startswith("r") for name in self.dof)

    def pose(self, q: Sequence[float]) -> dict[str, Any]:
        """Return position and orientation at coordinates q, in the format of robot files."""
        along, angles = self.parts(q)
        position = [a + b for a, b in zip(self.at, along.tolist(), strict=True)]
        if not angles.any():
            return {"position": position}
        if self.turns == 3 and self.type != FIXED:
            return {"position": position, "orientation": {"euler": {"angles": angles.tolist(), "order": "XYZ"}}}
        return {"position": position, "orientation": {"rpy": angles.tolist()}}

    def parts(self, q: Sequence[float]) -> tuple[Array, Array]:
        """Return the translational (3,) and rotational (3,) components of coordinates or their rates."""
        both = dict(zip(self.dof, q, strict=True))
        return (
            np.array([both.get(name, 0.0) for name in AXES]),
            np.array([both.get(f"r{name}", 0.0) for name in AXES]),
        )

    def quaternion(self, q: Sequence[float]) -> Array:
        """Return the attitude quaternion (4,) at coordinates q."""
        angles = self.parts(q)[1]
        return rotations.from_rpy(*angles) if self.type == FIXED else rotations.from_euler(angles, "XYZ")

    def turning(self, q: Sequence[float], rate: Sequence[float], more: Sequence[float]) -> tuple[Array, Array]:
        """Return angular velocity and acceleration (3,), world frame, of coordinates and their derivatives.

        For R = Rx(a) Ry(b) Rz(c), the angular velocity in the world frame is a' x + b' Rx y + c' Rx Ry z: each axis is
        rotated by the preceding rotations. For fixed axes, R = Rz(c) Ry(b) Rx(a), the order is reversed.

        Args:
            q: coordinates, m and rad.
            rate: their first derivatives.
            more: their second derivatives.
        """
        angles, rates, seconds = (self.parts(each)[1] for each in (q, rate, more))
        order = (2, 1, 0) if self.type == FIXED else (0, 1, 2)
        speed, change, R = np.zeros(3), np.zeros(3), np.eye(3)
        for k in order:
            axis = R[:, k]  # moves with the angular velocity of all preceding axes
            change = change + seconds[k] * axis + rates[k] * np.cross(speed, axis)
            speed = speed + rates[k] * axis
            R = R @ _about(k, angles[k])
        return speed, change


def joint(link: Element) -> Joint:
    """Return the joint of a link.

    Raises:
        FormatError: if robots of cdpr do not support it.
    """
    element, parent = link.child("joint"), link.child("parent")
    type_ = element.attribute("type")
    if type_ in REFUSED:
        raise element.wrong(f"joint {type_} {REFUSED[type_]}; allowed: {', '.join(KINDS)}")
    if type_ not in KINDS:
        raise element.wrong(f"joint type '{type_}' is unknown; allowed: {', '.join(KINDS)}")
    if element.attributes.get("actuated", "false").strip().lower() == "true":
        raise element.wrong("the joint is actuated: only cables may move a platform")
    if (number := parent.child("num").number()) != 0.0:
        raise parent.wrong(f"expected the world, 0, as the parent of a single body, got link {number:g}")
    x, y, z = parent.child("location").vector(3)
    dof = KINDS[type_]
    text = element.attributes.get("q_initial", "").strip()
    initial = element.attribute_vector("q_initial", len(dof)) if text else [0.0] * len(dof)
    return Joint(type_, dof, (x, y, z), tuple(initial))


def _about(axis: int, angle: float) -> Array:
    c, s = cos(angle), sin(angle)
    R = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[i, i] = R[j, j] = c
    R[i, j], R[j, i] = -s, s
    return R
