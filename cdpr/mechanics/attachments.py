"""Rigid bodies attached to the platform: mass, centre of mass and inertia of both together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.model import Platform, Robot
from cdpr.model.robot import Array


@dataclass(frozen=True, eq=False)
class Attachment:
    """Rigid body that is attached to the platform for some time.

    Attributes:
        mass: kg.
        center: (3,) its centre of mass from the platform's origin [m], in platform axes.
        inertia: (3, 3) about its centre of mass [kg m^2], in platform axes; zeros for a point mass.
        known: True if controller and tension solver account for it.
    """

    mass: float
    center: Array
    inertia: Array
    known: bool = False


def with_attachments(robot: Robot, bodies: Sequence[Attachment]) -> Robot:
    """Return a robot whose platform has these bodies attached.

    Mass, centre of mass and inertia about it are those of the compound body (Steiner's theorem).

    Args:
        robot: robot without them.
        bodies: attached bodies.

    Returns:
        The robot with the compound platform; `robot` itself without bodies.

    Example:
        >>> import cdpr
        >>> body = Attachment(30.0, np.array([0.0, 0.0, -0.5]), np.zeros((3, 3)))
        >>> robot = cdpr.load_robot("caroca")
        >>> with_attachments(robot, [body]).platform.mass - robot.platform.mass
        30.0
    """
    if not bodies:
        return robot
    own = robot.platform
    parts = [(own.mass, own.center_of_mass, own.inertia), *((each.mass, each.center, each.inertia) for each in bodies)]
    mass = sum(part[0] for part in parts)
    center = sum((part[0] * part[1] for part in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for m, c, J in parts:
        x, y, z = c - center
        # written out because exported FMUs perform the same operations
        inertia += J + m * ((x * x + y * y + z * z) * np.eye(3) - np.outer([x, y, z], [x, y, z]))
    platform = Platform(mass, inertia, center, shape=own.shape, colour=own.colour, tools=own.tools)
    return robot.replace(platform=platform)
