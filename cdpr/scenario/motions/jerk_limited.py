"""Straight moves from stop to stop, as fast as limits allow."""

from __future__ import annotations

from itertools import pairwise
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import Field

from cdpr import trajectory
from cdpr.base.fields import INITIAL, NonNegative, Position, Positive, Section, unit
from cdpr.base.needs import Needs, of_motion
from cdpr.base.problems import Path
from cdpr.model import rotations
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.motion import Motion, Pose, Report, begins, pose, posed
from cdpr.scenario.orientation import Orientation

NO_TURN = 1e-9  # rad; closer attitudes are equal


class Stop(Section):
    """Pose to stop at, world axes."""

    position: Position = Field(description="position of the platform's origin", json_schema_extra=unit("m"))
    orientation: Orientation = Field(INITIAL, description="attitude; default: the initial one")
    pause: NonNegative = Field(0.0, description="time to stay there", json_schema_extra=unit("s"))


class Limits(Section):
    """Largest norms of a translation's derivatives."""

    velocity: Positive = Field(description="largest speed of the origin", json_schema_extra=unit("m/s"))
    acceleration: Positive = Field(description="largest acceleration of the origin", json_schema_extra=unit("m/s^2"))
    jerk: Positive = Field(description="largest jerk of the origin", json_schema_extra=unit("m/s^3"))


class AngularLimits(Section):
    """Largest norms of a rotation's derivatives."""

    velocity: Positive = Field(description="largest angular velocity", json_schema_extra=unit("rad/s"))
    acceleration: Positive = Field(description="largest angular acceleration", json_schema_extra=unit("rad/s^2"))
    jerk: Positive = Field(description="largest angular jerk", json_schema_extra=unit("rad/s^3"))


class JerkLimited(Motion):
    """Straight moves from stop to stop, as fast as the limits allow; the last pose is held."""

    needs: ClassVar[Needs] = of_motion()
    type: Literal["jerk_limited"] = Field(
        default_factory=lambda: "jerk_limited", description="straight moves from stop to stop, as fast as limits allow"
    )
    start: NonNegative = begins()
    from_: Pose = Field(Pose(), alias="from", description="start; default: the initial pose")
    points: list[Stop] = Field(min_length=1, description="poses to stop at, in their order")
    limits: Limits = Field(description="limits of the translation")
    angular_limits: AngularLimits | None = Field(
        None, description="limits of the rotation; required if the attitude changes"
    )

    def poses(self) -> list[tuple[Path, Posed]]:
        """Return the start and the stops."""
        return [(("from",), self.from_), *((("points", k), stop) for k, stop in enumerate(self.points))]

    def stay(self, guide: Guide, report: Report) -> None:
        """Do nothing: straight moves between allowed poses are allowed."""

    def complete(self, initial: Initial) -> Self:
        """Return a copy with missing values set to the initial pose."""
        stops = [posed(stop, initial) for stop in self.points]
        return self.model_copy(update={"from_": posed(self.from_, initial), "points": stops})

    def check_completed(self, report: Report) -> None:
        """Report rotations without limits."""
        if self.angular_limits:
            return
        for (_, before), (path, after) in pairwise(self.poses()):
            q = rotations.multiply(rotations.conjugate(before.orientation.quaternion()), after.orientation.quaternion())
            if np.linalg.norm(rotations.rotation_vector(q)) > NO_TURN:
                keys = "velocity, acceleration and jerk in rad/s, rad/s^2, rad/s^3"
                text = f"required as the attitude changes on the way to point {path[-1]}: {keys}"
                report.add_problem(("angular_limits",), text)
                return

    def ends(self) -> float:
        """Return the end time, s, which depends on the limits."""
        return self.make().end

    def make(self) -> trajectory.Trajectory:
        """Return the trajectory."""
        stops = [trajectory.Stop(*pose(self.from_)), *(trajectory.Stop(*pose(p), p.pause) for p in self.points)]
        angular = None if self.angular_limits is None else bounds(self.angular_limits)
        return trajectory.stop_to_stop(self.start, stops, bounds(self.limits), angular)


def bounds(section: Limits | AngularLimits) -> trajectory.Limits:
    """Return the limits in a section."""
    return trajectory.Limits(section.velocity, section.acceleration, section.jerk)
