"""Events of a run."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Event:
    """Event in a run."""

    time: float  # s
    kind: str  # "infeasible", "diverged", "stopped", "interrupted", ...
    text: str
    until: float | None = None  # s, end of an interval
    cable: str | None = None  # affected cable

    @property
    def when(self) -> str:
        """Time or interval, s, as text; one time if both ends are equal."""
        begin, end = (f"{time:.6g}" for time in (self.time, self.time if self.until is None else self.until))
        return begin if begin == end else f"{begin} to {end}"
