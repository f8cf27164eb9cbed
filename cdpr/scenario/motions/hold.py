"""Constant pose."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import Field

from cdpr import trajectory
from cdpr.base.fields import INITIAL, Position, unit
from cdpr.base.needs import Needs, of_motion
from cdpr.base.problems import Path
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.motion import Motion, Report, pose, posed
from cdpr.scenario.orientation import Orientation


class Hold(Motion):
    """Constant pose."""

    needs: ClassVar[Needs] = of_motion()
    type: Literal["hold"] = Field("hold", description="hold one pose")
    position: Position = Field(
        INITIAL,
        description="position of the platform's origin; default: the initial one",
        json_schema_extra=unit("m"),
    )
    orientation: Orientation = Field(INITIAL, description="attitude; default: the initial one")

    def poses(self) -> list[tuple[Path, Posed]]:
        """Return the pose."""
        return [((), self)]

    def stay(self, guide: Guide, report: Report) -> None:
        """Do nothing: there is only one pose."""

    def complete(self, initial: Initial) -> Self:
        """Return a copy with missing values set to the initial pose."""
        return posed(self, initial)

    def make(self) -> trajectory.Trajectory:
        """Return the trajectory."""
        return trajectory.hold(*pose(self))
