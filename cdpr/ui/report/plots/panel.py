"""Content of a plot over time, independent of the drawing backend: curves, limits and a legend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.model.robot import Array
from cdpr.ui.report.plots.histories import Points
from cdpr.ui.report.style import SOFT, shorten

LARGEST = 1e307  # largest value that determines a range, so that the range is finite

# Smallest range of an axis, relative to the values. Smaller differences are invisible in three digits; zooming in would
# show round-off and solver noise as if they were results.
LEAST_SHARE = 1e-4
LEAST_ROOM = 1e-15  # if all values are zero

Entry = tuple[str, dict[str, Any]]  # text of a legend entry, and style of its sample line


@dataclass(frozen=True)
class Curves:
    """Lines of one width: the columns of a quantity, with repeating colours and dashes."""

    points: Points
    colours: Sequence[str]
    dashes: Sequence[Any] = ("-",)
    width: float = 1.2
    names: Sequence[str] = ()  # of the columns
    group: str = ""  # kind of the columns: "cable", ..., shared with other panels; "band": one legend entry for all

    @classmethod
    def of(cls, points: Points, name: str, look: dict[str, Any]) -> Curves:
        """Return one line with a style of `overlaid_looks`."""
        kind = look["thing"].partition(":")[0]
        return cls(points, (look["color"],), (look["linestyle"],), look["linewidth"], (name,), kind)

    def thing(self, name: str) -> dict[str, str]:
        """Return the `thing` of column `name`, if it has the same colour throughout a page."""
        return {"thing": f"{self.group}:{name}"} if self.group not in ("", "over", "band") and name else {}


@dataclass(frozen=True)
class Limit:
    """Horizontal lines, drawn only if they do not flatten the curves; otherwise they are in the legend."""

    label: str
    values: Sequence[float]
    colours: Sequence[str] = (SOFT,)


@dataclass(frozen=True)
class Panel:
    """Axes with curves.

    The vertical axis never spans less than `least`, so that round-off does not fill a panel.
    """

    label: str  # quantity and unit
    curves: tuple[Curves, ...]
    legend: Sequence[Entry] = ()
    least: float = 0.0
    limits: tuple[Limit, ...] = ()
    log: bool = False
    height: float = 1.55  # in
    name: str = ""  # name for `Run.plot`

    @property
    def entries(self) -> Sequence[Entry]:
        """The panel's legend, or one made from its lines if another panel's legend explains them."""
        if self.legend:
            return self.legend
        lines: list[Entry] = []
        for curves in self.curves:
            looks = zip(curves.names, cycle(curves.colours), cycle(curves.dashes), strict=False)
            width = curves.width
            lines += [
                (shorten(name), {"color": colour, "linestyle": dashes, "linewidth": width})
                for name, colour, dashes in looks
            ]
        return lines if len(lines) > 1 else ()


def calm_until(run: Run) -> float | None:
    """Return the time (s) up to which a diverged run determines the range of an axis; None for other runs."""
    return run.span[0] + 0.75 * (run.span[1] - run.span[0]) if run.status == "diverged" else None


def view(panel: Panel, calm: float | None) -> tuple[float, float, str]:
    """Return the range of the vertical axis, and a note if it does not contain all values.

    A diverged run ends in values that would flatten all earlier ones. Its range is that of the values before the time
    `calm` (s), widened.
    """
    values = np.concatenate([shown(panel, curves).ravel() for curves in panel.curves])
    low, high = _range(values)
    note = ""
    if calm is not None:
        times = np.concatenate([curves.points.time.ravel() for curves in panel.curves])
        before, after = _range(values[times < calm])
        room = max(after - before, panel.least)
        if high - low > 10.0 * room > 0.0:
            note = f"out of view: up to {max(-low, high):.2g}"
            low, high = max(low, before - room), min(high, after + room)
    room = room_for(low, high, panel.least)
    for value in (value for limit in panel.limits for value in limit.values):
        if low - 1.5 * room <= value <= high + 1.5 * room:
            low, high = min(low, value), max(high, value)
    padding = 0.06 * (high - low) + 0.5 * max(room - (high - low), 0.0)
    return low - padding, high + padding, note


def room_for(low: float, high: float, least: float = 0.0) -> float:
    """Return the smallest axis range for values from `low` to `high`."""
    return max(high - low, least, LEAST_SHARE * max(abs(low), abs(high)), LEAST_ROOM)


def shown(panel: Panel, curves: Curves) -> Array:
    """Return the values, or for a logarithmic axis their decadic logarithms, with 0 replaced by 1e-16."""
    values = curves.points.values
    return np.log10(np.maximum(values, 1e-16)) if panel.log else values


def _range(values: Array) -> tuple[float, float]:
    finite = np.clip(values[np.isfinite(values)], -LARGEST, LARGEST)
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
