"""What is told of a run beside its rows."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Event:
    """Something that happened in a run."""

    time: float  # s
    kind: str  # "infeasible", "diverged", "stopped", "interrupted", ...
    text: str
    until: float | None = None  # s, where it lasted
    cable: str | None = None  # the one that it concerns
