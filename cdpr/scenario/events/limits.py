"""Event that changes tension limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal

from pydantic import Field, model_validator

from cdpr.base.fields import Number, unit
from cdpr.base.needs import Needs, of_event
from cdpr.config.problems import exact
from cdpr.log.event import Event
from cdpr.scenario.events.event import Action, CableEvent, EventActions, History, first_sample


class TensionLimits(CableEvent):
    """Change of tension limits. Broken and jammed cables keep their tension.

    Changes at the same time apply together, independent of the order of events.
    """

    needs: ClassVar[Needs] = of_event()
    changes_limits: ClassVar[bool] = True

    type: Literal["limits"] = Field(
        default_factory=lambda: "limits", description="the tension limits of one cable or of all change"
    )
    cable: str | int | None = Field(None, description="name of the cable, or its number from 1; default: all")
    min: Number | None = Field(
        None, description="lowest admissible tension; default: unchanged", json_schema_extra=unit("N")
    )
    max: Number | None = Field(
        None, description="highest admissible tension; default: unchanged", json_schema_extra=unit("N")
    )

    @model_validator(mode="after")
    def _something(self) -> TensionLimits:
        if self.min is None and self.max is None:
            raise ValueError("min or max is missing, or both: the new limits (N)")
        return self

    def follow(self, history: History) -> Iterator[str]:
        """Yield problems: a faulty cable, or a different change at the same time."""
        yield from super().follow(history)
        for name in self._cables(history):
            text = self._change(name, history)
            if text:
                yield text
                return  # wrong limits of all cables are one problem

    def settle(self, history: History) -> Iterator[str]:
        """Yield contradicting limits of a cable, if this event was the last to change them."""
        for name in self._cables(history):
            text = self._contradiction(history, name) if history.set_by.get(name) is self else ""
            if text:
                yield text
                return

    def actions(self, step: float) -> Iterator[tuple[float, Action]]:
        """Yield the change of limits at its time."""
        cable = None if self.cable is None else str(self.cable)

        def change(drives: EventActions) -> None:
            drives.limit(cable, self.min, self.max)

        yield self.time, change

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield the changed limits."""
        limits = [f"{key} {value:g} N" for key, value in self._given().items()]
        text = f"the tension limits of {self._whose()} become {', '.join(limits)}"
        yield Event(first_sample(self.time, step) * step, self.type, text)

    def _whose(self) -> str:
        return "all cables" if self.cable is None else f"cable '{self.cable}'"

    def _given(self) -> dict[str, float]:
        return {key: value for key, value in (("min", self.min), ("max", self.max)) if value is not None}

    def _cables(self, history: History) -> tuple[str, ...]:
        """Return the cables whose limits change; () if limits are unknown."""
        present = history.limits or {}
        return tuple(present) if self.cable is None else (str(self.cable),) if present else ()

    def _change(self, name: str, history: History) -> str:
        """Change the limits of one cable in the history; return a conflict with another event, or ""."""
        twice = ""
        for key, value in self._given().items():
            before, other = history.set_at.get((name, key), (-1.0, ""))
            if before == self.time and not twice:
                both = f"becomes {exact(value)} N, and {other} by another event at the same time, {exact(before)} s"
                twice = f"{key} of cable '{name}' {both}: leave one of them out"
            history.set_at[name, key] = self.time, f"{exact(value)} N (of {self._whose()})"
        assert history.limits is not None
        low, high = history.limits[name]
        history.limits[name] = low if self.min is None else self.min, high if self.max is None else self.max
        if not twice:
            history.set_by[name] = self
        return twice

    def _contradiction(self, history: History, name: str) -> str:
        assert history.limits is not None
        low, high = history.limits[name]
        if history.unilateral and low < 0:
            return f"min must be at least 0 (N), got {exact(low)}: a cable cannot push"
        if low > high or high <= 0:
            found = f"{exact(low)} to {exact(high)}"
            return f"cable '{name}' would have the limits {found} (N): min must not exceed max, max be positive"
        return ""
