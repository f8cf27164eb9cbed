"""Sections of a robot file on limits of tensions and lengths."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field, model_validator

from cdpr.base.fields import Highest, NonNegative, Number, Positive, Section, unit
from cdpr.base.needs import UNCONCERNED, YES, Needs, of_run

OF_CABLES = Needs(sdf=UNCONCERNED, urdf=UNCONCERNED)  # formats without cables


class TensionSection(Section):
    """Tension limits of all cables."""

    needs: ClassVar[Needs] = OF_CABLES

    min: Number | list[Number] = Field(
        description="lowest admissible tension, a number or one per cable", json_schema_extra=unit("N")
    )
    max: Highest | list[Highest] = Field(
        description="highest admissible tension, a number or one per cable; .inf for none", json_schema_extra=unit("N")
    )


class CableTension(Section):
    """Tension limits of a cable, if they differ from the robot's."""

    needs: ClassVar[Needs] = OF_CABLES

    min: Number | None = Field(None, description="lowest admissible tension", json_schema_extra=unit("N"))
    max: Highest | None = Field(None, description="highest admissible tension", json_schema_extra=unit("N"))


class LengthLimits(Section):
    """Shortest and longest length of a cable."""

    needs: ClassVar[Needs] = of_run(mjcf=YES)

    min: NonNegative | None = Field(None, description="shortest length", json_schema_extra=unit("m"))
    max: Positive | None = Field(None, description="longest length", json_schema_extra=unit("m"))

    @model_validator(mode="after")
    def _ordered(self) -> LengthLimits:
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError(f"min ({self.min:g} m) must not exceed max ({self.max:g} m)")
        return self


COMMON_TENSION = CableTension.model_construct()
NO_LENGTH_LIMITS = LengthLimits.model_construct()


def limits(robot: TensionSection, given: CableTension | None, i: int) -> tuple[float, float]:
    """Return the lowest and highest tension of cable i, N: its own limits, else the robot's."""
    own = given or COMMON_TENSION

    def common(value: float | list[float]) -> float:
        return value[i] if isinstance(value, list) else value

    low = common(robot.min) if own.min is None else own.min
    high = common(robot.max) if own.max is None else own.max
    return low, high
