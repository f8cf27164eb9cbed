"""Clearances of the rows of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.log.layout import Layout
from cdpr.model.robot import Array

if TYPE_CHECKING:
    from cdpr.mechanics.closest import Closest


def add_rows(closest: Closest, layout: Layout, rows: Array) -> None:
    """Add rows (n, width) to the clearances; cables that sag are curves if the rows contain their lengths."""
    unwound = rows[:, layout.columns["unstretched_length"]] if layout.has("sagging") else None
    closest.add(rows[:, 0], rows[:, layout.span("position", "orientation")], unwound)
