"""The sections of the desired motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, TypeVar

from pydantic import Field

from cdpr.scenario.fields import INITIAL, ZERO, NonNegative, Positive, Section, Vector3, unit
from cdpr.scenario.orientation import Orientation

if TYPE_CHECKING:
    from cdpr.scenario.schema import Initial

_START = "time at which the motion begins; until then its first pose is held"


class Hold(Section):
    """One pose, held."""

    type: Literal["hold"] = Field("hold", description="hold one pose")
    position: Vector3 = Field(
        INITIAL,
        description="position of the platform's origin; the initial one unless said",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(INITIAL, description="attitude; the initial one unless said")


class Knot(Section):
    """One end of a quintic: pose and derivatives, world axes. What is left out: the initial pose, at rest."""

    position: Vector3 = Field(
        INITIAL,
        description="position of the platform's origin; the initial one unless said",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(INITIAL, description="attitude; the initial one unless said")
    velocity: Vector3 = Field(ZERO, description="velocity of the origin", json_schema_extra=unit("m/s"))
    angular_velocity: Vector3 = Field(ZERO, description="angular velocity", json_schema_extra=unit("rad/s"))
    acceleration: Vector3 = Field(ZERO, description="acceleration of the origin", json_schema_extra=unit("m/s^2"))
    angular_acceleration: Vector3 = Field(ZERO, description="angular acceleration", json_schema_extra=unit("rad/s^2"))


class Quintic(Section):
    """One move by polynomials of degree five, then its end is held."""

    type: Literal["quintic"] = Field(description="one move by polynomials of degree five")
    start: NonNegative = Field(0.0, description=_START, json_schema_extra=unit("s"))
    duration: Positive = Field(description="time that the move takes", json_schema_extra=unit("s"))
    from_: Knot = Field(Knot(), alias="from", description="beginning of the move; the initial pose at rest unless said")
    to: Knot = Field(description="end of the move, held afterwards")

    @property
    def end(self) -> float:
        """Time at which the move ends, s."""
        return self.start + self.duration


class Waypoint(Section):
    """A pose to pass at a time, world axes.

    Derivatives left out are chosen smooth at inner points and are zero at the first and the last one: after
    loading, None means "smooth".
    """

    time: NonNegative = Field(
        description="time after `start`, greater than the previous point's", json_schema_extra=unit("s")
    )
    position: Vector3 = Field(description="position of the platform's origin", json_schema_extra=unit("m"))
    orientation: Orientation = Field(INITIAL, description="attitude; the initial one unless said")
    velocity: Vector3 | None = Field(None, description="velocity of the origin", json_schema_extra=unit("m/s"))
    angular_velocity: Vector3 | None = Field(None, description="angular velocity", json_schema_extra=unit("rad/s"))
    acceleration: Vector3 | None = Field(
        None, description="acceleration of the origin", json_schema_extra=unit("m/s^2")
    )
    angular_acceleration: Vector3 | None = Field(
        None, description="angular acceleration", json_schema_extra=unit("rad/s^2")
    )


class Waypoints(Section):
    """A smooth path through poses at given times, then the last one is held."""

    type: Literal["waypoints"] = Field(description="a smooth path through several poses")
    start: NonNegative = Field(0.0, description=_START, json_schema_extra=unit("s"))
    points: list[Waypoint] = Field(
        min_length=1,
        description="poses in the order of time; the initial one, at rest, comes first unless one has time 0",
    )

    @property
    def end(self) -> float:
        """Time of the last point, s."""
        return self.start + self.points[-1].time


Trajectory = Annotated[Hold | Quintic | Waypoints, Field(discriminator="type")]

_Pose = TypeVar("_Pose", Hold, Knot, Waypoint)


def complete(trajectory: Hold | Quintic | Waypoints, initial: Initial) -> Hold | Quintic | Waypoints:
    """Fill in what was left out: the initial pose, the first waypoint, rest at the ends of the waypoints."""

    def posed(section: _Pose) -> _Pose:
        return section.model_copy(
            update={
                name: getattr(initial, name) for name in ("position", "orientation") if getattr(section, name) is None
            }
        )

    if isinstance(trajectory, Hold):
        return posed(trajectory)
    if isinstance(trajectory, Quintic):
        return trajectory.model_copy(update={"from_": posed(trajectory.from_), "to": posed(trajectory.to)})
    points = [posed(point) for point in trajectory.points]
    if points[0].time > 0:
        points.insert(0, Waypoint(time=0.0, position=initial.position, orientation=initial.orientation))
    for end in (0, -1):
        rest = {name: ZERO for name in _DERIVATIVES if getattr(points[end], name) is None}
        points[end] = points[end].model_copy(update=rest)
    return trajectory.model_copy(update={"points": points})


_DERIVATIVES = ("velocity", "angular_velocity", "acceleration", "angular_acceleration")
