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
    LogLocator,
    MaxNLocator,
    NullLocator,
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

SHADES = {
    Status.INFEASIBLE: ("infeasible", "#f8d3cb"),
    Status.NOT_FOUND: ("not found", "#fbe7ad"),
    Status.UNSUPPORTED: ("unsupported", "#d9d9d9"),
    Status.BAD_INPUT: ("bad input", "#dcd0ee"),
}


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
    least: float = 0.0  # range of the vertical axis that is never undercut, so that round-off does not fill a panel
    limits: tuple[Limit, ...] = ()
    log: bool = False
    height: float = 1.55  # in


Entry = tuple[str, dict[str, Any]]  # of the legend: its text and how the sample line looks


@styled
def stack(run: Run, panels: Sequence[Panel], legend: Sequence[Entry], title: str = "", foot: str = "") -> Chart:
    """Draw `panels` under one another; the legend stands at the right and also explains shades and marks."""
    entries = list(legend)
    right = legend_width(run)
    top = TOP + (0.25 if title else 0.0)
    bottom = BOTTOM + (0.25 if foot else 0.0)
    wanted = top + LINE * (len(entries) + 6)
    height = max(top + sum(panel.height + GAP for panel in panels) - GAP + bottom, wanted)
    chart = Chart(figsize=(WIDTH, height))
    y = height - top
    for i, panel in enumerate(panels):
        tall = panel.height if len(panels) > 1 else y - bottom
        y -= tall
        box = (LEFT / WIDTH, y / height, 1.0 - (LEFT + right) / WIDTH, tall / height)
        axes = chart.add_axes(box)
        entries += _draw(axes, run, panel)
        _marks(axes, run, numbered=i == 0)
        axes.tick_params(labelbottom=i == len(panels) - 1)
        y -= GAP
    axes.set_xlabel("time (s)")
    axes.xaxis.set_label_coords(0.5, -0.3 / tall)
    entries += shade_entries(run)
    if run.events:
        entries.append(("event (number)", {"color": INK, "linewidth": 0.8, "linestyle": ":"}))
    handles = [Line2D([], [], **look) for _, look in entries]
    labels = [text for text, _ in entries]
    corner = (1.0 - (right - 0.12) / WIDTH, 1.0 - top / height)
    chart.legend(handles, labels, loc="upper left", bbox_to_anchor=corner)
    if title:
        chart.text(LEFT / WIDTH, 1.0 - 0.1 / height, title, va="top", fontsize=9.5, fontweight="bold")
    if foot:
        chart.text(LEFT / WIDTH, 0.08 / height, foot, va="bottom", fontsize=8.0, color=SOFT)
    return chart


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


def shade_entries(run: Run) -> list[Entry]:
    """Legend of the shaded intervals."""
    entries: list[Entry] = []
    for status, (name, colour) in SHADES.items():
        if steps := int(np.count_nonzero(run.solver_status == status)):
            text = f"{name}: {steps} step{'s' if steps > 1 else ''}"
            entries.append((text, {"color": colour, "linewidth": 7.0, "solid_capstyle": "butt"}))
    return entries


def _draw(axes: Axes, run: Run, panel: Panel) -> list[Entry]:
    """Draw one panel and return what its limits add to the legend."""
    low, high, note = _view(run, panel)
    few = "o" if len(run.time) <= 25 else ""
    for curves in panel.curves:
        values = np.maximum(curves.values, low) if panel.log else curves.values
        times, points = extrema(run.time, values)
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
        text = limit.label if all(seen) else f"{limit.label}\n(out of view)"
        entries.append((text, _limit_look(limit.colours[0] if len(limit.values) == 1 else SOFT)))
    if panel.log:
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(numticks=6))
        axes.yaxis.set_minor_locator(NullLocator())
    else:
        axes.yaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 2.5, 5, 10]))
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
    values = np.concatenate([curves.values for curves in panel.curves], axis=1)
    low, high = _range(values)
    if panel.log:
        low = max(low, 1e-16)
        return low / 2.0, max(2.0 * high, 20.0 * low), ""
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
