"""Arch motion: up, across and down as one smooth motion."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import Field

from cdpr import trajectory
from cdpr.base.fields import NonNegative, Positive, unit
from cdpr.base.needs import Needs, of_motion
from cdpr.base.problems import Path
from cdpr.config.problems import exact
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.motion import Motion, Pose, Report, begins, pose, posed


class PickAndPlace(Motion):
    """Motion up, across and down with continuous acceleration; its end is held."""

    needs: ClassVar[Needs] = of_motion()
    type: Literal["pick_and_place"] = Field(
        default_factory=lambda: "pick_and_place", description="an arch: up, across and down as one smooth motion"
    )
    start: NonNegative = begins()
    duration: Positive = Field(
        description="time that the motion takes: one half to rise, one to sink", json_schema_extra=unit("s")
    )
    from_: Pose = Field(Pose(), alias="from", description="start; default: the initial pose")
    to: Pose = Field(description="where it ends")
    height: NonNegative = Field(
        description="height of the top above the higher end, along world z", json_schema_extra=unit("m")
    )
    vertical: float = Field(
        0.2,
        ge=0,
        le=0.49,
        description="share of the duration, at each end, in which the motion is purely vertical and does not turn",
    )

    def poses(self) -> list[tuple[Path, Posed]]:
        """Return both ends."""
        return [(("from",), self.from_), (("to",), self.to)]

    def stay(self, guide: Guide, report: Report) -> None:
        """Report an arch if the guide holds the height."""
        if self.height > 0.0 and guide.held[2]:
            report.add_problem(("height",), f"expected 0, got {exact(self.height)}: {guide.free}")

    def complete(self, initial: Initial) -> Self:
        """Return a copy with missing values set to the initial pose."""
        return self.model_copy(update={"from_": posed(self.from_, initial), "to": posed(self.to, initial)})

    def make(self) -> trajectory.Trajectory:
        """Return the trajectory."""
        (p0, q0), (p1, q1) = pose(self.from_), pose(self.to)
        return trajectory.arch(self.start, self.duration, (p0, p1), (q0, q1), self.height, self.vertical)
