"""Conversion of inertias: about another point, or with moments that are zero in the source."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cdpr.model.robot import Array
from cdpr.scenario.robot_schema import Inertia, of_a_body, tensor

NAMES = ("ixx", "iyy", "izz")
# Factor of a solid sphere; its radius is that of the platform's anchors. Replaces a missing inertia.
BALL = 0.4


def about_centre(inertia: Inertia, mass: float, centre: Sequence[float]) -> Inertia:
    """Return the inertia about the centre of mass, kg m^2, of an inertia about the origin.

    Steiner's theorem: I_G = I_O - m (c.c 1 - c c^T).

    Args:
        inertia: inertia about the origin, kg m^2.
        mass: kg.
        centre: (3,), centre of mass relative to the origin, m.
    """
    c = np.array(centre, dtype=float)
    return six(np.array(tensor(inertia)) - mass * (c @ c * np.eye(3) - np.outer(c, c)))


def six(tensor_: Array) -> Inertia:
    """Return ixx, iyy, izz, ixy, ixz, iyz of a tensor (3, 3)."""
    I = tensor_.tolist()  # noqa: E741 - what everybody calls it
    return (I[0][0], I[1][1], I[2][2], I[0][1], I[0][2], I[1][2])


def filled(inertia: Inertia, mass: float, anchors: Array, turning: bool) -> tuple[Inertia | None, str]:
    """Return a valid inertia and a note on substituted values; None if the platform does not rotate.

    Zero moments are replaced by the largest given one, which keeps the inertia valid. If all are zero, those of a
    sphere through the anchors are used.

    Args:
        inertia: inertia about the centre of mass, kg m^2.
        mass: kg.
        anchors: (m, 3), platform axes, relative to the centre of mass, m.
        turning: False if the platform does not rotate.

    Raises:
        ValueError: if the inertia is invalid for another reason.
    """
    if not turning:
        return None, ""
    try:
        return of_a_body(inertia), ""
    except ValueError:
        if all(value > 0.0 for value in inertia[:3]):
            raise
    zero = [name for name, value in zip(NAMES, inertia, strict=False) if value == 0.0]
    if len(zero) == 3:
        radius = float(np.sqrt((anchors**2).sum(axis=1).mean())) or 0.1
        largest, why = BALL * mass * radius**2, f"that of a ball of {radius:.3g} m"
    else:
        largest, why = max(inertia[:3]), "the largest of the others"
    xx, yy, zz = (value or largest for value in inertia[:3])
    return of_a_body((xx, yy, zz, *inertia[3:])), f"inertia: {', '.join(zero)} was 0, filled with {largest:.6g}, {why}"
