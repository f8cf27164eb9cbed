"""Failure of a sensor."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from cdpr.base.needs import Needs, of_event
from cdpr.scenario.events.sensor_event import SensorLoss


class SensorFailure(SensorLoss):
    """Failure of a sensor: it takes no measurements. Those that are on their way still arrive.

    Example:
        >>> import cdpr
        >>> cdpr.events.SensorFailure(time=1.0, sensor="mocap").duration is None
        True
    """

    needs: ClassVar[Needs] = of_event()
    type: Literal["sensor_failure"] = Field(
        default_factory=lambda: "sensor_failure",
        description="a sensor fails: it takes no measurements, and its last one is held",
    )

    @property
    def happening(self) -> str:
        """Description of the event."""
        return "fails"
