"""Single move by polynomials of degree five."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import Field

from cdpr import trajectory
from cdpr.base.fields import ZERO, NonNegative, Positive, Vector3, unit
from cdpr.base.needs import Needs, of_motion
from cdpr.base.problems import Path
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.motion import Motion, Pose, Report, begins, knot, posed


class Knot(Pose):
    """End of a quintic: pose and derivatives, world axes; default: the initial pose, at rest."""

    velocity: Vector3 = Field(ZERO, description="velocity of the origin", json_schema_extra=unit("m/s"))
    angular_velocity: Vector3 = Field(ZERO, description="angular velocity", json_schema_extra=unit("rad/s"))
    acceleration: Vector3 = Field(ZERO, description="acceleration of the origin", json_schema_extra=unit("m/s^2"))
    angular_acceleration: Vector3 = Field(ZERO, description="angular acceleration", json_schema_extra=unit("rad/s^2"))


class Quintic(Motion):
    """Single move by polynomials of degree five; its end is held."""

    needs: ClassVar[Needs] = of_motion()
    type: Literal["quintic"] = Field(
        default_factory=lambda: "quintic", description="one move by polynomials of degree five"
    )
    start: NonNegative = begins()
    duration: Positive = Field(description="duration of the move", json_schema_extra=unit("s"))
    from_: Knot = Field(Knot(), alias="from", description="beginning of the move; default: the initial pose at rest")
    to: Knot = Field(description="end of the move, held afterwards")

    @property
    def end(self) -> float:
        """End time of the move, s."""
        return self.start + self.duration

    def poses(self) -> list[tuple[Path, Posed]]:
        """Return both ends."""
        return [(("from",), self.from_), (("to",), self.to)]

    def stay(self, guide: Guide, report: Report) -> None:
        """Do nothing: polynomials between allowed ends with allowed rates are allowed."""

    def complete(self, initial: Initial) -> Self:
        """Return a copy with missing values set to the initial pose."""
        return self.model_copy(update={"from_": posed(self.from_, initial), "to": posed(self.to, initial)})

    def span(self) -> tuple[float | None, float | None]:
        """Return the start and end times, s."""
        return self.start, self.end

    def make(self) -> trajectory.Trajectory:
        """Return the trajectory."""
        return trajectory.through([knot(self.start, self.from_), knot(self.end, self.to)])
