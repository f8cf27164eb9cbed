"""Pulley that swivels about the line of its arriving cable.

The cable arrives along the axis a, touches the groove at A, the anchor on the frame, lies on it over the wrap angle
beta and leaves tangentially for P on the platform. The bearing lets the pulley turn about the line through A along a,
so that its plane follows the cable. In that plane, with x away from the line and z along a, both from A, the centre is
at (r, 0) and P at (x, z), x >= 0. From the centre C the tangent to P has the length f = sqrt((x - r)^2 + z^2 - r^2),
and with (c, z) = P - C

    sin beta = (f c + r z) / (c^2 + z^2),   cos beta = (f z - r c) / (c^2 + z^2),
    E = A + r (1 - cos beta) e_x + r sin beta a,   length = r beta + f.

Pott, Cable-Driven Parallel Robots (2018), section 3.4, and Bruckmann et al., "Wire robots part I" (2008), describe the
same pulley; derived independently, and a radius of 0 gives the point. Bearing and groove have neither friction nor
inertia. If P is inside the pulley there is no tangent, and length and direction are NaN, as is the length if the cable
would wrap by more than 270 degrees and cross its arriving part. On the swivel's line the plane is undetermined, and a
fixed one is used.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from cdpr.base.fields import NonNegative, Vector3, unit
from cdpr.base.needs import Needs, depends
from cdpr.cables.exit import Exit

AS_POINT = depends("pulleys are an error without --pulleys-as-points")
AS_POINT_OR_LEFT_OUT = depends("pulleys are an error in the style legs without --pulleys-as-points, otherwise left out")
ALWAYS_LEFT_OUT = depends("pulleys are left out")
OUTLINE = 32  # corners of the drawn circle

UP: Vector3 = (0.0, 0.0, 1.0)


class Pulley(Exit):
    """Swivelling pulley."""

    needs: ClassVar[Needs] = Needs(
        backend={"exits": "pulley"}, mjcf=AS_POINT, sdf=AS_POINT_OR_LEFT_OUT, urdf=ALWAYS_LEFT_OUT
    )
    header: ClassVar[str] = "cdpr/cables/pulley/pulley.hpp"
    type: Literal["pulley"] = Field("pulley", description="swivels about the line on which its cable arrives")
    radius: NonNegative = Field(
        description="radius on which the middle of the cable runs: that of the groove and half the cable's diameter",
        json_schema_extra=unit("m"),
    )
    axis: Vector3 = Field(
        UP,
        description="direction in which the cable arrives from its winch, of any length, axes of the robot's base; the "
        "pulley swivels about the line along it through the cable's `frame` anchor, where the groove begins",
    )

    @field_validator("axis")
    @classmethod
    def _some_direction(cls, axis: Vector3) -> Vector3:
        if not math.hypot(*axis) > 0.0:
            raise ValueError("expected a direction, got [0, 0, 0]")
        return axis

    def turned(self, R: NDArray[np.float64]) -> Self:
        """Return the pulley with its axis rotated."""
        x, y, z = (sum(R[i, j] * self.axis[j] for j in range(3)) for i in range(3))
        return self.model_copy(update={"axis": (float(x), float(y), float(z))})

    def numbers(self) -> Sequence[float]:
        """Return radius, unit vector of the axis, and a perpendicular unit vector: the plane if it is undetermined."""
        along = np.array(self.axis) / np.abs(self.axis).max()
        along /= np.linalg.norm(along)
        side = np.eye(3)[np.argmin(np.abs(along))]
        side -= (side @ along) * along
        return [self.radius, *along, *side / np.linalg.norm(side)]

    def swivel(self) -> Sequence[float] | None:
        """Return the axis; None for a radius of 0, which is a point."""
        return self.numbers()[1:4] if self.radius > 0.0 else None

    def obstacle(self, frame: Sequence[float], tip: Sequence[float]) -> str:
        """Return why no cable leads to the anchor on the platform, inside or behind the pulley; "" if one does."""
        along, arm, r = np.array(self.numbers()[1:4]), np.array(tip) - frame, self.radius
        z = float(arm @ along)
        x = float(np.linalg.norm(arm - z * along))
        square = x * (x - 2.0 * r) + z * z
        if r > 0.0 and not square > 0.0:
            return "its anchor on the platform lies within its pulley"
        f = math.sqrt(max(square, 0.0))
        if z < 0.0 and f * (x - r) + r * z < 0.0 and f * z - r * (x - r) > 0.0:
            return "its anchor on the platform lies behind its pulley, more than three quarters of a turn round"
        return ""

    def outline(self, frame: Sequence[float], leaving: Sequence[float]) -> list[list[float]]:
        """Return the groove as a circle in the plane of its cable."""
        _, *values = self.numbers()
        along, side = np.array(values[:3]), np.array(values[3:])
        arm = np.array(leaving) - frame
        arm -= (arm @ along) * along
        away = arm / np.linalg.norm(arm) if np.linalg.norm(arm) > 0.0 else side
        angle = np.linspace(0.0, 2.0 * np.pi, OUTLINE + 1)[:, None]
        circle = np.array(frame) + self.radius * ((1.0 - np.cos(angle)) * away + np.sin(angle) * along)
        points: list[list[float]] = circle.tolist()
        return points
