"""Time histories: panels under one another on one time axis."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.report.figures.canvas import Axes, Chart, Line2D, MaxNLocator
from cdpr.report.figures.legend import LINE, legend_width, write_legend
from cdpr.report.figures.overlay import draw_overlay, overlay_entries
from cdpr.report.marks import SOFT
from cdpr.report.plots.overlay import FEW, Shade, span
from cdpr.report.plots.overlay import shades as shades_of
from cdpr.report.plots.panel import Entry, Limit, Panel, calm_until, shown, view

# Inches. All figures of one run have the same width and the same time axis, one above the other.
WIDTH, LEFT, TOP, BOTTOM, GAP = 7.6, 0.85, 0.24, 0.46, 0.2

LIMIT: dict[str, Any] = {"color": SOFT, "linestyle": (0, (6.0, 3.0)), "linewidth": 1.0}

STEPS = (1, 2, 2.5, 5, 10)  # between ticks, times a power of ten
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def stack(
    run: Run | None,
    panels: Sequence[Panel],
    title: str = "",
    foot: str = "",
    span_of: tuple[float, float] = (0.0, 0.0),
    shades: Sequence[Shade] = (),
) -> Chart:
    """Draw `panels` under one another, each with its legend; the first explains the overlay too.

    Where nothing was simulated there is no run: `span_of` is the first and the last time, s, and `shades` what lies
    under the panels.
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
    chart = Chart(figsize=(WIDTH, height))
    top = height - above
    for panel, tall, more in zip(panels, heights, shared, strict=True):
        box = (LEFT, top - tall, WIDTH - LEFT - right, tall)
        axes = chart.add_axes(tuple(np.array(box) / (WIDTH, height, WIDTH, height)))
        draw_overlay(axes, run, shades, span_of, numbered=panel is panels[0])
        axes.set_xlim(*span_of)
        draw_panel(axes, run, panel)
        write_legend(chart, [*panel.legend, *limit_entries(run, panel), *more], (WIDTH - right, top))
        axes.yaxis.set_label_coords(-0.66 / box[2], 0.5)
        axes.tick_params(labelbottom=panel is panels[-1])
        if panel is panels[-1]:
            axes.set_xlabel("time (s)")
            axes.xaxis.set_label_coords(0.5, -0.3 / tall)
        top -= tall + GAP
    if title:
        chart.text(LEFT / WIDTH, 1.0 - 0.1 / height, title, va="top", fontsize=9.5, fontweight="bold")
    if foot:
        chart.text(LEFT / WIDTH, 0.08 / height, foot, va="bottom", fontsize=8.0, color=SOFT)
    return chart


def draw_panel(axes: Axes, run: Run | None, panel: Panel, ticks: int = 9) -> None:
    """Draw curves, limits and at most so many ticks of time of one panel."""
    low, high, note = view(panel, None if run is None else calm_until(run))
    dot = "o" if run is not None and len(run.rows) <= FEW else ""
    for curves in panel.curves:
        columns = curves.points.time.T, shown(panel, curves).T
        looks = zip(cycle(curves.colours), cycle(curves.dashes), *columns, strict=False)
        for colour, dashes, t, values in looks:
            look: dict[str, Any] = {"color": colour, "linestyle": dashes, "linewidth": curves.width}
            axes.add_artist(Line2D(t, values, marker=dot, markersize=3.0, **look))
    axes.set_ylim(low, high)
    axes.ticklabel_format(axis="x", scilimits=(-3, 6))
    axes.set_ylabel(panel.label)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=ticks, steps=STEPS))
    axes.yaxis.set_major_locator(MaxNLocator(nbins=6, steps=STEPS, integer=panel.log))
    if panel.log:
        axes.yaxis.set_major_formatter(lambda power, _: "10" + f"{power:.0f}".translate(SUPERSCRIPT))
    # A common power of ten stands beside the axis, out of the way of the events' numbers.
    axes.yaxis.get_offset_text().set_horizontalalignment("right")
    if note:
        axes.text(0.015, 0.95, note, transform=axes.transAxes, ha="left", va="top", color=SOFT)
    for limit in panel.limits:
        _draw_limit(axes, limit, low, high)


def limit_entries(run: Run | None, panel: Panel) -> list[Entry]:
    """Legend of the limits of a panel."""
    low, high, _ = view(panel, None if run is None else calm_until(run))
    entries: list[Entry] = []
    for limit in panel.limits:
        entries.append((limit.label, LIMIT))
        if not all(low <= value <= high for value in limit.values):
            entries.append(("(out of view)", {"linestyle": ""}))
    return entries


def _draw_limit(axes: Axes, limit: Limit, low: float, high: float) -> None:
    across = axes.get_yaxis_transform()
    for value, colour in zip(limit.values, cycle(limit.colours), strict=False):
        if low <= value <= high:
            axes.add_artist(Line2D([0, 1], [value, value], transform=across, **{**LIMIT, "color": colour}))
