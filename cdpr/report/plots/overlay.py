"""What lies under every time history: the span of time, and where the solver had no valid answer."""

from __future__ import annotations

from typing import NamedTuple

from cdpr.log.run import Run
from cdpr.report.marks import SHADES
from cdpr.report.plots.decimate import intervals
from cdpr.report.plots.histories import histories
from cdpr.tension import Status
from cdpr.view import colours

FEW = 25  # samples that are drawn as dots


def span(run: Run) -> tuple[float, float]:
    """Range of the time axis, s: never empty, and with room for the dots of a run of a few samples."""
    room = 0.5 * run.header.log_step if len(run.rows) <= FEW else 0.0
    start, stop = run.span
    return start - room, stop + room


class Shade(NamedTuple):
    """Intervals of time that are shaded alike."""

    name: str
    colour: colours.Pair
    intervals: list[tuple[float, float]]  # s


def shades(run: Run) -> list[Shade]:
    """Return where the solver had no valid answer."""
    found = (Shade(name, colours.SHADES[status], shaded(run, status)) for status, name in SHADES.items())
    return [shade for shade in found if shade.intervals]


def shaded(run: Run, status: Status) -> list[tuple[float, float]]:
    """Return the intervals (s) in which the solver's answers were of this status, wide enough to be seen."""
    step, last = run.header.log_step, run.span[1]
    found = []
    for first, end in intervals(histories(run).status == status):
        start = min(first * step, last)
        found.append((start, start + step * (end - first)))
    return found
