"""One-dimensional null space: tension over x, the admissible interval, limits and numbered results."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.model.robot import Array
from cdpr.ui.report.figures.canvas import Line2D, MaxNLocator
from cdpr.ui.report.figures.chart import plain
from cdpr.ui.report.figures.legend import LINE
from cdpr.ui.report.figures.null_space_panel import ADMISSIBLE, BAD, GOOD, LABEL, Group, Panel, write_badge
from cdpr.ui.report.figures.placing import spread_out
from cdpr.ui.report.style import INK, SOFT, cable_looks, shorten

ROOM = 1.0  # in, at the right of the panel for cable names
BADGES = 0.24  # in, minimum distance of two badges
LEAST = 0.155  # in, minimum distance of two names


def draw(
    panel: Panel, figures: dict[str, Any], corners: Array, groups: list[tuple[int, Group]], *, detailed: bool
) -> None:
    """Draw the interval, each cable's tension and limits, and the numbered results; `detailed` adds labels."""
    axes, (low,), (high,) = panel.axes, panel.low, panel.high
    N, start = (np.array(figures["null_space"][key]) for key in ("basis", "particular_N"))
    slope = N[:, 0]
    ends = start + np.outer((low, high), slope)  # (2, m)
    limits = np.array([[cable["tension_min_N"], cable["tension_max_N"]] for cable in figures["cables"]]).T
    bottom, top = _heights(ends, limits)
    axes.set_ylim(bottom, top)
    if len(corners):
        axes.axvspan(*corners[[0, -1], 0], facecolor=ADMISSIBLE, edgecolor="none", zorder=0.5)
        for x in corners[:, 0]:
            axes.add_artist(Line2D([x, x], [bottom, top], color=GOOD, linewidth=1.1, zorder=2))
    axes.add_artist(Line2D([0.0], [bottom], marker="+", color=SOFT, markersize=7.0, zorder=4, clip_on=False))
    looks = [plain(look) for look in cable_looks([cable["name"] for cable in figures["cables"]])]
    for i, look in enumerate(looks):
        axes.add_artist(Line2D([low, high], ends[:, i], **look, linewidth=1.4, zorder=3))
    _limits(panel, limits, looks, (bottom, top), detailed=detailed)
    for _, group in groups:
        colour = GOOD if group.admissible else BAD
        x = float(group.x[0])
        axes.add_artist(Line2D([x, x], [bottom, top], color=colour, linewidth=0.9, linestyle=(0, (3, 2)), zorder=4))
        t = start + slope * x
        dot: dict[str, Any] = {
            "marker": "o" if group.admissible else "X",
            "markersize": 4.5,
            "markeredgecolor": "white",
        }
        axes.add_artist(Line2D(np.full(len(t), x), t, linestyle="", color=colour, **dot, zorder=7))
    _badges(panel, groups, top)
    nbins = 7 if detailed else 3
    axes.xaxis.set_major_locator(MaxNLocator(nbins=nbins, steps=(1, 2, 2.5, 5, 10)))
    axes.yaxis.set_major_locator(MaxNLocator(nbins=nbins, steps=(1, 2, 2.5, 5, 10)))
    if detailed:
        axes.set_xlabel("x (N)")
        axes.set_ylabel("tension (N)")
        _names(panel, figures, ends[1], looks, (bottom, top))
        _ends(panel, figures, corners, start, slope, limits, (bottom, top))


def frame(panel: Panel, close: Panel) -> None:
    """Mark the part that another panel enlarges."""
    for x in (close.low[0], close.high[0]):
        panel.axes.axvline(x, color=INK, linewidth=1.0, zorder=9)


def _heights(ends: Array, limits: Array) -> tuple[float, float]:
    """Return the range of the vertical axis: the tensions in the window and nearby limits."""
    low, high = float(ends.min()), float(ends.max())
    room = max(high - low, 1.0)
    for value in limits.ravel():
        if low - 0.5 * room <= value <= high + 0.5 * room:
            low, high = min(low, float(value)), max(high, float(value))
    return low - 0.06 * (high - low), high + 0.06 * (high - low)


