"""An eyelet: the cable leaves the frame at its anchor, wherever it goes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from pydantic import Field

from cdpr.cables.exit import Exit


class Point(Exit):
    """The anchor itself."""

    type: Literal["point"] = Field(description="the cable leaves at its anchor, whatever its direction")

    def numbers(self) -> Sequence[float]:
        """Return nothing."""
        return ()

    def outline(self, frame: Sequence[float], leaving: Sequence[float]) -> list[list[float]]:
        """Return nothing to draw."""
        return []
