"""Time histories: panels under one another on one time axis, the run's failures and events marked in each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.model.robot import Array
from cdpr.report.canvas import (
    INK,
    SOFT,
    Axes,
    Chart,
    Line2D,
    MaxNLocator,
    Path,
    PathPatch,
    styled,
)
from cdpr.report.decimate import extrema, intervals
from cdpr.tension import Status

# Inches. All figures of one run have the same width and the same time axis, one above the other.
WIDTH, LEFT, TOP, BOTTOM, GAP = 7.6, 0.78, 0.24, 0.46, 0.2
LINE = 0.165  # of the legend
LETTER = 0.068

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SHADES = {
    Status.INFEASIBLE: ("infeasible", "#f8d3cb"),
    Status.NOT_FOUND: ("not found", "#fbe7ad"),
    Status.UNSUPPORTED: ("unsupported", "#d9d9d9"),
    Status.BAD_INPUT: ("bad input", "#dcd0ee"),
}


Entry = tuple[str, dict[str, Any]]  # of the legend: its text and how the sample line looks


@dataclass(frozen=True)
class Curves:
    """Lines that share a width: the columns of `values`, each with its colour and dashes, over and over."""

    values: Array  # (K, c)
    colours: Sequence[str]
    dashes: Sequence[Any] = ("-",)
    width: float = 1.2


@dataclass(frozen=True)
class Limit:
    """Horizontal lines that are shown only where they do not squash the curves; the legend says so if not."""

    label: str
    values: Sequence[float]
    colours: Sequence[str] = (SOFT,)


@dataclass(frozen=True)
class Panel:
    """One pair of axes."""

    label: str  # quantity and unit
    curves: tuple[Curves, ...]
    legend: Sequence[Entry] = ()
    least: float = 0.0  # range of the vertical axis that is never undercut, so that round-off does not fill a panel
    limits: tuple[Limit, ...] = ()
    log: bool = False
    height: float = 1.55  # in


@styled
def stack(run: Run, panels: Sequence[Panel], title: str = "", foot: str = "") -> Chart:
    """Draw `panels` under one another, each with its legend at the right; the first explains shades and marks too."""
    right = legend_width(run)
    above, below = TOP + (0.25 if title else 0.0), BOTTOM + (0.22 if foot else 0.0)
    shared = [_mark_entries(run), *([()] * (len(panels) - 1))]
    heights = [
        max(panel.height, LINE * (len(panel.legend) + len(panel.limits) + len(more)))
        for panel, more in zip(panels, shared, strict=True)
    ]
    height = above + sum(heights) + GAP * (len(panels) - 1) + below
    chart = Chart(figsize=(WIDTH, height))
    top = height - above
    for panel, tall, more in zip(panels, heights, shared, strict=True):
        first, last = panel is panels[0], panel is panels[-1]
        axes = chart.add_axes((LEFT / WIDTH, (top - tall) / height, 1 - (LEFT + right) / WIDTH, tall / height))
        entries = [*panel.legend, *_draw(axes, run, panel), *more]
        _marks(axes, run, numbered=first)
        legend(chart, entries, (WIDTH - right + 0.12, top))
        axes.tick_params(labelbottom=last)
        if last:
            axes.set_xlabel("time (s)")
            axes.xaxis.set_label_coords(0.5, -0.3 / tall)
        top -= tall + GAP
    if title:
        chart.text(LEFT / WIDTH, 1.0 - 0.1 / height, title, va="top", fontsize=9.5, fontweight="bold")
    if foot:
        chart.text(LEFT / WIDTH, 0.08 / height, foot, va="bottom", fontsize=8.0, color=SOFT)
    return chart


def legend(chart: Chart, entries: Sequence[Entry], corner: tuple[float, float]) -> None:
    """Write a legend whose upper left corner is at `corner`, in from the lower left of the figure.

    By hand, because matplotlib's own legend would take a third of the time of a whole report.
    """
    x, y = corner
    inches = chart.dpi_scale_trans
    for text, look in entries:
        y -= LINE
        sample = Line2D([x, x + 0.3], [y + 0.06, y + 0.06], transform=inches, **look)
        chart.add_artist(sample)
        chart.text(x + 0.4, y + 0.06, text, transform=inches, va="center")


def legend_width(run: Run) -> float:
    """Width of the legend, in: the same in all figures of one run."""
    longest = max((len(shorten(name)) for name in run.header.cables), default=0)
    return max(1.7, 0.55 + LETTER * longest)


def shorten(name: str, length: int = 26) -> str:
    """Cut the middle out of a long name: the ends tell cables apart."""
    if len(name) <= length:
        return name
    half = (length - 1) // 2
    return f"{name[: length - 1 - half]}…{name[-half:]}"


def _mark_entries(run: Run) -> list[Entry]:
    """Legend of the shaded intervals and of the events' lines."""
    entries: list[Entry] = []
    for status, (name, colour) in SHADES.items():
        if steps := int(np.count_nonzero(run.solver_status == status)):
            text = f"{name}: {steps} step{'s' if steps > 1 else ''}"
            entries.append((text, {"color": colour, "linewidth": 7.0, "solid_capstyle": "butt"}))
    if run.events:
        entries.append(("event (number)", {"color": INK, "linewidth": 0.8, "linestyle": ":"}))
    return entries


