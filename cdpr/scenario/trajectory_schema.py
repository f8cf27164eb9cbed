"""The sections of the desired motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, TypeVar

from pydantic import Field, PrivateAttr

from cdpr.scenario.fields import INITIAL, ZERO, NonNegative, Number, Position, Positive, Section, Vector3, unit
from cdpr.scenario.orientation import Orientation
from cdpr.scenario.problems import Path
from cdpr.scenario.table import Table

if TYPE_CHECKING:
    from cdpr.scenario.schema import Initial

MAX_TURNS = 1000

_START = "time at which the motion begins; until then its first pose is held"


class Hold(Section):
    """One pose, held."""

    type: Literal["hold"] = Field("hold", description="hold one pose")
    position: Position = Field(
        INITIAL,
        description="position of the platform's origin; the initial one unless said",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(INITIAL, description="attitude; the initial one unless said")


class Pose(Section):
    """Position and attitude, world axes; the initial ones unless said."""

    position: Position = Field(
        INITIAL,
        description="position of the platform's origin; the initial one unless said",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(INITIAL, description="attitude; the initial one unless said")


class Knot(Pose):
    """One end of a quintic: pose and derivatives, world axes. What is left out: the initial pose, at rest."""

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
    position: Position = Field(description="position of the platform's origin", json_schema_extra=unit("m"))
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


class PickAndPlace(Section):
    """Up, across and down as one motion with continuous acceleration, then its end is held."""

    type: Literal["pick_and_place"] = Field(description="an arch: up, across and down as one smooth motion")
    start: NonNegative = Field(0.0, description=_START, json_schema_extra=unit("s"))
    duration: Positive = Field(
        description="time that the motion takes: one half to rise, one to sink", json_schema_extra=unit("s")
    )
    from_: Pose = Field(Pose(), alias="from", description="where it begins; the initial pose unless said")
    to: Pose = Field(description="where it ends")
    height: NonNegative = Field(
        description="how far the top lies above the higher end, along world z", json_schema_extra=unit("m")
    )
    vertical: float = Field(
        0.2,
        ge=0,
        le=0.49,
        description="share of the duration, at each end, in which the motion is purely vertical and does not turn",
    )


class Circle(Section):
    """A circle, or an arc, passed from rest to rest, then its end is held."""

    type: Literal["circle"] = Field(description="round a centre, from rest to rest")
    start: NonNegative = Field(0.0, description=_START, json_schema_extra=unit("s"))
    duration: Positive = Field(description="time that all turns take", json_schema_extra=unit("s"))
    position: Position = Field(
        INITIAL,
        description="where it begins, which gives the radius; the initial position unless said",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(INITIAL, description="attitude where it begins; the initial one unless said")
    center: Position = Field(description="centre, in the plane of the beginning", json_schema_extra=unit("m"))
    normal: Vector3 = Field((0.0, 0.0, 1.0), description="direction of the axis, of any length")
    turns: float = Field(
        1.0,
        ge=-MAX_TURNS,
        le=MAX_TURNS,
        description="how many times round, also in part; right-handed about the normal, negative the other way",
    )
    turning: bool = Field(False, description="whether the platform turns with the path or keeps its attitude")


class Helix(Circle):
    """A circle that climbs along its axis."""

    type: Literal["helix"] = Field(description="round an axis and along it, from rest to rest")  # type: ignore[assignment]
    pitch: Number = Field(
        description="way along the normal per turn; backwards for negative turns", json_schema_extra=unit("m")
    )


class Stop(Section):
    """A pose to stop at, world axes."""

    position: Position = Field(description="position of the platform's origin", json_schema_extra=unit("m"))
    orientation: Orientation = Field(INITIAL, description="attitude; the initial one unless said")
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


class JerkLimited(Section):
    """Straight moves from stop to stop, as fast as the limits allow; the last pose is held."""

    type: Literal["jerk_limited"] = Field(description="straight moves from stop to stop, as fast as limits allow")
    start: NonNegative = Field(0.0, description=_START, json_schema_extra=unit("s"))
    from_: Pose = Field(Pose(), alias="from", description="where it begins; the initial pose unless said")
    points: list[Stop] = Field(min_length=1, description="poses to stop at, in their order")
    limits: Limits = Field(description="limits of the translation")
    angular_limits: AngularLimits | None = Field(
        None, description="limits of the rotation; required if the attitude changes"
    )


class Csv(Section):
    """A smooth path through the rows of a CSV file, then the last one is held.

    Rates that the file does not hold are chosen as those of waypoints: smooth at inner rows, zero at both ends.
    """

    type: Literal["csv"] = Field(description="a smooth path through the rows of a CSV file")
    start: NonNegative = Field(0.0, description="time to which the file's times are added", json_schema_extra=unit("s"))
    file: str = Field(
        min_length=1,
        description="name of the file, relative to this one; its first line names the columns: t (s), x, y, z (m), "
        "and if wanted qw, qx, qy, qz, vx, vy, vz (m/s), wx, wy, wz (rad/s), ax, ay, az (m/s^2), world axes",
    )
    orientation: Orientation = Field(
        INITIAL, description="attitude, where the file has no quaternions; the initial one unless said"
    )
    sha256: str | None = Field(
        None, pattern="^[0-9a-f]{64}$", description="checksum; if given, the file must still have it"
    )
    _table: Table | None = PrivateAttr(None)

    @property
    def table(self) -> Table:
        """What the file holds; present after loading."""
        assert self._table is not None
        return self._table

    def filled(self, table: Table) -> Csv:
        """Return a copy that holds what its file does."""
        copy = self.model_copy(update={"sha256": table.sha256})
        copy._table = table
        return copy


Motion = Hold | Quintic | Waypoints | PickAndPlace | Circle | Helix | JerkLimited | Csv
Trajectory = Annotated[Motion, Field(discriminator="type")]

Posed = Hold | Knot | Waypoint | Pose | Stop | Circle
_Section = TypeVar("_Section", bound=Section)


def poses(motion: Motion) -> list[tuple[Path, Posed]]:
    """Return the poses that the section itself holds, and their paths within it."""
    if isinstance(motion, Hold | Circle):
        return [((), motion)]
    if isinstance(motion, Quintic | PickAndPlace):
        return [(("from",), motion.from_), (("to",), motion.to)]
    if isinstance(motion, Csv):
        return []
    if isinstance(motion, JerkLimited):
        return [(("from",), motion.from_), *((("points", k), stop) for k, stop in enumerate(motion.points))]
    return [(("points", k), point) for k, point in enumerate(motion.points)]


def complete(motion: Motion, initial: Initial) -> Motion:
    """Fill in what was left out: the initial pose, the first waypoint, rest at the ends of the waypoints."""

    def posed(section: _Section) -> _Section:
        missing = [name for name in ("position", "orientation") if getattr(section, name, ZERO) is None]
        return section.model_copy(update={name: getattr(initial, name) for name in missing})

    if isinstance(motion, Hold | Circle | Csv):
        return posed(motion)
    if isinstance(motion, Quintic | PickAndPlace):
        return motion.model_copy(update={"from_": posed(motion.from_), "to": posed(motion.to)})
    if isinstance(motion, JerkLimited):
        stops = [posed(stop) for stop in motion.points]
        return motion.model_copy(update={"from_": posed(motion.from_), "points": stops})
    points = [posed(point) for point in motion.points]
    if points[0].time > 0:
        points.insert(0, Waypoint(time=0.0, position=initial.position, orientation=initial.orientation))
    for end in (0, -1):
        rest = {name: ZERO for name in _DERIVATIVES if getattr(points[end], name) is None}
        points[end] = points[end].model_copy(update=rest)
    return motion.model_copy(update={"points": points})


_DERIVATIVES = ("velocity", "angular_velocity", "acceleration", "angular_acceleration")
