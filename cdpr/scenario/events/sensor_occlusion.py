"""Occlusion of a sensor."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from cdpr.base.fields import Positive, unit
from cdpr.base.needs import Needs, of_event
from cdpr.scenario.events.sensor_event import SensorLoss


class SensorOcclusion(SensorLoss):
    """Occlusion of a sensor for some time, in which it takes no measurements.

    Example:
        >>> import cdpr
        >>> cdpr.events.SensorOcclusion(time=1.0, duration=0.2, sensor="mocap").happening
        'is occluded'
    """

    needs: ClassVar[Needs] = of_event()
    type: Literal["sensor_occlusion"] = Field(
        default_factory=lambda: "sensor_occlusion",
        description="a sensor is occluded for some time: its measurements are lost, and the last one is held",
    )
    duration: Positive = Field(description="duration", json_schema_extra=unit("s"))

    @property
    def happening(self) -> str:
        """Description of the event."""
        return "is occluded"