def _draw(axes: Axes, run: Run, panel: Panel) -> list[Entry]:
    """Draw one panel and return what its limits add to the legend."""
    low, high, note = _view(run, panel)
    few = "o" if len(run.time) <= 25 else ""
    for curves in panel.curves:
        times, points = extrema(run.time, _shown(curves, panel))
        looks = zip(cycle(curves.colours), cycle(curves.dashes), points.T, times.T, strict=False)
        for colour, dashes, v, t in looks:
            axes.add_artist(
                Line2D(t, v, color=colour, linestyle=dashes, linewidth=curves.width, marker=few, markersize=3)
            )
    entries: list[Entry] = []
    for limit in panel.limits:
        seen = [low <= value <= high for value in limit.values]
        for value, colour, shown in zip(limit.values, cycle(limit.colours), seen, strict=False):
            if shown:
                axes.add_artist(
                    Line2D([0, 1], [value, value], transform=axes.get_yaxis_transform(), **_limit_look(colour))
                )
        entries.append((limit.label, _limit_look(limit.colours[0] if len(limit.values) == 1 else SOFT)))
        if not all(seen):
            entries.append(("(out of view)", {"linestyle": ""}))
    axes.yaxis.set_major_locator(MaxNLocator(nbins=6, steps=[1, 2, 2.5, 5, 10], integer=panel.log))
    if panel.log:
        axes.yaxis.set_major_formatter(lambda power, _: "10" + f"{power:.0f}".translate(SUPERSCRIPT))
    axes.xaxis.set_major_locator(MaxNLocator(nbins=9, steps=[1, 2, 2.5, 5, 10]))
    axes.set_ylim(low, high)
    axes.set_xlim(*_span(run))
    axes.set_ylabel(panel.label)
    axes.yaxis.set_label_coords(-0.55 / (WIDTH - LEFT - legend_width(run)), 0.5)
    offset = axes.yaxis.get_offset_text()  # beside the axis, out of the way of the events' numbers
    offset.set_horizontalalignment("right")
    if note:
        axes.text(0.99, 0.95, note, transform=axes.transAxes, ha="right", va="top", color=SOFT, fontsize=8.0)
    return entries


def _limit_look(colour: str) -> dict[str, Any]:
    return {"color": colour, "linestyle": (0, (6.0, 3.0)), "linewidth": 1.0}


def _span(run: Run) -> tuple[float, float]:
    """Range of the time axis, never empty."""
    if len(run.time) == 0:
        return 0.0, run.header.control_step
    return float(run.time[0]), max(float(run.time[-1]), float(run.time[0]) + run.header.control_step)


def _view(run: Run, panel: Panel) -> tuple[float, float, str]:
    """Range of the vertical axis, and a note where it does not hold all.

    A diverging run ends in values that would flatten all that led to them: there the range is that of the first nine
    tenths, widened.
    """
    values = np.concatenate([_shown(curves, panel) for curves in panel.curves], axis=1)
    low, high = _range(values)
    note = ""
    if run.status == "diverged":
        early_low, early_high = _range(values[: int(0.9 * len(values))])
        room = max(early_high - early_low, panel.least)
        if high - low > 10.0 * room > 0.0:
            note = f"diverges: values from {low:.2g} to {high:.2g}"
            low, high = max(low, early_low - room), min(high, early_high + room)
    room = max(high - low, panel.least, 1e-9 * max(abs(low), abs(high)), 1e-15)
    for limit in panel.limits:
        for value in limit.values:
            if low - room <= value <= high + room:
                low, high = min(low, value), max(high, value)
    padding = 0.06 * (high - low) + 0.5 * max(room - (high - low), 0.0)
    return low - padding, high + padding, note


def _shown(curves: Curves, panel: Panel) -> Array:
    """Return the values or, for a logarithmic panel, their powers of ten; 0 counts as 1e-16."""
    return np.log10(np.maximum(curves.values, 1e-16)) if panel.log else curves.values


def _range(values: Array) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)


def _marks(axes: Axes, run: Run, *, numbered: bool) -> None:
    """Shade where the solver had no answer, draw a line at each event and, on top, its number in `run.events`."""
    across = axes.get_xaxis_transform()  # time along x, 0 to 1 from bottom to top
    step = run.header.control_step
    for status, (_, colour) in SHADES.items():
        ranges = intervals(run.solver_status == status)
        corners = [
            (run.time[first] + step * k, y) for first, stop in ranges for k, y in _rectangle(stop - first)
        ]
        if corners:
            codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY] * len(ranges)
            patch = PathPatch(Path(corners, codes), transform=across, facecolor=colour, linewidth=0, zorder=0.5)
            axes.add_artist(patch)
    groups = event_groups(run)
    if groups:
        t = np.repeat([event.time for event in run.events], 3)
        y = np.tile([0.0, 1.0, np.nan], len(run.events))
        axes.add_artist(Line2D(t, y, transform=across, color=INK, linewidth=0.8, linestyle=":", zorder=1.5))
    if numbered:
        for time, text in groups:
            axes.text(time, 1.02, text, transform=across, ha="center", va="bottom", fontsize=8, fontweight="bold")


def _rectangle(width: float) -> list[tuple[float, float]]:
    return [(0, 0), (0, 1), (width, 1), (width, 0), (0, 0)]


def event_groups(run: Run) -> list[tuple[float, str]]:
    """Return times and numbers of the events, counted from 1; those too close to be told apart share a mark: '2-4'."""
    start, stop = _span(run)
    groups: list[tuple[float, int, int]] = []
    order = sorted(range(len(run.events)), key=lambda i: run.events[i].time)
    for number in order:
        time = run.events[number].time
        if groups and time - groups[-1][0] < 0.03 * (stop - start):
            groups[-1] = (groups[-1][0], groups[-1][1], number + 1)
        else:
            groups.append((time, number + 1, number + 1))
    return [(time, str(a) if a == b else f"{a}–{b}") for time, a, b in groups]
