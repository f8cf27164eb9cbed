"""Cables that no longer do what they are told."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal

from pydantic import Field

from cdpr.fields import NonNegative, Positive, unit
from cdpr.log.event import Event
from cdpr.scenario.events.event import Action, CableEvent, Drives, History, first_sample
from cdpr.scenario.problems import exact


class CableFault(CableEvent):
    """A cable that no longer does what it is told.

    Attributes:
        fate: what has become of the cable.
        left: the tension that it has from then on, N; None for that of the sample before.
    """

    ideal_cables_only: ClassVar[bool] = True
    overrides: ClassVar[bool] = True
    wants_tensions: ClassVar[bool] = True
    fate: ClassVar[str]
    left: ClassVar[float | None]

    cable: str | int = Field(description="name of the cable, or its number, counted from 1")
    detected_after: NonNegative = Field(
        0.0,
        description="how much later the tension distribution knows of it, and reckons with the tension that the cable "
        "has left; the plant feels it at once",
        json_schema_extra=unit("s"),
    )

    def follow(self, history: History) -> Iterator[str]:
        """Yield where it cannot happen to the cable any more."""
        wrong = list(super().follow(history))
        if not wrong:
            history.fate[str(self.cable)] = (self.fate, self.time)
        yield from wrong

    def actions(self, step: float) -> Iterator[tuple[float, Action]]:
        """The plant feels it at its time, the distribution learns of it later."""
        cable = str(self.cable)

        def happen(drives: Drives) -> None:
            drives.hold(cable, self.left)

        def detect(drives: Drives) -> None:
            drives.lock(cable)

        yield self.time, happen
        yield self.time + self.detected_after, detect

    def tell(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Say what happens to the cable, and when the distribution learns of it."""
        time = first_sample(self.time, step) * step
        learns = first_sample(self.time + self.detected_after, step)
        known = learns * step
        text = f"cable '{self.cable}' {self._happening(tension)}" + ("" if known > time else ", known at once")
        yield Event(time, self.type, text, cable=str(self.cable))
        if known > time and learns < samples:
            yield Event(known, "detected", f"the distribution learns that cable '{self.cable}' is {self.fate}")

    @abstractmethod
    def _happening(self, tension: Mapping[str, float]) -> str:
        """What happens to the cable, in words."""


class CableBreak(CableFault):
    """A cable breaks: its tension is 0 from then on."""

    breaks: ClassVar[bool] = True
    fate: ClassVar[str] = "broken"
    left: ClassVar[float | None] = 0.0

    type: Literal["cable_break"] = Field(description="a cable breaks: its tension is 0 from then on")

    def possible(self, fate: str) -> bool:
        """Whether it may happen to a cable of this fate: one that is jammed may break."""
        return fate != self.fate

    def _happening(self, tension: Mapping[str, float]) -> str:
        return "breaks"


class CableJam(CableFault):
    """A cable's tension stays what it was at the sample before, whatever is commanded; also without power."""

    fate: ClassVar[str] = "jammed"
    left: ClassVar[float | None] = None

    type: Literal["cable_jam"] = Field(
        description="a cable's tension freezes at that of the sample before; it stays so whatever is commanded, also "
        "without power, until the cable breaks"
    )
    time: Positive = Field(
        description="when it happens: it acts from the first sample at or after this time", json_schema_extra=unit("s")
    )

    def check_steps(self, step: float) -> Iterator[tuple[str, str]]:
        """Yield where there is no sample before."""
        if first_sample(self.time, step) < 1:
            early = exact(self.time)
            text = f"must be at least control_step, {exact(step)} (s), for no tension is there before, got {early}"
            yield "time", text

    def _happening(self, tension: Mapping[str, float]) -> str:
        found = tension.get(str(self.cable))
        return "jams" if found is None else f"jams at {found:.5g} N"
