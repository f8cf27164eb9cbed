"""External wrenches: pushes, steps, constant loads and sines."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar, Literal

from pydantic import Field, model_validator

from cdpr.base.fields import ZERO, NonNegative, Number, Positive, Vector3, unit
from cdpr.base.needs import Needs, of_event
from cdpr.config.problems import exact
from cdpr.log.event import Event
from cdpr.scenario.events.event import ScenarioEvent, WrenchProfile, first_sample

QUARTER = 0.5 * math.pi  # phase of a constant load


class Load(ScenarioEvent):
    """Force and moment on the platform. Simultaneous loads add up."""

    time: NonNegative = Field(
        0.0,
        description="start: it acts from the first sample at or after this time",
        json_schema_extra=unit("s"),
    )
    duration: Positive | None = Field(
        None,
        description="duration, at least control_step; default: until the end of the run",
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

    def check_steps(self, step: float) -> Iterator[tuple[str, str]]:
        """Yield a problem if it is shorter than a control step."""
        if self.duration is not None and self.duration < step * (1.0 - 1e-9):
            held = exact(self.duration)
            text = (
                f"must be at least control_step, {exact(step)} (s), because it is held for a control step, got {held}"
            )
            yield "duration", text

    def wrench_profile(self, step: float) -> WrenchProfile:
        """Return the wrench."""
        end = math.inf if self.duration is None else float(first_sample(self.time + self.duration, step))
        return WrenchProfile(first_sample(self.time, step), end, *self._oscillation(step), (*self.force, *self.moment))

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield the wrench and its end."""
        end = None
        if self.duration is not None:
            end = min(first_sample(self.time + self.duration, step), samples - 1) * step
        text = f"external force {_list(self.force)} N, moment {_list(self.moment)} N m{self._suffix()}"
        yield Event(first_sample(self.time, step) * step, self.type, text, end)

    def _oscillation(self, step: float) -> tuple[float, float]:
        """Return the angle per sample and the phase, rad."""
        return 0.0, QUARTER

    def _suffix(self) -> str:
        return ""


class Wrench(Load):
    """Constant wrench: a push if it has a duration, otherwise a step; from time 0 on a constant load."""

    needs: ClassVar[Needs] = of_event()
    type: Literal["wrench"] = Field(
        default_factory=lambda: "wrench", description="a constant force and moment on the platform"
    )


class Sine(Load):
    """Sinusoidal wrench: force and moment times sin(2 pi frequency (t - begin) + phase)."""

    needs: ClassVar[Needs] = of_event()
    type: Literal["sine"] = Field(
        default_factory=lambda: "sine",
        description="a force and moment on the platform that swing as a sine; sampled, and held over each control step",
    )
    frequency: Positive = Field(
        description="frequency, less than half of the control rate", json_schema_extra=unit("Hz")
    )
    phase: Number = Field(0.0, description="phase at its first sample", json_schema_extra=unit("rad"))
    phase_deg: Number | None = Field(
        None, description="the same in degrees, in place of it", json_schema_extra=unit("deg")
    )

    @model_validator(mode="after")
    def _one_unit(self) -> Sine:
        if self.phase_deg is not None and self.phase != 0.0:
            raise ValueError("expected at most one of phase (rad) and phase_deg (deg)")
        return self

    def check_steps(self, step: float) -> Iterator[tuple[str, str]]:
        """Yield a problem if the frequency cannot be sampled."""
        yield from super().check_steps(step)
        if self.frequency * step >= 0.5:
            text = f"must be less than half of the control rate, {0.5 / step:g} (Hz), got {exact(self.frequency)}"
            yield "frequency", text

    def _oscillation(self, step: float) -> tuple[float, float]:
        phase = self.phase if self.phase_deg is None else math.radians(self.phase_deg)
        return 2.0 * math.pi * self.frequency * step, phase

    def _suffix(self) -> str:
        return f" times a sine of {self.frequency:g} Hz"


def _list(values: Sequence[float]) -> str:
    return "[" + ", ".join(f"{value:g}" for value in values) + "]"
