"""Model of robot, platform and cables, and the mathematics without further dependencies.

Conventions, valid everywhere:

- SI units and radians. World z points up. Gravity is a value of the scenario, not of the robot.
- Cable i runs from `A_i`, its anchor on the fixed frame (world axes), to `B_i`, its anchor on the platform (platform
  axes). With the platform at position p and attitude R, the cable vector is `l_i = A_i - (p + R B_i)`, its length
  `|l_i|` and its direction the unit vector `u_i`, from platform to frame. A positive tension pulls the platform along
  `+u_i`.
- Wrench matrix `W`, shape (6, m), column i `[u_i ; (R B_i) x u_i]`. `W @ tension` is the wrench of the cables on the
  platform: force, then moment about the platform's origin, both in world axes.
- State, shape (13,): position of the platform's origin (3, world), attitude as unit quaternion w, x, y, z (platform to
  world), velocity of the origin (3, world), angular velocity (3, world).
- Desired, shape (19,): the same 13, then acceleration of the origin (3, world) and angular acceleration (3, world).
- The centre of mass may lie off the origin. Inertia is about the centre of mass, platform axes, full tensor.
- Roll, pitch, yaw are fixed-axis: R = Rz(yaw) Ry(pitch) Rx(roll). Euler angles come with their order, as in scipy:
  "XYZ" about moving axes, R = Rx Ry Rz (thesis 2.1, whose text contradicts it), "xyz" about fixed axes,
  R = Rz Ry Rx.
- Where forces and moments must be compared, moments are divided by the robot's characteristic length, the root mean
  square of `|B_i|`.

Example:
    >>> import cdpr
    >>> cdpr.model.rotations.from_rpy(0.0, 0.0, 0.0)
    array([1., 0., 0., 0.])
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.model.robot import DOF_NAMES, Cable, Platform, Robot, Winch
from cdpr.model.shapes import Box, Cylinder, Frame, Mesh, Sphere

if TYPE_CHECKING:
    from cdpr.model import rotations as rotations
else:  # loaded when first used
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__)

__all__ = ["DOF_NAMES", "Box", "Cable", "Cylinder", "Frame", "Mesh", "Platform", "Robot", "Sphere", "Winch"]
