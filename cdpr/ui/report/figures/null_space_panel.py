"""Common parts of one- and two-dimensional null-space figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.model.robot import Array
from cdpr.scene import colours
from cdpr.ui.report.figures.canvas import Axes, Chart

GOOD, BAD, ADMISSIBLE = colours.GOOD.light, colours.BAD.light, colours.ADMISSIBLE.light
LABEL: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.7, "alpha": 0.85}


@dataclass(frozen=True, eq=False)
class Group:
    """Results that coincide."""

    x: Array  # (r,)
    solvers: list[str]
    admissible: bool


@dataclass(frozen=True, eq=False)
class Panel:
    """Axes with their window in x and their size in inches."""

    axes: Axes
    low: Array  # (r,)
    high: Array
    size: Array  # (2,)

    def shows(self, x: Array) -> bool:
        """Return True if the window contains x."""
        return bool(np.all((x >= self.low) & (x <= self.high)))


def write_badge(on: Axes | Chart, point: tuple[float, float], number: int, good: bool, transform: Any) -> None:
    """Draw a number in a circle."""
    colour = GOOD if good else BAD
    look = {"boxstyle": "circle,pad=0.22", "facecolor": "white", "edgecolor": colour, "linewidth": 1.0}
    on.text(
        *point, str(number), transform=transform, ha="center", va="center", fontsize=7.5, color=colour,
        fontweight="bold", zorder=8, bbox=look,
    )  # fmt: skip
