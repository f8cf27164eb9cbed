"""Overlay of time histories: shaded intervals and numbered events."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.ui.report.figures.surface import Frame
from cdpr.ui.report.plots.overlay import Shade
from cdpr.ui.report.plots.panel import Entry
from cdpr.ui.report.style import INK, events

EVENT: dict[str, Any] = {"color": INK, "linewidth": 0.8, "linestyle": ":"}
APART = 0.07  # minimum distance of event numbers, relative to the time axis


def overlay_entries(run: Run | None, shades: Sequence[Shade]) -> list[Entry]:
    """Return the legend entries of the overlay."""
    entries: list[Entry] = [
        (shade.name, {"color": shade.colour.light, "linewidth": 7.0, "solid_capstyle": "butt"}) for shade in shades
    ]
    if run is not None and run.events:
        entries.append(("event (number)", EVENT))
    return entries


def draw_overlay(
    frame: Frame, run: Run | None, shades: Sequence[Shade], span: tuple[float, float], *, numbered: bool
) -> None:
    """Shade intervals and draw a line at each event of a run.

    Args:
        frame: frame to draw on.
        run: source of the events; None if nothing was simulated.
        shades: intervals to shade.
        span: first and last time, s; events outside are drawn at its ends.
        numbered: write the numbers of the events above the frame.
    """
    for shade in shades:
        rings = [np.array(((a, 0.0), (a, 1.0), (b, 1.0), (b, 0.0))) for a, b in shade.intervals]
        frame.area(rings, {"facecolor": shade.colour.light, "linewidth": 0, "zorder": 0.5}, "y")
    start, stop = span
    times = [] if run is None else [min(max(event.time, start), stop) for event in events(run)]
    if times:
        t, y = np.repeat(times, 3), np.tile([0.0, 1.0, np.nan], len(times))
        frame.line(t, y, {**EVENT, "zorder": 1.5}, "y")
    if numbered:
        for time, text in number_groups(times, APART * (stop - start)):
            frame.text(time, 1.02, text, {"ha": "center", "va": "bottom", "fontweight": "bold"}, "y")


def number_groups(times: Sequence[float], apart: float) -> list[tuple[float, str]]:
    """Return positions and labels of event numbers: '1', or '2–4' for events closer than `apart` to a first one."""
    groups: list[tuple[float, int, int]] = []
    for number, time in enumerate(times, 1):
        if groups and time - groups[-1][0] < apart:
            groups[-1] = (*groups[-1][:2], number)
        else:
            groups.append((time, number, number))
    return [(time, str(first) if first == last else f"{first}–{last}") for time, first, last in groups]
