"""Bump of a sensor: its mount moves, or its bias jumps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from cdpr.base.fields import ZERO, Number, Position, Vector3, unit
from cdpr.base.nearest import did_you_mean
from cdpr.base.needs import Needs, of_event
from cdpr.log.event import Event
from cdpr.scenario.events.event import Action, EventActions, first_sample
from cdpr.scenario.events.sensor_event import SensorEvent
from cdpr.sensing import SENSORS, Sensor
from cdpr.sensing.disturbance import Disturbance


class SensorBump(SensorEvent):
    """Bump of a sensor: its mount moves by `position` and `rotation`, or one of its quantities gets another bias.

    Example:
        >>> import cdpr
        >>> cdpr.events.SensorBump(time=1.0, sensor="encoders", bias=0.005).bias
        0.005
    """

    needs: ClassVar[Needs] = of_event()
    type: Literal["sensor_bump"] = Field(
        default_factory=lambda: "sensor_bump", description="a sensor is bumped: its mount moves, or its bias jumps"
    )
    position: Position = Field(
        ZERO,
        description="movement of the mount, axes of the body that carries it; only for sensors with a mount",
        json_schema_extra=unit("m"),
    )
    rotation: Vector3 = Field(
        ZERO,
        description="rotation vector of the mount about its place, likewise; not for receivers",
        json_schema_extra=unit("rad"),
    )
    bias: Number | tuple[Number, ...] | None = Field(
        None, description="what is added to the bias of a quantity: one value, or one for each component"
    )
    quantity: str | None = Field(None, description="quantity with this bias; default: the first one of the sensor")

    @model_validator(mode="after")
    def _something(self) -> Self:
        if not {"position", "rotation", "bias"} & self.model_fields_set:
            raise ValueError("expected at least one of position (m), rotation (rad) and bias")
        if self.quantity is not None and self.bias is None:
            raise ValueError("quantity without bias: add bias, or remove quantity")
        return self

    def check_one(self, sensor: Sensor, cables: int) -> Iterator[tuple[str, str]]:
        """Yield movements that the sensor cannot make, an unknown quantity, or a bias of a wrong length."""
        for key, parts, needed in (("position", "place", "mount"), ("rotation", "axes", "mount with axes")):
            if any(getattr(self, key)) and parts not in sensor.mount:
                able = ", ".join(kind for kind in SENSORS if parts in SENSORS[kind].mount)
                text = f"sensor '{sensor.title}' of the type {sensor.type} has no {needed}; allowed for: {able}. "
                yield key, f"{text}Use `bias` instead"
        if self.bias is None:
            return
        biased = {each.key: each for each in sensor.with_errors if each.key in type(sensor).model_fields}  # not flags
        key = self.quantity or next(iter(biased))
        if key not in biased:
            yield "quantity", f"unknown quantity '{key}': {did_you_mean(key, biased)}allowed: {', '.join(biased)}"
            return
        count = biased[key].components(cables)
        if isinstance(self.bias, tuple) and len(self.bias) != count:
            yield "bias", f"expected one number, or {count} numbers, got {len(self.bias)}"

    def actions(self, step: float) -> Iterator[tuple[float, Action]]:
        """Yield the bump at its time."""
        bias = self.bias if isinstance(self.bias, tuple) else () if self.bias is None else (self.bias,)
        change = Disturbance(bias=bias, quantity=self.quantity or "", position=self.position, rotation=self.rotation)

        def bump(drives: EventActions) -> None:
            drives.disturb(self.sensor, change)

        yield self.time, bump

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield the changes."""
        moved = [
            f"its mount {verb} by [{', '.join(f'{value:g}' for value in vector)}] {symbol}"
            for verb, vector, symbol in (("moves", self.position, "m"), ("rotates", self.rotation, "rad"))
            if any(vector)
        ]
        if self.bias is not None:
            values = self.bias if isinstance(self.bias, tuple) else (self.bias,)
            changes = ", ".join(f"{value:+g}" for value in values)
            moved.append(f"bias{(self.quantity and f' of {self.quantity}') or ''} {changes}")
        text = f"sensor '{self.sensor}' is bumped: {'; '.join(moved) or 'without effect'}"
        yield Event(first_sample(self.time, step) * step, self.type, text)
