"""User options of an import."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Choice:
    """Selection among alternatives in a source.

    Attributes:
        cable_set: cable set of a CASPR model; None for its default.
        trajectory: trajectory file for a robot of the Gazebo plug-in.
        tension: lowest and highest tension, N, for cables without limits.
    """

    cable_set: str | None = None
    trajectory: Path | None = None
    tension: tuple[float, float] | None = None
