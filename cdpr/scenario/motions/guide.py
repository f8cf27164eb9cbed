"""Guide of a platform with fewer than six degrees of freedom, and checks of motions against it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from cdpr.base import tolerances
from cdpr.base.fields import ZERO, Vector3
from cdpr.base.problems import Path
from cdpr.config.problems import exact
from cdpr.model import DOF_NAMES
from cdpr.model.robot import Array
from cdpr.scenario.orientation import Orientation

RATES = (
    ("velocity", slice(0, 3)),
    ("angular_velocity", slice(3, 6)),
    ("acceleration", slice(0, 3)),
    ("angular_acceleration", slice(3, 6)),
)


class Posed(Protocol):
    """Section with a pose, and possibly rates."""

    @property
    def position(self) -> Vector3:
        """Position of the platform's origin, m, world frame."""

    @property
    def orientation(self) -> Orientation:
        """Attitude."""


class Rated(Posed, Protocol):
    """Pose with rates, world axes; None if the motion chooses a rate."""

    @property
    def velocity(self) -> Vector3 | None:
        """Velocity of the origin, m/s."""

    @property
    def angular_velocity(self) -> Vector3 | None:
        """Angular velocity, rad/s."""

    @property
    def acceleration(self) -> Vector3 | None:
        """Acceleration of the origin, m/s^2."""

    @property
    def angular_acceleration(self) -> Vector3 | None:
        """Angular acceleration, rad/s^2."""


class Guide:
    """Directions that a guide holds.

    Attributes:
        held: (6,), True for each of x, y, z, rx, ry, rz that is held.
        free: description of the free directions.
        home: (3,), m, position at which the platform, or the tool, is held.
    """

    def __init__(
        self, dof: tuple[str, ...], home: Vector3, add_problem: Callable[[Path, str], None], tool: str | None = None
    ) -> None:
        self.held = np.array([name not in dof for name in DOF_NAMES])
        self.free = f"the robot moves along {', '.join(dof)} only"
        self.home = np.array(home)
        self.add_problem = add_problem
        self._what = "it" if tool is None else f"tool '{tool}'"

    def check(self, where: Path, point: Posed) -> None:
        """Report a pose or rates that violate the guide; missing parts do not."""
        if point.position is not None:
            self._position((*where, "position"), np.array(point.position))
        if point.orientation is not None:
            self.attitude((*where, "orientation"), point.orientation)
        self.rates(where, point)

    def attitude(self, path: Path, orientation: Orientation) -> None:
        """Report an attitude that violates the guide."""
        quaternion = orientation.quaternion()
        if (self.held[3:] & (np.abs(quaternion[1:]) > tolerances.HELD)).any():
            hint = "describe a platform that is held at a slant by its anchors"
            self.add_problem(path, f"{self.free}, so its attitude may differ from upright only about these; {hint}")

    def keeps(self, arm: Array) -> bool:
        """Return True if a point at `arm` (3,), m, world, from the origin respects the guide during rotations.

        Rotation about one axis moves it along a circle, out of all directions except the axis; about three axes, out of
        all.
        """
        held, turns = self.held[:3], ~self.held[3:]
        left = held & ~turns if turns.sum() == 1 else held
        radius = np.linalg.norm(np.cross(np.eye(3)[turns], arm), axis=1).max(initial=0.0)
        return bool(not left.any() or radius <= tolerances.HELD)

    def rates(self, where: Path, point: object) -> None:
        """Report rates in held directions."""
        for name, part in RATES:
            rate = np.array(getattr(point, name, None) or ZERO)
            if (self.held[part] & (rate != 0.0)).any():
                self.add_problem((*where, name), f"expected 0 in the held directions: {self.free}")

    def _position(self, path: Path, position: Array) -> None:
        away = self.held[:3] & (np.abs(position - self.home) > tolerances.HELD)
        if away.any():
            axes = ", ".join(f"{'xyz'[i]} = {exact(self.home[i])}" for i in np.flatnonzero(self.held[:3]))
            self.add_problem(path, f"{self.free}; the initial position holds {self._what} at {axes} (m)")
