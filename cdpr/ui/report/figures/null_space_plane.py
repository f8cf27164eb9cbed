"""Two-dimensional null space: the admissible polygon, limits as straight lines and numbered results."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.model.robot import Array
from cdpr.ui.report.figures.canvas import Line2D, MaxNLocator, Path, PathPatch
from cdpr.ui.report.figures.chart import plain
from cdpr.ui.report.figures.null_space_panel import ADMISSIBLE, BAD, GOOD, LABEL, Group, Panel, write_badge
from cdpr.ui.report.figures.placing import OccupiedArea, place_along, place_badges
from cdpr.ui.report.style import INK, SOFT, cable_looks, shorten

ROOM = 0.0
LETTER = 0.056  # in, mean width of a letter of a limit's label
SHORTEST = 0.35  # in: shorter lines get no label


def draw(
    panel: Panel, figures: dict[str, Any], corners: Array, groups: list[tuple[int, Group]], *, detailed: bool
) -> None:
    """Draw the polygon, the limits and the numbered results; `detailed` adds labels."""
    axes = panel.axes
    if len(corners):
        path = Path(np.concatenate([corners, corners[:1]]), closed=True)
        axes.add_artist(PathPatch(path, facecolor=ADMISSIBLE, edgecolor=GOOD, linewidth=1.1, zorder=1.5))
    if len(corners) == 1:
        axes.add_artist(Line2D(*corners.T, marker="s", color=GOOD, markersize=5.0, zorder=4))
    axes.add_artist(Line2D([0.0], [0.0], marker="+", color=SOFT, markersize=7.0, zorder=4))
    points = np.array([_inches(panel, group.x) for _, group in groups]).reshape(-1, 2)
    taken = OccupiedArea(panel.size)
    badges = place_badges(taken, points)
    for (number, group), badge in zip(groups, badges, strict=True):
        at = _data(panel, badge)
        colour = GOOD if group.admissible else BAD
        axes.add_artist(Line2D(*np.array([group.x, at]).T, color=colour, linewidth=0.8, zorder=6))
        marker: dict[str, Any] = {
            "marker": "o" if group.admissible else "X",
            "markersize": 5.0 if group.admissible else 6.0,
        }
        axes.add_artist(Line2D(*group.x[:, None], color=colour, markeredgecolor="white", **marker, zorder=7))
        write_badge(axes, (at[0], at[1]), number, group.admissible, axes.transData)
    _limits(panel, figures, corners, taken, detailed=detailed)
    nbins = 7 if detailed else 3
    for axis, name in ((axes.xaxis, "x₁ (N)"), (axes.yaxis, "x₂ (N)")):
        axis.set_major_locator(MaxNLocator(nbins=nbins, steps=(1, 2, 2.5, 5, 10)))
        if detailed:
            axis.set_label_text(name)


def frame(panel: Panel, close: Panel) -> None:
    """Mark the part that another panel enlarges."""
    (a, b), (c, d) = close.low, close.high
    panel.axes.add_artist(Line2D([a, c, c, a, a], [b, b, d, d, b], color=INK, linewidth=1.0, zorder=9))


def _limits(panel: Panel, figures: dict[str, Any], corners: Array, taken: OccupiedArea, *, detailed: bool) -> None:
    """Draw the limits of each cable; emphasise those that bound the polygon and label them first."""
    N, start = (np.array(figures["null_space"][key]) for key in ("basis", "particular_N"))
    cables = figures["cables"]
    looks = [plain(look) for look in cable_looks([cable["name"] for cable in cables])]
    rows: list[tuple[bool, Array, str, dict[str, Any]]] = []
    for i, (cable, look) in enumerate(zip(cables, looks, strict=True)):
        for key, name in (("tension_min_N", "min"), ("tension_max_N", "max")):
            segment = _crossing(panel, N[i], cable[key] - start[i])
            if segment is not None:
                bounds = _touches(corners, N[i], cable[key] - start[i])
                rows.append((not bounds, segment, f"{shorten(cable['name'], 14)} {name}", look))
    for faint, segment, label, look in sorted(rows, key=lambda row: row[0]):
        style: dict[str, Any] = {"linewidth": 0.7, "alpha": 0.45} if faint else {"linewidth": 1.3}
        panel.axes.add_artist(Line2D(segment[:, 0], segment[:, 1], **look, **style, zorder=2 if faint else 3))
        a, b = (_inches(panel, point) for point in segment)
        if detailed and np.linalg.norm(b - a) > SHORTEST:
            centre, angle = place_along(taken, a, b, LETTER * len(label))
            x, y = _data(panel, centre)
            text = panel.axes.text(
                x, y, label, rotation=angle, ha="center", va="center", fontsize=7.0, color=look["color"], zorder=5
            )
            text.set_bbox(LABEL)


def _touches(corners: Array, g: Array, b: float) -> bool:
    """Return True if two corners of the polygon lie on the line g . x = b, that is, if the line bounds it."""
    near = 1e-9 * max(1.0, abs(b), float(np.abs(corners).max(initial=0.0)))
    return int(np.count_nonzero(np.abs(corners @ g - b) <= near)) >= 2


def _crossing(panel: Panel, g: Array, b: float) -> Array | None:
    """Return the segment (2, 2) of the line g . x = b within the panel, or None."""
    square = float(g @ g)
    if square == 0.0:
        return None
    middle = (panel.low + panel.high) / 2
    point = middle + g * (b - g @ middle) / square
    along = np.array([-g[1], g[0]]) / np.sqrt(square)
    start, stop = -np.inf, np.inf
    for j in range(2):
        if abs(along[j]) < 1e-12:
            if not panel.low[j] <= point[j] <= panel.high[j]:
                return None
            continue
        ends = sorted(((panel.low[j] - point[j]) / along[j], (panel.high[j] - point[j]) / along[j]))
        start, stop = max(start, ends[0]), min(stop, ends[1])
    return np.array([point + start * along, point + stop * along]) if start < stop else None


def _inches(panel: Panel, x: Array) -> Array:
    return np.asarray((x - panel.low) / (panel.high - panel.low) * panel.size)


def _data(panel: Panel, place: Array) -> Array:
    return np.asarray(panel.low + place / panel.size * (panel.high - panel.low))
