"""Section of imperfect drives between the commands of the winches and their motors."""

from __future__ import annotations

from typing import Annotated, ClassVar, NamedTuple

from pydantic import Field

from cdpr.base.fields import NonNegative, Positive, Section, unit
from cdpr.base.needs import Needs, of_drives

LONGEST = 1.0  # s, delay

Delay = Annotated[NonNegative, Field(le=LONGEST)]
DELAY = "delay of the command: an integer multiple of control_step"
RESOLUTION = "the command is rounded to multiples of this value, in the unit of the command (N, m or m/s); 0: exact"
RATE_MAX = "largest change of the command per second, in N/s, m/s or m/s^2"
BACKLASH = (
    "width of the play between motor and drum: a command that reverses acts only after a change by this value (N or "
    "m; m also for winches that take a rate)"
)
SAME = "default: as for all cables"


class Imperfection(NamedTuple):
    """Imperfection of a drive: see `Drives`."""

    delay: float  # s
    resolution: float  # N, m or m/s
    rate_max: float | None  # N/s, m/s or m/s^2; None without a limit
    backlash: float  # N or m


class CableDrive(Section):
    """Drive of one cable; what it does not give is that of all cables."""

    delay: Delay | None = Field(None, description=f"{DELAY}; {SAME}", json_schema_extra=unit("s"))
    resolution: NonNegative | None = Field(None, description=f"{RESOLUTION}; {SAME}")
    rate_max: Positive | None = Field(None, description=f"{RATE_MAX}; {SAME}")
    backlash: NonNegative | None = Field(None, description=f"{BACKLASH}; {SAME}")


class Drives(Section):
    """Drives that apply the commands of the winches imperfectly.

    Example:
        >>> from cdpr.scenario.drives_schema import CableDrive, Drives
        >>> drives = Drives(delay=0.01, cables={"cable_2": CableDrive(delay=0.02)})
        >>> drives.of_cable("cable_1").delay, drives.of_cable("cable_2").delay
        (0.01, 0.02)
    """

    needs: ClassVar[Needs] = of_drives()

    delay: Delay = Field(0.0, description=DELAY, json_schema_extra=unit("s"))
    resolution: NonNegative = Field(0.0, description=RESOLUTION)
    rate_max: Positive | None = Field(None, description=f"{RATE_MAX}; default: no limit")
    backlash: NonNegative = Field(0.0, description=BACKLASH)
    cables: dict[str, CableDrive] = Field({}, description="other values of single cables, by the cable's name")

    def of_cable(self, name: str) -> Imperfection:
        """Return the imperfection of the drive of a cable."""
        own = self.cables.get(name, CableDrive())
        return Imperfection(
            self.delay if own.delay is None else own.delay,
            self.resolution if own.resolution is None else own.resolution,
            self.rate_max if own.rate_max is None else own.rate_max,
            self.backlash if own.backlash is None else own.backlash,
        )

    @property
    def ideal(self) -> bool:
        """True if all drives apply their commands exactly and at once."""
        ideal = Imperfection(0.0, 0.0, None, 0.0)
        return all(self.of_cable(name) == ideal for name in ("", *self.cables))
