"""What went wrong and when, drawn over every time history: shaded intervals and numbered events."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.report.figures.canvas import Axes, Line2D, Path, PathPatch
from cdpr.report.figures.legend import Entry
from cdpr.report.marks import INK, SHADES, events
from cdpr.report.plots.decimate import intervals
from cdpr.report.plots.histories import histories

CODES = (Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY)
EVENT: dict[str, Any] = {"color": INK, "linewidth": 0.8, "linestyle": ":"}
FEW = 25  # samples that are drawn as dots
APART = 0.07  # of the time axis: room that the number of an event needs


def span(run: Run) -> tuple[float, float]:
    """Range of the time axis, s: never empty, and with room for the dots of a run of a few samples."""
    room = 0.5 * run.header.log_step if len(run.rows) <= FEW else 0.0
    start, stop = run.span
    return start - room, stop + room


def overlay_entries(run: Run) -> list[Entry]:
    """Legend of what `draw_overlay` draws."""
    entries: list[Entry] = [
        (name, {"color": colour, "linewidth": 7.0, "solid_capstyle": "butt"})
        for status, (name, colour) in SHADES.items()
        if np.any(histories(run).status == status)
    ]
    if run.events:
        entries.append(("event (number)", EVENT))
    return entries


def draw_overlay(axes: Axes, run: Run, *, numbered: bool) -> None:
    """Shade where the solver had no valid answer; draw a line at each event and, if asked, its number."""
    across = axes.get_xaxis_transform()  # time along x, 0 to 1 from the bottom to the top
    step, last = run.header.log_step, run.span[1]
    for status, (_, colour) in SHADES.items():
        corners: list[tuple[float, float]] = []
        for first, end in intervals(histories(run).status == status):
            a = min(first * step, last)
            b = a + step * (end - first)
            corners += [(a, 0), (a, 1), (b, 1), (b, 0), (a, 0)]
        if corners:
            shape = Path(corners, CODES * (len(corners) // len(CODES)))
            axes.add_artist(PathPatch(shape, transform=across, facecolor=colour, linewidth=0, zorder=0.5))
    start, stop = span(run)
    times = [min(max(event.time, start), stop) for event in events(run)]
    if times:
        t, y = np.repeat(times, 3), np.tile([0.0, 1.0, np.nan], len(times))
        axes.add_artist(Line2D(t, y, transform=across, zorder=1.5, **EVENT))
    if numbered:
        for time, text in number_groups(times, APART * (stop - start)):
            axes.text(time, 1.02, text, transform=across, ha="center", va="bottom", fontweight="bold")


def number_groups(times: Sequence[float], apart: float) -> list[tuple[float, str]]:
    """Return where which numbers stand: '1', or '2–4' for (ascending) times less than `apart` apart."""
    groups: list[tuple[float, int, int]] = []
    for number, time in enumerate(times, 1):
        if groups and time - groups[-1][0] < apart:
            groups[-1] = (*groups[-1][:2], number)
        else:
            groups.append((time, number, number))
    return [(time, str(first) if first == last else f"{first}–{last}") for time, first, last in groups]
