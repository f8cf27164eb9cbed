"""Disturbances of sensors during a run: lost measurements, steps of the bias, and mounts that move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.model import rotations
from cdpr.model.robot import Array


@dataclass(frozen=True)
class Disturbance:
    """Change of a sensor at a sample; it acts on later measurements.

    Attributes:
        lost: 1 at the beginning and -1 at the end of a time in which all measurements are lost.
        bias: values that are added to the bias of each component of `quantity`, or one value for all.
        quantity: key of the quantity; "" for the first.
        position: (3,) m, movement of the mount, axes of the body that carries it.
        rotation: (3,) rad, rotation vector of the mount about its own place, likewise.
    """

    lost: int = 0
    bias: Sequence[float] = ()
    quantity: str = ""
    position: Sequence[float] = (0.0, 0.0, 0.0)
    rotation: Sequence[float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Mount:
    """Mount of a sensor on its body, live.

    Attributes:
        place: (3,), m, axes of the body.
        axes: (4,), attitude, a quaternion w, x, y, z, or (k, 3), directions of rays; of a sensor without axes (0, 3).
    """

    place: Array
    axes: Array

    @property
    def arrays(self) -> list[Array]:
        """Arrays that contain place and axes, not empty."""
        wholes = (each if each.base is None else each.base for each in (self.place, self.axes))
        return [each for each in wholes if each.size]

    def move(self, position: Sequence[float], rotation: Sequence[float]) -> None:
        """Move the place by `position` (3,), m, and rotate the axes by the rotation vector (3,), rad."""
        self.place[:] += np.asarray(position)
        angle = float(np.linalg.norm(rotation))
        if angle == 0.0:
            return
        turn = rotations.from_axis_angle(np.asarray(rotation) / angle, angle)
        if self.axes.shape == (4,):
            self.axes[:] = rotations.multiply(turn, self.axes)
        else:
            self.axes[:] = self.axes @ rotations.matrix(turn).T
