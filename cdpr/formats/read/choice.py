"""What a user says beside the file that is imported."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Choice:
    """What to take where a source offers several.

    Attributes:
        cable_set: of CASPR; its default unless said.
        trajectory: a file that belongs to the robot, of the Gazebo plug-in.
        tension: lowest and highest tension, N, of cables whose file limits none.
    """

    cable_set: str | None = None
    trajectory: Path | None = None
    tension: tuple[float, float] | None = None
