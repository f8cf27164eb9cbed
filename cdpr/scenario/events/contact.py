"""Event of cables that come too close to each other, to their platform or to an obstacle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal

from pydantic import Field

from cdpr.base.fields import NonNegative, unit
from cdpr.base.needs import Needs, of_event
from cdpr.log.event import Event
from cdpr.scenario.events.event import ClearanceMonitor, History, ScenarioEvent, first_sample


class Contact(ScenarioEvent):
    """Smallest clearance of the cables at or below a threshold, checked at each sample."""

    needs: ClassVar[Needs] = of_event()
    type: Literal["contact"] = Field(
        default_factory=lambda: "contact",
        description="cables touch, or come too near to, each other, their platform or one of world.obstacles",
    )
    time: NonNegative = Field(
        0.0, description="start of the monitoring: the first sample at or after this time", json_schema_extra=unit("s")
    )
    clearance: NonNegative = Field(0.0, description="smallest clearance that is reported", json_schema_extra=unit("m"))
    then: Literal["continue", "stop"] = Field(
        "continue", description="reaction: record it and continue, or end the run with that sample"
    )

    def follow(self, history: History) -> Iterator[str]:
        """Yield a problem if the diameter of a cable is unknown."""
        if history.thin:
            whose = f"'{history.thin[0]}'" + (f" and {len(history.thin) - 1} more" if history.thin[1:] else "")
            yield f"requires the diameters of all cables; missing: {whose}; set cable.diameter (m) of the robot"

    def clearance_monitor(self, step: float) -> ClearanceMonitor:
        """Return the condition of the event."""
        return ClearanceMonitor(self.clearance, first_sample(self.time, step) * step, self.then == "stop")

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield nothing: occurrences are found in the samples."""
        return iter(())
