"""The sections of what happens to a robot during a run.

Each acts at the first sample at or after its time, k * control_step, and from then on whatever the engine: nothing
happens within a control step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field, model_validator

from cdpr.scenario.fields import ZERO, NonNegative, Number, Positive, Section, Vector3, unit

MAX_EVENTS = 1000
ROUNDING = 1e-9  # of a step: times are decimal fractions, which floats miss by rounding


def first_sample(time: float, step: float) -> int:
    """Return the number of the first sample at or after `time` (s); `step` is the time between two (s)."""
    return math.ceil(time / step - ROUNDING * max(1.0, time / step))


class Event(Section):
    """Something that happens at a time."""

    type: str
    time: NonNegative = Field(
        description="when it happens: it acts from the first sample at or after this time", json_schema_extra=unit("s")
    )


class Load(Event):
    """A force and a moment on the platform. Those that act at the same time add up."""

    time: NonNegative = Field(
        0.0,
        description="when it begins: it acts from the first sample at or after this time",
        json_schema_extra=unit("s"),
    )
    duration: Positive | None = Field(
        None,
        description="how long it acts, at least control_step; until the end of the run unless said",
        json_schema_extra=unit("s"),
    )
    force: Vector3 = Field(
        ZERO,
        description="force at the platform's origin, world axes; of a sine the amplitude",
        json_schema_extra=unit("N"),
    )
    moment: Vector3 = Field(
        ZERO, description="moment, world axes; of a sine the amplitude", json_schema_extra=unit("N m")
    )

    @model_validator(mode="after")
    def _something(self) -> Load:
        if not {"force", "moment"} & self.model_fields_set:
            raise ValueError("force (N) or moment (N m) is missing, or both: three numbers each, world axes")
        return self


class Wrench(Load):
    """A constant wrench: with a duration a push, without one a step, from time 0 a constant load."""

    type: Literal["wrench"] = Field(description="a constant force and moment on the platform")


class Sine(Load):
    """A wrench that swings: force and moment times sin(2 pi frequency (t - begin) + phase)."""

    type: Literal["sine"] = Field(
        description="a force and moment on the platform that swing as a sine; sampled, and held over each control step"
    )
    frequency: Positive = Field(
        description="frequency, less than half of the control rate", json_schema_extra=unit("Hz")
    )
    phase: Number = Field(0.0, description="phase at its first sample", json_schema_extra=unit("rad"))


class CableFault(Event):
    """A cable that no longer does what it is told."""

    cable: str | int = Field(description="name of the cable, or its number, counted from 1")
    detected_after: NonNegative = Field(
        0.0,
        description="how much later the tension distribution knows of it, and reckons with the tension that the cable "
        "has left; the plant feels it at once",
        json_schema_extra=unit("s"),
    )


class CableBreak(CableFault):
    """A cable breaks: its tension is 0 from then on."""

    type: Literal["cable_break"] = Field(description="a cable breaks: its tension is 0 from then on")


class CableJam(CableFault):
    """A cable's tension stays what it was at the sample before, whatever is commanded; also without power."""

    type: Literal["cable_jam"] = Field(
        description="a cable's tension freezes at that of the sample before; it stays so whatever is commanded, also "
        "without power, until the cable breaks"
    )
    time: Positive = Field(
        description="when it happens: it acts from the first sample at or after this time", json_schema_extra=unit("s")
    )


class TensionLimits(Event):
    """The tension limits change. Cables that are broken or jammed keep what they have."""

    type: Literal["limits"] = Field(description="the tension limits of one cable or of all change")
    cable: str | int | None = Field(None, description="name of the cable, or its number from 1; all unless said")
    min: Number | None = Field(
        None, description="lowest admissible tension; unchanged unless said", json_schema_extra=unit("N")
    )
    max: Number | None = Field(
        None, description="highest admissible tension; unchanged unless said", json_schema_extra=unit("N")
    )

    @model_validator(mode="after")
    def _something(self) -> TensionLimits:
        if self.min is None and self.max is None:
            raise ValueError("min or max is missing, or both: the new limits (N)")
        return self


class EmergencyStop(Event):
    """The robot stops, in the sense of the stop categories of IEC 60204-1."""

    type: Literal["emergency_stop"] = Field(description="the robot is stopped")
    category: int = Field(
        2,
        ge=0,
        le=2,
        description="stop category of IEC 60204-1: 2 slows down along the path, then holds the pose; 1 does so and "
        "then cuts the power; 0 cuts it at once. Without power all tensions are 0, and the controller and the "
        "distribution are off",
    )
    stopping_time: Positive = Field(
        0.5,
        description="time from the motion to rest (categories 1 and 2): the pace along the path falls to 0 smoothly, "
        "as 1 - 3 s^2 + 2 s^3 with s from 0 to 1, so half this time of the motion is still covered",
        json_schema_extra=unit("s"),
    )


ScenarioEvent = Wrench | Sine | CableBreak | CableJam | TensionLimits | EmergencyStop
AnyEvent = Annotated[ScenarioEvent, Field(discriminator="type")]


def broken(events: Sequence[ScenarioEvent], cables: Sequence[str], step: float) -> tuple[tuple[int, float], ...]:
    """Return which of the `cables` break, counted from 0, and the times (s) of the samples from which they are."""
    breaks = [event for event in events if isinstance(event, CableBreak)]
    return tuple((cables.index(str(event.cable)), first_sample(event.time, step) * step) for event in breaks)
