"""Background of time histories: time range, and intervals without valid solver results."""

from __future__ import annotations

from typing import NamedTuple

from cdpr.log.run import Run
from cdpr.scene import colours
from cdpr.tension import Status
from cdpr.ui.report.plots.decimate import intervals
from cdpr.ui.report.plots.histories import histories
from cdpr.ui.report.style import SHADES

FEW = 25  # runs with at most this number of samples are drawn with dots


def span(run: Run) -> tuple[float, float]:
    """Return the range of the time axis, s, never empty, with a margin for the dots of short runs."""
    room = 0.5 * run.header.log_step if len(run.rows) <= FEW else 0.0
    start, stop = run.span
    return start - room, stop + room


class Shade(NamedTuple):
    """Time intervals with the same shading."""

    name: str
    colour: colours.Pair
    intervals: list[tuple[float, float]]  # s


def shades(run: Run) -> list[Shade]:
    """Return the intervals without valid solver results."""
    found = (Shade(name, colours.SHADES[status], shaded(run, status)) for status, name in SHADES.items())
    return [shade for shade in found if shade.intervals]


def shaded(run: Run, status: Status) -> list[tuple[float, float]]:
    """Return the intervals (s) with this solver status, each wide enough to be visible."""
    step, last = run.header.log_step, run.span[1]
    found = []
    for first, end in intervals(histories(run).status == status):
        start = min(first * step, last)
        found.append((start, start + step * (end - first)))
    return found
