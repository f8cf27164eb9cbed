"""Base classes of the events of sensors."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence

from pydantic import Field

from cdpr.base.fields import Positive, unit
from cdpr.base.nearest import did_you_mean
from cdpr.config.problems import exact
from cdpr.log.event import Event
from cdpr.scenario.events.event import Action, EventActions, ScenarioEvent, first_sample
from cdpr.sensing import Sensor
from cdpr.sensing.disturbance import Disturbance
from cdpr.sensing.sensor import measuring


class SensorEvent(ScenarioEvent):
    """Event of a sensor: it acts on the measurements after its sample."""

    sensor: str = Field(description="name of the sensor; by default, its name is its type")

    def check_sensor(self, sensors: Sequence[Sensor], cables: int) -> Iterator[tuple[str, str]]:
        """Yield the key and text of problems with these sensors of a robot with this number of cables."""
        names = [each.title for each in sensors]
        if self.sensor not in names:
            known = (
                f"{did_you_mean(self.sensor, names)}allowed: {', '.join(names)}"
                if names
                else "the scenario has no `sensors`"
            )
            yield "sensor", f"unknown sensor '{self.sensor}': {known}"
            return
        sensor = sensors[names.index(self.sensor)]
        able = [each.title for each in measuring(sensors)]
        if self.sensor not in able:
            yield (
                "sensor",
                f"sensor '{self.sensor}' of the type {sensor.type} measures nothing that an event can disturb: its "
                f"images show the recorded states; allowed: {', '.join(able) or 'none of this scenario'}",
            )
            return
        yield from self.check_one(sensor, cables)

    def check_one(self, sensor: Sensor, cables: int) -> Iterator[tuple[str, str]]:
        """Yield the key and text of problems with its sensor."""
        return iter(())


class SensorLoss(SensorEvent):
    """Time in which a sensor takes no measurements; its random numbers and those of later ones do not change."""

    duration: Positive | None = Field(
        None, description="duration; default: until the end of the run", json_schema_extra=unit("s")
    )

    def check_steps(self, step: float) -> Iterator[tuple[str, str]]:
        """Yield a problem if it is shorter than a control step."""
        if self.duration is not None and self.duration < step * (1.0 - 1e-9):
            yield "duration", f"must be at least control_step, {exact(step)} (s), got {exact(self.duration)}"

    def actions(self, step: float) -> Iterator[tuple[float, Action]]:
        """Yield the beginning and the end of the loss."""

        def lose(drives: EventActions) -> None:
            drives.disturb(self.sensor, Disturbance(lost=1))

        def recover(drives: EventActions) -> None:
            drives.disturb(self.sensor, Disturbance(lost=-1))

        yield self.time, lose
        if self.duration is not None:
            yield self.time + self.duration, recover

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield the loss, with its end."""
        end = None
        if self.duration is not None:
            end = min(first_sample(self.time + self.duration, step), samples - 1) * step
        yield Event(first_sample(self.time, step) * step, self.type, f"sensor '{self.sensor}' {self.happening}", end)

    @property
    @abstractmethod
    def happening(self) -> str:
        """Description of the event."""
