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