def _limits(
    panel: Panel, limits: Array, looks: list[dict[str, Any]], view: tuple[float, float], *, detailed: bool
) -> None:
    """Draw each limit as a horizontal line, in the cable's colour if it is unique; skip locked cables."""
    free = np.flatnonzero(limits[0] < limits[1])
    labels: list[tuple[float, str, str]] = []
    for values, name in zip(limits, ("t_min", "t_max"), strict=True):
        for value in sorted(set(values[free].tolist())):
            whose = [i for i in free if values[i] == value]
            colour = INK if len(whose) > 1 else looks[whose[0]]["color"]
            if view[0] <= value <= view[1]:
                panel.axes.axhline(value, color=colour, linewidth=0.9, linestyle=(0, (1.2, 1.6)), zorder=2.5)
                labels.append((value, f"{name} {value:g} N", colour))
    if not detailed:
        return
    scale = panel.size[1] / (view[1] - view[0])
    places = spread_out([(value - view[0]) * scale for value, *_ in labels], LEAST, 0.0, float(panel.size[1]))
    left = panel.low[0] + 0.01 * (panel.high[0] - panel.low[0])
    for (_, text, colour), place in zip(labels, places, strict=True):
        panel.axes.text(left, view[0] + place / scale, text, va="bottom", fontsize=7.0, color=colour)


def _badges(panel: Panel, groups: list[tuple[int, Group]], top: float) -> None:
    """Write the numbers above the panel, spread out, each connected to its line."""
    width = float(panel.high[0] - panel.low[0])
    places = [float((group.x[0] - panel.low[0]) / width * panel.size[0]) for _, group in groups]
    for (number, group), place in zip(groups, spread_out(places, BADGES, 0.0, float(panel.size[0])), strict=True):
        x = panel.low[0] + place / panel.size[0] * width
        above = panel.axes.get_ylim()
        rise = 0.2 / panel.size[1] * (above[1] - above[0])
        colour = GOOD if group.admissible else BAD
        panel.axes.add_artist(
            Line2D([group.x[0], x], [top, top + rise], color=colour, linewidth=0.8, zorder=6, clip_on=False)
        )
        write_badge(panel.axes, (x, top + rise), number, group.admissible, panel.axes.transData)


def _names(
    panel: Panel, figures: dict[str, Any], right: Array, looks: list[dict[str, Any]], view: tuple[float, float]
) -> None:
    """Write each cable's name at the right end of its line."""
    scale = panel.size[1] / (view[1] - view[0])
    places = [float((t - view[0]) * scale) for t in right]
    for i, place in enumerate(spread_out(places, LEAST, 0.0, float(panel.size[1]))):
        y = view[0] + place / scale
        name = shorten(figures["cables"][i]["name"], 14)
        x, dx = panel.high[0], (panel.high[0] - panel.low[0]) / panel.size[0]
        panel.axes.add_artist(
            Line2D([x, x + 0.1 * dx], [right[i], y], color=looks[i]["color"], linewidth=0.7, clip_on=False)
        )
        panel.axes.text(x + 0.13 * dx, y, name, va="center", fontsize=7.5, color=looks[i]["color"])


def _ends(
    panel: Panel, figures: dict[str, Any], corners: Array, start: Array, slope: Array, limits: Array,
    view: tuple[float, float],
) -> None:  # fmt: skip
    """Label the ends of the interval with the cables that reach a limit there."""
    inch = (panel.high[0] - panel.low[0]) / panel.size[0]
    for k, x in enumerate(corners[:, 0]):
        t = start + slope * x
        near = 1e-9 * max(1.0, float(np.abs(t).max()))
        names = [
            f"{shorten(cable['name'], 14)} {side}"
            for side, values in zip(("min", "max"), limits, strict=True)
            for cable, value, tension, g in zip(figures["cables"], values, t, slope, strict=True)
            if abs(tension - value) <= near and g != 0.0
        ]
        if panel.low[0] <= x <= panel.high[0]:
            beside = x + (-0.5 if k == 0 else 0.5) * LINE * inch
            panel.axes.text(
                beside, 0.5 * sum(view), ", ".join(names), rotation=90.0, ha="center", va="center",
                fontsize=7.0, color=GOOD, zorder=5, bbox=LABEL,
            )  # fmt: skip
