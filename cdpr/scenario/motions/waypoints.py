"""Smooth path through several poses."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import Field

from cdpr import trajectory
from cdpr.base.fields import INITIAL, ZERO, NonNegative, Position, Section, Vector3, unit
from cdpr.base.needs import Needs, of_motion
from cdpr.base.problems import Path
from cdpr.config.problems import exact
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.motion import Motion, Report, begins, knot, posed
from cdpr.scenario.orientation import Orientation

DERIVATIVES = ("velocity", "angular_velocity", "acceleration", "angular_acceleration")


class Waypoint(Section):
    """Pose at a time, world axes.

    Missing derivatives are smooth at inner points, and zero at the first and last one. After loading, None means
    "smooth".
    """

    time: NonNegative = Field(
        description="time after `start`, greater than the previous point's", json_schema_extra=unit("s")
    )
    position: Position = Field(description="position of the platform's origin", json_schema_extra=unit("m"))
    orientation: Orientation = Field(INITIAL, description="attitude; default: the initial one")
    velocity: Vector3 | None = Field(None, description="velocity of the origin", json_schema_extra=unit("m/s"))
    angular_velocity: Vector3 | None = Field(None, description="angular velocity", json_schema_extra=unit("rad/s"))
    acceleration: Vector3 | None = Field(
        None, description="acceleration of the origin", json_schema_extra=unit("m/s^2")
    )
    angular_acceleration: Vector3 | None = Field(
        None, description="angular acceleration", json_schema_extra=unit("rad/s^2")
    )


class Waypoints(Motion):
    """Smooth path through poses at given times; the last pose is held."""

    needs: ClassVar[Needs] = of_motion()
    type: Literal["waypoints"] = Field(
        default_factory=lambda: "waypoints", description="a smooth path through several poses"
    )
    start: NonNegative = begins()
    points: list[Waypoint] = Field(
        min_length=1,
        description="poses in the order of time; the initial one, at rest, comes first unless one has time 0",
    )

    @property
    def end(self) -> float:
        """Time of the last point, s."""
        return self.start + self.points[-1].time

    def poses(self) -> list[tuple[Path, Posed]]:
        """Return the points."""
        return [(("points", k), point) for k, point in enumerate(self.points)]

    def stay(self, guide: Guide, report: Report) -> None:
        """Do nothing: splines between allowed points with allowed rates are allowed."""

    def complete(self, initial: Initial) -> Self:
        """Return a copy with initial attitudes, the initial pose as first waypoint, and rest at both ends."""
        points = [posed(point, initial) for point in self.points]
        if points[0].time > 0:
            points.insert(0, Waypoint(time=0.0, position=initial.position, orientation=initial.orientation))
        for end in (0, -1):
            rest = {name: ZERO for name in DERIVATIVES if getattr(points[end], name) is None}
            points[end] = points[end].model_copy(update=rest)
        return self.model_copy(update={"points": points})

    def check(self, report: Report) -> None:
        """Report times that do not increase."""
        times = [point.time for point in self.points]
        for k in range(1, len(times)):
            if times[k] <= times[k - 1]:
                text = f"must be greater than the previous point's, {exact(times[k - 1])} (s), got {exact(times[k])}"
                report.add_problem(("points", k, "time"), text)
        if times == [0.0]:
            report.add_problem(("points",), "expected a point with a time greater than 0; to stay, use type: hold")

    def span(self) -> tuple[float | None, float | None]:
        """Return the start and end times, s; None for a start at the initial pose, which is at rest."""
        return (self.start if self.points[0].time == 0 else None), self.end

    def make(self) -> trajectory.Trajectory:
        """Return the trajectory."""
        points = [knot(self.start + point.time, point) for point in self.points]
        if len(points) > 1:
            return trajectory.through(points)
        return trajectory.hold(points[0].position, points[0].orientation)
