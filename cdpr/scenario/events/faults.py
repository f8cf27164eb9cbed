"""Faults of cables: they no longer follow commands."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal

from pydantic import Field

from cdpr.base.fields import NonNegative, Positive, unit
from cdpr.base.needs import Needs, of_event
from cdpr.config.problems import exact
from cdpr.log.event import Event
from cdpr.scenario.events.event import Action, CableEvent, EventActions, History, first_sample


class CableFault(CableEvent):
    """Fault of a cable, which no longer follows commands.

    Attributes:
        fate: state of the cable after the fault.
        left: its tension after the fault, N; None for that of the previous sample.
    """

    ideal_cables_only: ClassVar[bool] = True
    overrides: ClassVar[bool] = True
    wants_tensions: ClassVar[bool] = True
    fate: ClassVar[str]
    left: ClassVar[float | None]

    cable: str | int = Field(description="name of the cable, or its number, counted from 1")
    detected_after: NonNegative = Field(
        0.0,
        description="delay until the tension distribution detects it, and includes the remaining tension of the cable; "
        "the plant is affected at once",
        json_schema_extra=unit("s"),
    )

    def follow(self, history: History) -> Iterator[str]:
        """Yield a problem if the cable already has a fault that excludes this one."""
        wrong = list(super().follow(history))
        if not wrong:
            history.fate[str(self.cable)] = (self.fate, self.time)
        yield from wrong

    def actions(self, step: float) -> Iterator[tuple[float, Action]]:
        """Yield the fault of the plant at its time, and its detection by the distribution later."""
        cable = str(self.cable)

        def happen(drives: EventActions) -> None:
            drives.hold(cable, self.left)

        def detect(drives: EventActions) -> None:
            drives.lock(cable)

        yield self.time, happen
        yield self.time + self.detected_after, detect

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield the fault, and its detection by the distribution."""
        time = first_sample(self.time, step) * step
        learns = first_sample(self.time + self.detected_after, step)
        known = learns * step
        text = f"cable '{self.cable}' {self._happening(tension)}" + ("" if known > time else ", detected at once")
        yield Event(time, self.type, text, cable=str(self.cable))
        if known > time and learns < samples:
            yield Event(known, "detected", f"the distribution detects that cable '{self.cable}' is {self.fate}")

    @abstractmethod
    def _happening(self, tension: Mapping[str, float]) -> str:
        """Return a description of the fault."""


class CableBreak(CableFault):
    """Cable break: the tension is 0 from then on."""

    needs: ClassVar[Needs] = of_event()
    breaks: ClassVar[bool] = True
    fate: ClassVar[str] = "broken"
    left: ClassVar[float | None] = 0.0

    type: Literal["cable_break"] = Field(
        default_factory=lambda: "cable_break", description="a cable breaks: its tension is 0 from then on"
    )

    def possible(self, fate: str) -> bool:
        """Return True if the event can happen to a cable in this state; a jammed cable may break."""
        return fate != self.fate

    def _happening(self, tension: Mapping[str, float]) -> str:
        return "breaks"


class CableJam(CableFault):
    """Cable jam: the tension keeps its previous value, independent of commands and power."""

    needs: ClassVar[Needs] = of_event()
    fate: ClassVar[str] = "jammed"
    left: ClassVar[float | None] = None

    type: Literal["cable_jam"] = Field(
        default_factory=lambda: "cable_jam",
        description="a cable's tension freezes at that of the sample before; it stays so whatever is commanded, also "
        "without power, until the cable breaks",
    )
    time: Positive = Field(
        description="time of the event: it acts from the first sample at or after this time",
        json_schema_extra=unit("s"),
    )

    def check_steps(self, step: float) -> Iterator[tuple[str, str]]:
        """Yield a problem if there is no previous sample."""
        if first_sample(self.time, step) < 1:
            early = exact(self.time)
            text = f"must be at least control_step, {exact(step)} (s), because there is no tension before, got {early}"
            yield "time", text

    def _happening(self, tension: Mapping[str, float]) -> str:
        found = tension.get(str(self.cable))
        return "jams" if found is None else f"jams at {found:.5g} N"
