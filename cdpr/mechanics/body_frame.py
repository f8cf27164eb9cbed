"""The frame in which rigid bodies are integrated.

For a free platform it lies at the centre of mass along the principal axes: there the inertia is diagonal and the centre
of mass moves by the force alone, so that every engine gets the same simple body whatever the robot's mass distribution.
A platform with a guide is integrated in the guide's coordinates, those of its origin.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cdpr.cables.tables import line_table
from cdpr.mechanics.guide import Guide
from cdpr.model import rotations
from cdpr.model.robot import Array, Robot
from cdpr.native.bind import bind

# Off-diagonal entries below this share of the trace are round-off of the input: the tensor counts as diagonal and the
# axes stay where they are.
DIAGONAL = 1e-14

# Principal axes point to this side, so that they do not depend on who computes them. It is no direction that a platform
# is likely to have an axis square to.
SIDE = np.array([1.0, 0.59, 0.37])


class BodyFrame:
    """A robot's platform as engines should build it.

    A free platform is described from its centre of mass and principal axes; one with a guide from its origin, along its
    own axes. A body state (13,) is laid out like a platform state, for the body frame in place of the platform's.

    Attributes:
        mass: kg.
        center: (3,) centre of mass in the body frame, m; zero for a free platform.
        moments: (3,) principal moments of inertia, kg m^2.
        axes: (4,) attitude of the principal axes in the body frame, w, x, y, z; 1, 0, 0, 0 for a free platform.
        line_table: (m, w), as `cdpr.cables.tables.line_table` returns it, with B_i in the body frame.
        anchors: (m, 6) of it, A_i in the world and B_i in the body frame, m.
        offset: (7,) from the platform's origin to that of the body frame in body axes (3), m, and the attitude of the
            body frame in the platform, w, x, y, z (4).
        guide: what holds the platform, None if it is free.
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

    @property
    def anchors(self) -> Array:
        """Anchors (m, 6), m."""
        return self.line_table[:, :6]


def principal_axes(inertia: Array) -> tuple[Array, Array]:
    """Principal moments (3,) and axes (3, 3), the columns of a rotation, of an inertia tensor (3, 3)."""
    off_diagonal = inertia - np.diag(np.diag(inertia))
    if np.abs(off_diagonal).max() <= DIAGONAL * np.trace(inertia):
        return np.diag(inertia).copy(), np.eye(3)
    moments, axes = np.linalg.eigh(inertia)
    axes *= np.where(SIDE @ axes < 0.0, -1.0, 1.0)
    axes[:, 0] *= np.sign(np.linalg.det(axes))  # they may be left-handed
    return moments, axes


def body_state(offset: ArrayLike, state: ArrayLike) -> Array:
    """Return the state of the body frame of a platform.

    Args:
        offset: (7,), as of `BodyFrame`.
        state: (13,), of the platform, laid out as `cdpr.model` says.

    Returns:
        (13,): position m, attitude w x y z, velocity m/s and angular velocity rad/s of the body frame, world axes.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> body = body_state(BodyFrame(robot).offset, state)
    """
    body = np.empty(13)
    bind("body_state", offset=_array(offset), state=_array(state), body=body)()
    return body


def platform_state(offset: ArrayLike, body: ArrayLike) -> Array:
    """Return the state of the platform of a body frame: the inverse of `body_state`.

    Args:
        offset: (7,), as of `BodyFrame`.
        body: (13,), of the body frame.

    Returns:
        (13,), of the platform, laid out as `cdpr.model` says.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> state = platform_state(BodyFrame(robot).offset, body)
    """
    state = np.empty(13)
    bind("platform_state", offset=_array(offset), body=_array(body), state=state)()
    return state


def wrench_on_body(
    line_table: Array, offset: ArrayLike, tension: ArrayLike, external: ArrayLike, body: ArrayLike
) -> Array:
    """Return the wrench of cables and of what else acts on a body.

    Args:
        line_table: (m, w), of `BodyFrame`.
        offset: (7,), likewise.
        tension: (m,) N.
        external: (6,) N and N m, at the platform's origin, world axes.
        body: (13,), state of the body frame.

    Returns:
        (6,): force N and moment about the body frame's origin N m, world axes.

    Raises:
        ValueError: The shapes do not match.

    Example:
        >>> wrench = wrench_on_body(frame.line_table, frame.offset, tension, np.zeros(6), body)
    """
    applied = np.empty(6)
    given = {"offset": offset, "tension": tension, "external": external, "body": body}
    arrays = {name: _array(value) for name, value in given.items()}
    bind("applied_wrench", lines=line_table, **arrays, applied=applied)()
    return applied


def _array(given: ArrayLike) -> Array:
    return np.ascontiguousarray(given, dtype=np.float64)
