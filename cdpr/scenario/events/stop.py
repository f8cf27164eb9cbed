"""Emergency stop."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal

from pydantic import Field

from cdpr.base.fields import Positive, unit
from cdpr.base.needs import Needs, of_event
from cdpr.config.problems import exact
from cdpr.log.event import Event
from cdpr.scenario.events.event import Action, EventActions, History, ScenarioEvent, first_sample
from cdpr.trajectory import Stopping, Trajectory


class EmergencyStop(ScenarioEvent):
    """Emergency stop according to the stop categories of IEC 60204-1."""

    needs: ClassVar[Needs] = of_event()
    overrides: ClassVar[bool] = True
    ends_commands: ClassVar[bool] = True

    type: Literal["emergency_stop"] = Field(
        default_factory=lambda: "emergency_stop", description="the robot is stopped"
    )
    category: int = Field(
        2,
        ge=0,
        le=2,
        description="stop category of IEC 60204-1: 2 slows down along the path, then holds the pose; 1 does so and "
        "then cuts the power; 0 cuts it at once. Without power the controller and the distribution are off, and only "
        "winches with a brake (`brake_torque`) hold their cables. Winches that hold lengths need one",
    )
    stopping_time: Positive = Field(
        0.5,
        description="time from the motion to rest (categories 1 and 2): the pace along the path falls to 0 smoothly, "
        "as 1 - 3 s^2 + 2 s^3 with s from 0 to 1, so half this time of the motion is still covered",
        json_schema_extra=unit("s"),
    )

    @property
    def cuts_power(self) -> bool:
        """Return True for the categories 0 and 1."""
        return self.category != 2

    def follow(self, history: History) -> Iterator[str]:
        """Yield a problem if the robot is already stopped."""
        if history.stopped is not None:
            yield f"the robot has stopped already at {exact(history.stopped)} s; only one emergency stop is allowed"
        history.stopped = self.time

    def redirect(self, motion: Trajectory, step: float) -> Trajectory:
        """Return the motion slowed down to rest (categories 1 and 2)."""
        if self.category == 0:
            return motion
        return Stopping(motion, first_sample(self.time, step) * step, self.stopping_time)

    def actions(self, step: float) -> Iterator[tuple[float, Action]]:
        """Yield the power cut (categories 0 and 1)."""

        def cut(drives: EventActions) -> None:
            drives.cut_power()

        if self.cuts_power:
            yield self._power_off(step), cut

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield the stop and the power cut."""
        controlled = f", at rest within {self.stopping_time:g} s" if self.category != 0 else ""
        text = f"emergency stop of category {self.category}{controlled}"
        yield Event(first_sample(self.time, step) * step, self.type, text)
        if self.cuts_power:
            off = first_sample(self._power_off(step), step) * step
            yield Event(off, "power_off", "the drives have no power: only jammed cables and brakes hold a tension")

    def _power_off(self, step: float) -> float:
        """Return the time of the power cut, s."""
        return self.time if self.category == 0 else first_sample(self.time, step) * step + self.stopping_time
