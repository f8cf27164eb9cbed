"""What holds some directions of a platform, and whether a motion stays in it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from cdpr import tolerances
from cdpr.fields import ZERO, Vector3
from cdpr.model import DOF_NAMES
from cdpr.model.robot import Array
from cdpr.problems import Path
from cdpr.scenario.orientation import Orientation
from cdpr.scenario.problems import exact

RATES = (
    ("velocity", slice(0, 3)),
    ("angular_velocity", slice(3, 6)),
    ("acceleration", slice(0, 3)),
    ("angular_acceleration", slice(3, 6)),
)


class Posed(Protocol):
    """A section with a pose; it may hold rates besides."""

    @property
    def position(self) -> Vector3:
        """Position of the platform's origin, m, world."""

    @property
    def orientation(self) -> Orientation:
        """Attitude."""


class Rated(Posed, Protocol):
    """A pose with its rates, world axes; None where a rate is left to the motion."""

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
    """The directions that a guide holds.

    Attributes:
        held: which of x, y, z, rx, ry, rz it holds, (6,).
        free: words that say which directions are free.
        home: (3,) position, m, at which it holds the platform, or the tool of that name.
    """

    def __init__(
        self, dof: tuple[str, ...], home: Vector3, say: Callable[[Path, str], None], tool: str | None = None
    ) -> None:
        self.held = np.array([name not in dof for name in DOF_NAMES])
        self.free = f"the robot moves along {', '.join(dof)} only"
        self.home = np.array(home)
        self.say = say
        self._what = "it" if tool is None else f"tool '{tool}'"

    def check(self, where: Path, point: Posed) -> None:
        """Report where a pose, or its rates, leave the guide; what is left out does not."""
        if point.position is not None:
            self._position((*where, "position"), np.array(point.position))
        if point.orientation is not None:
            self.attitude((*where, "orientation"), point.orientation)
        self.rates(where, point)

    def attitude(self, path: Path, orientation: Orientation) -> None:
        """Report an attitude that it does not allow."""
        quaternion = orientation.quaternion()
        if (self.held[3:] & (np.abs(quaternion[1:]) > tolerances.HELD)).any():
            hint = "describe a platform that is held at a slant by its anchors"
            self.say(path, f"{self.free}, so its attitude may differ from upright only about these; {hint}")

    def keeps(self, arm: Array) -> bool:
        """Whether a point, (3,), m, world, from the origin stays where the guide holds it when the platform turns.

        About one axis it goes along a circle, which leaves every direction but the axis; about three, all.
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
                self.say((*where, name), f"{self.free}; zero is expected in the held directions")

    def _position(self, path: Path, position: Array) -> None:
        away = self.held[:3] & (np.abs(position - self.home) > tolerances.HELD)
        if away.any():
            axes = ", ".join(f"{'xyz'[i]} = {exact(self.home[i])}" for i in np.flatnonzero(self.held[:3]))
            self.say(path, f"{self.free}; the initial position holds {self._what} at {axes} (m)")
