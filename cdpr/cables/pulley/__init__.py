"""Pulley that swivels about the line of its arriving cable.

The cable arrives along the axis a, touches the groove at A, the anchor on the frame, lies on it over the wrap angle
beta and leaves tangentially for P on the platform. The bearing lets the pulley turn about the line through A along a,
so that its plane follows the cable. In that plane, with x away from the line and z along a, both from A, the centre is
at (r, 0) and P at (x, z), x >= 0. From the centre C the tangent to P has the length f = sqrt((x - r)^2 + z^2 - r^2),
and with (c, z) = P - C

    sin beta = (f c + r z) / (c^2 + z^2),   cos beta = (f z - r c) / (c^2 + z^2),
    E = A + r (1 - cos beta) e_x + r sin beta a,   length = r beta + f.

Pott, Cable-Driven Parallel Robots (2018), section 3.4, and Bruckmann et al., "Wire robots part I" (2008), describe the
same pulley; derived independently, and a radius of 0 gives the point. It has no inertia. If P is inside the pulley
there is no tangent, and length and direction are NaN, as is the length if the cable would wrap by more than 270 degrees
and cross its arriving part. On the swivel's line the plane is undetermined, and a fixed one is used.

Friction makes the tensions differ: that of the side towards which the cable moves is the higher one. With mu the
coefficient between cable and groove, mu_b that of the bearing, r_b the radius at which it acts, and k = mu_b r_b / r,

    T_high = T_low exp(mu beta)                       for a cable that slips over a groove at rest (Euler, Eytelwein);
    T_high - T_low = k |T_high e_1 - T_low e_2|       for a wheel that turns: its friction torque is mu_b r_b times the
                                                      load of its bearing, the sum of both pulls.

The load is sqrt(T_high^2 + T_low^2 - 2 T_high T_low cos beta), so the second is T_high = T_low (x + sqrt(1 + x^2))^2
with x = k sin(beta / 2) / sqrt(1 - k^2). With both coefficients the wheel turns or the cable slips, whichever takes
less force. Around rest mu and mu_b are multiplied by tanh(speed / v0), where `speed` is that at which the winch pays
out and v0 the friction speed: a cable at rest does not stick. The tension of a span is that on the side of the
platform; spans stretch on the pulley as without friction. Weight and inertia of the wheel have no part in the load.
Kraus et al., "Pulley friction compensation for winch-integrated cable force measurement and verification on a
cable-driven parallel robot" (ICRA 2015), measured such losses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from cdpr.base.fields import NonNegative, Positive, Vector3, unit
from cdpr.base.needs import Needs, depends
from cdpr.cables.exit import Exit

AS_POINT = depends("pulleys are an error; with --pulleys-as-points, they become points")
AS_POINT_OR_LEFT_OUT = depends(
    "with --style legs, pulleys are an error, or points with --pulleys-as-points; with --style platform, they are left "
    "out"
)
ALWAYS_LEFT_OUT = depends("pulleys are left out")
OUTLINE = 32  # corners of the drawn circle

FRICTION_SPEED = 0.01  # m/s
NO_SLIP = 100.0  # coefficient of a groove in which no cable slips: far more than any wheel resists
FIXED = 1e300  # k of a wheel that does not turn

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

    friction: NonNegative | None = Field(
        None,
        le=10.0,
        description="coefficient of friction between cable and groove, for a guide that does not turn; default: the "
        "cable does not slip",
    )
    bearing_friction: NonNegative | None = Field(
        None, description="coefficient of friction of the bearing; default: none, or with `friction` a fixed guide"
    )
    bearing_radius: Positive | None = Field(
        None, description="radius at which the bearing's friction acts", json_schema_extra=unit("m")
    )
    friction_speed: Positive | None = Field(
        None,
        description="speed of the cable at which friction reaches 76 % of its value: it grows as tanh(speed / this); "
        f"default: {FRICTION_SPEED:g}",
        json_schema_extra=unit("m/s"),
    )

    @field_validator("axis")
    @classmethod
    def _some_direction(cls, axis: Vector3) -> Vector3:
        if not math.hypot(*axis) > 0.0:
            raise ValueError("expected a direction, got [0, 0, 0]")
        return axis

    @model_validator(mode="after")
    def _whole_bearing(self) -> Self:
        coefficient, radius = self.bearing_friction, self.bearing_radius
        if (coefficient is None) != (radius is None):
            raise ValueError("expected both bearing_friction and bearing_radius, or neither, got one of them")
        if coefficient is not None and radius is not None and not coefficient * radius < self.radius:
            raise ValueError(
                f"expected bearing_friction * bearing_radius below the radius of the pulley, {self.radius:g} (m), got "
                f"{coefficient * radius:g}: such a pulley does not turn"
            )
        if self.friction_speed is not None and self.friction is None and coefficient is None:
            raise ValueError("friction_speed needs friction or bearing_friction: add one of these, or remove it")
        return self

    @property
    def rubs(self) -> bool:
        """True if friction changes the tension."""
        groove, bearing = self._coefficients()
        return 0.0 < min(groove, bearing) < NO_SLIP

    def damping(self, frame: Sequence[float], tip: Sequence[float]) -> float:
        """Return the derivative of log(T_platform / T_winch) with the speed at rest, s/m."""
        if not self.rubs:
            return 0.0
        along, arm = np.array(self.numbers()[1:4]), np.array(tip) - frame
        z = float(arm @ along)
        c = float(np.linalg.norm(arm - z * along)) - self.radius
        wrap = (math.atan2(z, -c) - math.acos(min(1.0, self.radius / math.hypot(c, z)))) % math.tau
        groove, bearing = self._coefficients()
        loss = min(groove * wrap, 2.0 * bearing * math.sin(0.5 * wrap))
        return loss / (self.friction_speed or FRICTION_SPEED)

    def _coefficients(self) -> tuple[float, float]:
        """Return mu and k; NO_SLIP for a cable that does not slip, FIXED for a wheel that does not turn."""
        groove = NO_SLIP if self.friction is None else self.friction
        if self.bearing_friction is None or self.bearing_radius is None:
            return groove, FIXED
        return groove, self.bearing_friction * self.bearing_radius / self.radius

    def turned(self, R: NDArray[np.float64]) -> Self:
        """Return the pulley with its axis rotated."""
        x, y, z = (sum(R[i, j] * self.axis[j] for j in range(3)) for i in range(3))
        return self.model_copy(update={"axis": (float(x), float(y), float(z))})

    def numbers(self) -> Sequence[float]:
        """Return radius, unit vector of the axis, a perpendicular one for an undetermined plane, and any friction."""
        along = np.array(self.axis) / np.abs(self.axis).max()
        along /= np.linalg.norm(along)
        side = np.eye(3)[np.argmin(np.abs(along))]
        side -= (side @ along) * along
        friction = [*self._coefficients(), 1.0 / (self.friction_speed or FRICTION_SPEED)] if self.rubs else []
        return [self.radius, *along, *side / np.linalg.norm(side), *friction]

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
        values = self.numbers()
        along, side = np.array(values[1:4]), np.array(values[4:7])
        arm = np.array(leaving) - frame
        arm -= (arm @ along) * along
        away = arm / np.linalg.norm(arm) if np.linalg.norm(arm) > 0.0 else side
        angle = np.linspace(0.0, 2.0 * np.pi, OUTLINE + 1)[:, None]
        circle = np.array(frame) + self.radius * ((1.0 - np.cos(angle)) * away + np.sin(angle) * along)
        points: list[list[float]] = circle.tolist()
        return points
