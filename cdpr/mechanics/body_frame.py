"""Frame in which rigid bodies are integrated.

The frame of a free platform has its origin at the centre of mass and its axes along the principal axes. There, the
inertia is diagonal, and the force alone moves the centre of mass. So every engine integrates the same simple body,
whatever the mass distribution of the robot. A platform with a guide is integrated in the coordinates of the guide,
those of the platform's origin.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.cables.tables import line_table
from cdpr.mechanics.guide import Guide
from cdpr.model import rotations
from cdpr.model.robot import Array, Robot
from cdpr.native.arrays import reals
from cdpr.native.bind import bind

# Off-diagonal entries below this share of the trace are round-off of the input: the tensor is treated as diagonal.
DIAGONAL = 1e-14

# The principal axes have a positive component along this direction, so that their signs do not depend on the solver. A
# principal axis of a real platform is unlikely to be perpendicular to it.
SIDE = np.array([1.0, 0.59, 0.37])


class BodyFrame:
    """Platform of a robot as the engines build it.

    A free platform is described in its centre of mass and principal axes. A platform with a guide is described in its
    own frame. A body state (13,) has the layout of a platform state, for the body frame.

    Attributes:
        mass: mass [kg].
        center: (3,) centre of mass in the body frame [m], zero for a free platform.
        moments: (3,) principal moments of inertia [kg m^2].
        axes: (4,) attitude of the principal axes in the body frame, w, x, y, z; 1, 0, 0, 0 for a free platform.
        line_table: (m, w) table of `cdpr.cables.tables.line_table`, with B_i in the body frame.
        anchors: (m, 6) anchors A_i in the world frame and B_i in the body frame [m].
        offset: (7,) vector from the platform's origin to the origin of the body frame in body axes (3) [m], and
            attitude of the body frame in the platform frame, w, x, y, z (4).
        guide: guide of the platform, None if it is free.
    """

    def __init__(self, robot: Robot) -> None:
        platform = robot.platform
        moments, axes = principal_axes(platform.inertia)
        attitude = rotations.from_matrix(axes)
        self.mass = platform.mass
        self.moments = moments
        self.line_table = line_table(robot).copy()
        if robot.n < 6:
            self.guide: Guide | None = Guide(robot)
            self.center, self.axes = platform.center_of_mass.copy(), attitude
            self.offset = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        else:
            self.guide = None
            self.center, self.axes = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
            self.line_table[:, 3:6] = (robot.anchors[:, 3:] - platform.center_of_mass) @ axes
            self.offset = np.concatenate([axes.T @ platform.center_of_mass, attitude])

    def refill(self, robot: Robot) -> None:
        """Take the platform of another robot with the same geometry into the same arrays."""
        other = BodyFrame(robot)
        self.mass = other.mass
        for name in ("moments", "line_table", "center", "axes", "offset"):
            getattr(self, name)[:] = getattr(other, name)

    @property
    def anchors(self) -> Array:
        """(m, 6) anchors [m]."""
        return self.line_table[:, :6]


def principal_axes(inertia: Array) -> tuple[Array, Array]:
    """Return the principal moments (3,) of an inertia tensor (3, 3) and its axes (3, 3), the columns of a rotation."""
    off_diagonal = inertia - np.diag(np.diag(inertia))
    if np.abs(off_diagonal).max() <= DIAGONAL * np.trace(inertia):
        return np.diag(inertia).copy(), np.eye(3)
    moments, axes = np.linalg.eigh(inertia)
    axes *= np.where(SIDE @ axes < 0.0, -1.0, 1.0)
    axes[:, 0] *= np.sign(np.linalg.det(axes))  # the axes of eigh may be left-handed
    return moments, axes


def body_state(offset: ArrayLike, state: ArrayLike) -> Array:
    """Return the body state of a platform state.

    Args:
        offset: (7,) offset of `BodyFrame`.
        state: (13,) platform state with the layout of `cdpr.model`.

    Returns:
        (13,) position [m], quaternion w, x, y, z, velocity [m/s] and angular velocity [rad/s] of the body frame, in
            world
        axes.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca")
        >>> body_state(BodyFrame(robot).offset, [*robot.home, *[0.0] * 6]).shape
        (13,)
    """
    body = np.empty(13)
    bind("body_state", **reals(offset=offset, state=state), body=body)()
    return body


def platform_state(offset: ArrayLike, body: ArrayLike) -> Array:
    """Return the platform state of a body state, the inverse of `body_state`.

    Args:
        offset: (7,) offset of `BodyFrame`.
        body: (13,) body state.

    Returns:
        (13,) platform state with the layout of `cdpr.model`.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca")
        >>> state, offset = np.array([*robot.home, *[0.0] * 6]), BodyFrame(robot).offset
        >>> bool(np.allclose(platform_state(offset, body_state(offset, state)), state))
        True
    """
    state = np.empty(13)
    bind("platform_state", **reals(offset=offset, body=body), state=state)()
    return state


def wrench_on_body(
    line_table: Array, offset: ArrayLike, tension: ArrayLike, external: ArrayLike, body: ArrayLike
) -> Array:
    """Return the wrench of the cables and the external wrench on a body.

    Args:
        line_table: (m, w) line table of `BodyFrame`.
        offset: (7,) offset of `BodyFrame`.
        tension: (m,) tensions [N].
        external: (6,) external force [N] and moment [N m] at the platform's origin, in world axes.
        body: (13,) body state.

    Returns:
        (6,) force [N] and moment about the origin of the body frame [N m], in world axes.

    Raises:
        ValueError: if the shapes do not match.

    Example:
        >>> import cdpr
        >>> robot = cdpr.load_robot("caroca")
        >>> frame = BodyFrame(robot)
        >>> body = body_state(frame.offset, [*robot.home, *[0.0] * 6])
        >>> wrench_on_body(frame.line_table, frame.offset, robot.tension_min, np.zeros(6), body).shape
        (6,)
    """
    applied = np.empty(6)
    arrays = reals(lines=line_table, offset=offset, tension=tension, external=external, body=body)
    bind("applied_wrench", **arrays, applied=applied)()
    return applied
