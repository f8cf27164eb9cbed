"""What a plot over time shows, whatever draws it: curves, limits and a legend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.model.robot import Array
from cdpr.report.marks import SOFT, shorten
from cdpr.report.plots.histories import Points

LARGEST = 1e307  # of the values that tell a range, which is a number then

# Of the size of what is drawn, the share that an axis spans at least. What differs by less looks alike to whoever reads
# three digits; an axis zoomed into it would show round-off, and what solvers leave to chance, as if it were a result.
LEAST_SHARE = 1e-4
LEAST_ROOM = 1e-15  # where all is zero

Entry = tuple[str, dict[str, Any]]  # text of a legend, and how the sample line looks


@dataclass(frozen=True)
class Curves:
    """Lines of one width: the columns of a quantity, with colours and dashes that repeat."""

    points: Points
    colours: Sequence[str]
    dashes: Sequence[Any] = ("-",)
    width: float = 1.2
    names: Sequence[str] = ()  # of the columns
    group: str = ""  # what the columns are, where other panels have the same: "cable", ...

    @classmethod
    def of(cls, points: Points, name: str, look: dict[str, Any]) -> Curves:
        """Return one line with a look of `overlaid_looks`."""
        kind = look["thing"].partition(":")[0]
        return cls(points, (look["color"],), (look["linestyle"],), look["linewidth"], (name,), kind)

    def thing(self, name: str) -> dict[str, str]:
        """Return which thing the column `name` stands for, if it has one colour throughout a page."""
        return {"thing": f"{self.group}:{name}"} if self.group not in ("", "over") and name else {}


@dataclass(frozen=True)
class Limit:
    """Horizontal lines, drawn only where they do not squash the curves; the legend says so if not."""

    label: str
    values: Sequence[float]
    colours: Sequence[str] = (SOFT,)


@dataclass(frozen=True)
class Panel:
    """One pair of axes.

    The vertical axis never spans less than `least`, so that round-off does not fill a panel.
    """

    label: str  # quantity and unit
    curves: tuple[Curves, ...]
    legend: Sequence[Entry] = ()
    least: float = 0.0
    limits: tuple[Limit, ...] = ()
    log: bool = False
    height: float = 1.55  # in
    name: str = ""  # by which `Run.plot` draws it alone

    @property
    def entries(self) -> Sequence[Entry]:
        """Its legend; where it has none of its own because another panel's explains it, that of its lines."""
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
    """Time (s) up to which a run that diverged tells the range of an axis; None for any other."""
    return run.span[0] + 0.75 * (run.span[1] - run.span[0]) if run.status == "diverged" else None


def view(panel: Panel, calm: float | None) -> tuple[float, float, str]:
    """Return the range of the vertical axis, and a note where it does not hold all.

    A run that diverged ends in values that would flatten all that led to them: there the range is that of its
    first three quarters, to the time `calm`, s, widened.
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
    """Return what an axis spans at least that shows values from `low` to `high`."""
    return max(high - low, least, LEAST_SHARE * max(abs(low), abs(high)), LEAST_ROOM)


def shown(panel: Panel, curves: Curves) -> Array:
    """Return the values or, for a logarithmic axis, their powers of ten; there 0 counts as 1e-16."""
    values = curves.points.values
    return np.log10(np.maximum(values, 1e-16)) if panel.log else values


def _range(values: Array) -> tuple[float, float]:
    finite = np.clip(values[np.isfinite(values)], -LARGEST, LARGEST)
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
