"""Joints of CASPR: how their coordinates q make a pose and its rates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin
from typing import Any

import numpy as np

from cdpr.formats.read.xml import Element
from cdpr.model import rotations
from cdpr.model.robot import Array

# What each moves along and about, in the order of its coordinates, and how three angles make a rotation.
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
    "U_XY": "turns about two axes, for which there is no guide here",
    "U_YZ": "turns about two axes, for which there is no guide here",
    "U_XZ": "turns about two axes, for which there is no guide here",
    "R_AXIS": "turns about an axis of its own; guides here are along and about the world's axes",
    "S_QUATERNION": QUATERNION,
    "SPHERICAL": QUATERNION,
    "SPATIAL_QUATERNION": QUATERNION,
    "SPATIAL": QUATERNION,
    "P_AXIS": "moves along an axis of its own; guides here are along and about the world's axes",
}


@dataclass(frozen=True)
class Joint:
    """A joint between the world and the body.

    Attributes:
        type: as CASPR has it.
        dof: directions in which it moves, as many as coordinates.
        at: (3,), where the parent puts it, m.
        initial: its coordinates, m and rad.
    """

    type: str
    dof: tuple[str, ...]
    at: tuple[float, float, float]
    initial: tuple[float, ...]

    @property
    def turns(self) -> int:
        """About how many axes it turns."""
        return sum(name.startswith("r") for name in self.dof)

    def pose(self, q: Sequence[float]) -> dict[str, Any]:
        """Return position and orientation, as a file has them, of coordinates q."""
        along, angles = self.parts(q)
        position = [a + b for a, b in zip(self.at, along.tolist(), strict=True)]
        if not angles.any():
            return {"position": position}
        if self.turns == 3 and self.type != FIXED:
            return {"position": position, "orientation": {"euler": {"angles": angles.tolist(), "order": "XYZ"}}}
        return {"position": position, "orientation": {"rpy": angles.tolist()}}

    def parts(self, q: Sequence[float]) -> tuple[Array, Array]:
        """Return what coordinates, or their rates, make along the axes (3,), and about them (3,)."""
        both = dict(zip(self.dof, q, strict=True))
        return (
            np.array([both.get(name, 0.0) for name in AXES]),
            np.array([both.get(f"r{name}", 0.0) for name in AXES]),
        )

    def quaternion(self, q: Sequence[float]) -> Array:
        """Return the attitude (4,) of coordinates q."""
        angles = self.parts(q)[1]
        return rotations.from_rpy(*angles) if self.type == FIXED else rotations.from_euler(angles, "XYZ")

    def turning(self, q: Sequence[float], rate: Sequence[float], more: Sequence[float]) -> tuple[Array, Array]:
        """Return angular velocity and acceleration (3,), world axes, of coordinates, their rates and second rates.

        Of R = Rx(a) Ry(b) Rz(c) the velocity in world axes is a' x + b' Rx y + c' Rx Ry z, each axis turned by what
        stands before it; of fixed axes R = Rz(c) Ry(b) Rx(a) likewise from the other end.
        """
        angles, rates, seconds = (self.parts(each)[1] for each in (q, rate, more))
        order = (2, 1, 0) if self.type == FIXED else (0, 1, 2)
        speed, change, R = np.zeros(3), np.zeros(3), np.eye(3)
        for k in order:
            axis = R[:, k]  # turns with `speed` of all before it
            change = change + seconds[k] * axis + rates[k] * np.cross(speed, axis)
            speed = speed + rates[k] * axis
            R = R @ _about(k, angles[k])
        return speed, change


def joint(link: Element) -> Joint:
    """Return the joint of a link. Raises FormatError where it is none that our robots have."""
    element, parent = link.child("joint"), link.child("parent")
    type_ = element.attribute("type")
    if type_ in REFUSED:
        raise element.wrong(f"joint {type_} {REFUSED[type_]}; there are {', '.join(KINDS)}")
    if type_ not in KINDS:
        raise element.wrong(f"joint type '{type_}' is not known; there are {', '.join(KINDS)}")
    if element.attributes.get("actuated", "false").strip().lower() == "true":
        raise element.wrong("the joint is actuated itself: platforms here are moved by their cables alone")
    if (number := parent.child("num").number()) != 0.0:
        raise parent.wrong(f"the parent is link {number:g}; the world, 0, is expected of a single body")
    x, y, z = parent.child("location").vector(3)
    dof = KINDS[type_]
    said = element.attributes.get("q_initial", "").strip()
    initial = element.attribute_vector("q_initial", len(dof)) if said else [0.0] * len(dof)
    return Joint(type_, dof, (x, y, z), tuple(initial))


def _about(axis: int, angle: float) -> Array:
    c, s = cos(angle), sin(angle)
    R = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[i, i] = R[j, j] = c
    R[i, j], R[j, i] = -s, s
    return R
