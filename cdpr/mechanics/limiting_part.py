"""Part of a robot whose stiffness, damping or friction limits the step of a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array

ALIKE = 0.99  # share of the largest part from which others are equal: those of a symmetric robot


@dataclass(frozen=True, eq=False)
class Resistance:
    """Part of a robot that adds stiffness s v v^T and damping d v v^T to an oscillator.

    Attributes:
        cable: index of its cable.
        name: key of the robot file, or name of the part.
        direction: (k,) v, by the coordinates of the oscillator.
        stiffness: s [N/m].
        damping: d [N s/m].
    """

    cable: int
    name: str
    direction: Array
    stiffness: float = 0.0
    damping: float = 0.0

    def matrix(self, h: float) -> Array:
        """Return its part (k, k) of h^2 K / 4 + h C / 2 [kg], for a step h [s]."""
        size = 0.25 * h * h * self.stiffness + 0.5 * h * self.damping
        return np.asarray(size * np.outer(self.direction, self.direction))


def limiting_part(robot: Robot, M: Array, parts: Sequence[Resistance], h: float) -> str:
    """Return the part that limits a step, and the inertia against which it acts; "" if it is unknown.

    A semi-implicit step is stable as long as v^T (h^2 K / 4 + h C / 2) v < v^T M v for each motion v, for symmetric K
    and C. The part is the one with the largest share of the left side, in the motion with the largest ratio.

    Args:
        robot: the robot.
        M: (k, k) inertia of the platform, by its degrees of freedom, and of drums [kg].
        parts: resistances.
        h: step [s].
    """
    with np.errstate(all="ignore"):  # numbers out of range
        own = [each.matrix(h) for each in parts]
        try:
            inverse = np.linalg.inv(np.linalg.cholesky(M))
            motion = inverse.T @ np.linalg.eigh(inverse @ sum(own, np.zeros_like(M)) @ inverse.T)[1][:, -1]
        except np.linalg.LinAlgError:
            return ""
        shares = [float(motion @ each @ motion) for each in own]
    if not shares or not np.isfinite(shares).all():
        return ""
    first = int(np.argmax(shares))
    part = parts[first]
    alike = len({each.cable for each, share in zip(parts, shares, strict=True) if share >= ALIKE * shares[first]}) - 1
    inertia = motion * (M @ motion)
    on = "the platform" if inertia[: robot.n].sum() >= inertia[robot.n :].sum() else "the inertia of its winch"
    more = f" (and {alike} more alike)" if alike else ""
    return f"cable '{robot.cables[part.cable].name}'{more} limits it by {part.name}, against {on}"
