"""Time histories: stacked panels on one time axis."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

from cdpr.log.run import Run
from cdpr.ui.report.figures.legend import LINE, legend_width, write_legend
from cdpr.ui.report.figures.overlay import draw_overlay, overlay_entries
from cdpr.ui.report.figures.surface import Frame, Make, S
from cdpr.ui.report.plots.overlay import FEW, Shade, span
from cdpr.ui.report.plots.overlay import shades as shades_of
from cdpr.ui.report.plots.panel import Entry, Panel, calm_until, shown, view
from cdpr.ui.report.style import SOFT

# Lengths in inches. All figures of a run have the same width and time axis, so that they align.
WIDTH, LEFT, TOP, BOTTOM, GAP = 7.6, 0.85, 0.24, 0.46, 0.2

LIMIT: dict[str, Any] = {"color": SOFT, "linestyle": (0, (6.0, 3.0)), "linewidth": 1.0}


def stack(
    run: Run | None,
    panels: Sequence[Panel],
    make: Make[S],
    title: str = "",
    foot: str = "",
    span_of: tuple[float, float] = (0.0, 0.0),
    shades: Sequence[Shade] = (),
) -> S:
    """Draw `panels` below one another, each with its legend; the first legend includes the overlay.

    Args:
        run: simulated run; None if nothing was simulated.
        panels: panels from top to bottom.
        make: constructor of the sheet.
        title: text above the panels.
        foot: text below the panels.
        span_of: first and last time (s) if there is no run.
        shades: shaded intervals if there is no run.
    """
    if run is not None:
        span_of, shades = span(run), shades_of(run)
    names = [text for panel in panels for text, _ in panel.legend] if run is None else run.header.cables
    right = legend_width(names)
    above, below = TOP + (0.25 if title else 0.0), BOTTOM + (0.22 if foot else 0.0)
    shared = [overlay_entries(run, shades), *([] for _ in panels[1:])]
    heights = [
        max(panel.height, LINE * (len(panel.legend) + 2 * len(panel.limits) + len(more)))
        for panel, more in zip(panels, shared, strict=True)
    ]
    height = above + sum(heights) + GAP * (len(panels) - 1) + below
    sheet = make(WIDTH, height)
    top = height - above
    for panel, tall, more in zip(panels, heights, shared, strict=True):
        frame = sheet.frame((LEFT, top - tall, WIDTH - LEFT - right, tall))
        draw_overlay(frame, run, shades, span_of, numbered=panel is panels[0])
        frame.scale(x=span_of)
        draw_panel(frame, run, panel, 0.66)
        write_legend(sheet, [*panel.legend, *limit_entries(run, panel), *more], (WIDTH - right, top))
        if panel is panels[-1]:
            frame.label_time("time (s)", 0.3)
        top -= tall + GAP
    if title:
        sheet.text(LEFT, height - 0.1, title, {"va": "top", "fontsize": 9.5, "fontweight": "bold"})
    if foot:
        sheet.text(LEFT, 0.08, foot, {"va": "bottom", "fontsize": 8.0, "color": SOFT})
    return sheet


def draw_panel(frame: Frame, run: Run | None, panel: Panel, beside: float, ticks: int = 9) -> None:
    """Draw the curves and limits of a panel, with at most `ticks` time ticks and the label `beside` the axis (in)."""
    low, high, note = view(panel, None if run is None else calm_until(run))
    dot = {"marker": "o", "markersize": 3.0} if run is not None and len(run.rows) <= FEW else {}
    for curves in panel.curves:
        columns = curves.points.time.T, shown(panel, curves).T
        names = [*curves.names, *([""] * len(columns[0]))]
        looks = zip(names, cycle(curves.colours), cycle(curves.dashes), *columns, strict=False)
        for name, colour, dashes, t, values in looks:
            look = {"color": colour, "linestyle": dashes, "linewidth": curves.width, **dot, **curves.thing(name)}
            frame.line(t, values, look)
    frame.scale(y=(low, high))
    frame.time_axis(ticks)
    frame.value_axis(panel.label, beside, powers=panel.log)
    if note:
        frame.text(0.015, 0.95, note, {"va": "top", "color": SOFT}, "xy")
    for limit in panel.limits:
        for value, colour in zip(limit.values, cycle(limit.colours), strict=False):
            if low <= value <= high:
                frame.line([0, 1], [value, value], {**LIMIT, "color": colour}, "x")


def limit_entries(run: Run | None, panel: Panel) -> list[Entry]:
    """Return the legend entries of a panel's limits."""
    low, high, _ = view(panel, None if run is None else calm_until(run))
    entries: list[Entry] = []
    for limit in panel.limits:
        entries.append((limit.label, LIMIT))
        if not all(low <= value <= high for value in limit.values):
            entries.append(("(out of view)", {"linestyle": ""}))
    return entries
