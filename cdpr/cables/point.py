"""Eyelet: the cable leaves the frame at its anchor in any direction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

from pydantic import Field

from cdpr.base.needs import EVERYWHERE, Needs
from cdpr.cables.exit import Exit


class Point(Exit):
    """Exit at the anchor."""

    needs: ClassVar[Needs] = EVERYWHERE
    type: Literal["point"] = Field(description="the cable leaves at its anchor, whatever its direction")

    def numbers(self) -> Sequence[float]:
        """Return an empty tuple."""
        return ()

    def outline(self, frame: Sequence[float], leaving: Sequence[float]) -> list[list[float]]:
        """Return an empty list."""
        return []
