"""Figure of `cdpr tension`: all tensions that balance a wrench, their limits, and each solver's result.

The tensions are t = t_0 + N x. One-dimensional sets are drawn as tension over x, two-dimensional sets in the plane of
x. For more dimensions the range of each tension is drawn.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr.model.robot import Array
from cdpr.ui.report.figures import null_space_line, null_space_plane, ranges
from cdpr.ui.report.figures.canvas import Chart, inline_svg, styled
from cdpr.ui.report.figures.legend import LINE
from cdpr.ui.report.figures.null_space_panel import BAD, GOOD, Group, Panel, write_badge
from cdpr.ui.report.style import INK, SOFT
from cdpr.ui.report.text.aligned import vector

# Lengths in inches.
SIDE = 5.6  # of the large panel
SMALL = 2.3  # of the small panel
LEFT, BOTTOM, TOP, GAP = 0.75, 0.55, 0.95, 0.35
COLUMN = 3.0
LETTERS = 38  # per line of the column
SPACE = 0.07  # between two legend entries

# Results closer than this fraction of the panel share a badge.
SAME = 0.004

# If the region of interest is smaller than this fraction of the whole, it is enlarged beside the whole.
CLOSE_UP = 0.3

PADDING = 0.18

# Results farther from x = 0 than this multiple of the largest limit or corner are left out; they would hide the rest.
FAR = 100.0


def draw_null_space(figures: dict[str, Any]) -> str:
    """Return the figure as SVG; equal data give equal bytes.

    Args:
        figures: data that `distribution.comparison.describe` returns.

    Raises:
        PluginError: if matplotlib is missing.
    """
    label = f"Admissible tensions of {figures['robot']} and the solvers' answers"
    return inline_svg(chart(figures), "tension", label)


@styled
def chart(figures: dict[str, Any]) -> Chart:
    """Draw the admissible set with limits and results; add a close-up if their sizes differ much."""
    r = figures["null_space"]["dimension"]
    if r > 2:
        return _ranges(figures)
    corners = np.array(figures["null_space"]["corners_N"])
    corners = corners.reshape(-1, r)
    part = null_space_line if r == 1 else null_space_plane
    answers, beyond = _in_view(figures, corners)
    whole, close = windows(corners, answers, figures["null_space"]["safest_N"], r)
    low, high = close or whole
    near = SAME * float((high - low).max())
    groups = _groups(answers, near)
    entries = [_wrapped(group) for group in groups]
    column = (SMALL + GAP + BOTTOM if close else 0.0) + LINE * (sum(map(len, entries)) + 5) + SPACE * len(entries)
    height = TOP + max(SIDE + BOTTOM, column)
    width = LEFT + SIDE + GAP + COLUMN
    page = Chart(figsize=(width, height))
    beside = part.ROOM  # space at the right of the large panel for its own labels
    panels = [_panel(page, (LEFT, height - TOP - SIDE), np.array((SIDE - beside, SIDE)), (low, high))]
    x, y = LEFT + SIDE + GAP, height - TOP
    if close:
        panels.append(_panel(page, (x + 0.45, y - SMALL), np.array((SMALL, SMALL)), whole))
        y -= SMALL + GAP + 0.1
    shown = panels[0].shows
    numbered = list(enumerate(groups, 1))
    part.draw(panels[0], figures, corners, [(k, g) for k, g in numbered if shown(g.x)], detailed=True)
    if close:
        part.draw(panels[1], figures, corners, [(k, g) for k, g in numbered if not shown(g.x)], detailed=False)
        part.frame(panels[1], panels[0])
    notes = ["+ at x = 0: t₀, of least norm", f"answers within {near:.2g} N share a number"]
    notes += textwrap.wrap("far out of view: " + ", ".join(beyond), LETTERS) if beyond else []
    _legend(page, list(zip(groups, entries, strict=True)), (x, y), notes, empty=not len(corners))
    title = f"{figures['robot']}: the tensions t = t₀ + N x that balance the wrench"
    page.text(LEFT / width, 1.0 - 0.18 / height, title, va="top", fontsize=10.0, fontweight="bold")
    where = f"{vector(figures['wrench']['value'])} N, N m at {vector(figures['pose']['position_m'])} m"
    page.text(LEFT / width, 1.0 - 0.4 / height, where, va="top", color=SOFT)
    return page


def _ranges(figures: dict[str, Any]) -> Chart:
    answers, beyond = _in_view(figures, np.empty((0, figures["null_space"]["dimension"])))
    spans = np.array(figures["ranges_N"], dtype=float)
    near = SAME * float(np.nanmax(np.append(spans[:, 1] - spans[:, 0], 1.0)))
    notes = ["line: the limits; not all combinations within the bars balance the wrench"]
    notes.append(f"answers within {near:.2g} N share a number")
    notes += ["far out of view: " + ", ".join(beyond)] if beyond else []
    return ranges.chart(figures, _groups(answers, near), notes)


def _in_view(figures: dict[str, Any], corners: Array) -> tuple[list[dict[str, Any]], list[str]]:
    """Return the results within view, and the names of solvers whose results are too far away."""
    limits = [abs(cable[key]) for cable in figures["cables"] for key in ("tension_min_N", "tension_max_N")]
    reach = FAR * max(1.0, *limits, float(np.abs(corners).max(initial=0.0)))
    answers = [answer for answer in figures["solvers"] if answer["null_space_N"] is not None]
    near = [answer for answer in answers if np.abs(answer["null_space_N"]).max() <= reach]
    return near, [answer["solver"] for answer in answers if answer not in near]


def windows(
    corners: Array, answers: Sequence[dict[str, Any]], safest: Sequence[float] | None, r: int
) -> tuple[tuple[Array, Array], tuple[Array, Array] | None]:
    """Return the window of the whole figure and that of a close-up, or None if no close-up is needed.

    Args:
        corners: (k, r), corners of the admissible set, N.
        answers: results of the solvers.
        safest: (r,), used if the admissible set is empty.
        r: dimension of the null space.

    Returns:
        Low and high corner of each window, each (r,).
    """
    zone = corners if len(corners) else np.array(safest or []).reshape(-1, r)
    everything = np.concatenate([zone, np.array([a["null_space_N"] for a in answers]).reshape(-1, r)])
    if not len(everything):
        everything = np.zeros((1, r))
    focus = np.array([a["null_space_N"] for a in answers if a["admissible"]]).reshape(-1, r)
    focus = focus if len(focus) else zone
    if len(focus) and _extent(focus) >= CLOSE_UP * _extent(zone):
        focus = np.concatenate([focus, zone])
    size = _extent(focus) if len(focus) else 0.0
    # Coinciding points have no extent.
    least = 1e-3 * max(1.0, float(np.abs(everything).max()))
    close = size > least and size < CLOSE_UP * _extent(everything)
    return _window(everything, least), _window(focus, least) if close else None


def _extent(points: Array) -> float:
    return float(np.ptp(points, axis=0).max()) if len(points) else 0.0


def _window(points: Array, least: float) -> tuple[Array, Array]:
    """Return a padded square (or interval) around the points."""
    low, high = points.min(axis=0), points.max(axis=0)
    half = (0.5 + PADDING) * max(float((high - low).max()), least)
    middle = (low + high) / 2
    return middle - half, middle + half


def _groups(answers: Sequence[dict[str, Any]], near: float) -> list[Group]:
    """Group coinciding results, in the order of the solvers."""
    groups: list[Group] = []
    for answer in answers:
        x = np.array(answer["null_space_N"])
        for group in groups:
            if group.admissible == answer["admissible"] and np.linalg.norm(x - group.x) <= near:
                group.solvers.append(answer["solver"])
                break
        else:
            groups.append(Group(x, [answer["solver"]], answer["admissible"]))
    return groups


def _wrapped(group: Group) -> list[str]:
    text = ", ".join(group.solvers) + ("" if group.admissible else " (not admissible)")
    return textwrap.wrap(text, LETTERS) or [""]


def _panel(page: Chart, corner: tuple[float, float], size: Array, window: tuple[Array, Array]) -> Panel:
    width, height = page.get_size_inches()
    axes = page.add_axes((corner[0] / width, corner[1] / height, size[0] / width, size[1] / height))
    low, high = window
    axes.set_xlim(low[0], high[0])
    if len(low) == 2:
        axes.set_ylim(low[1], high[1])
    return Panel(axes, low, high, size)


def _legend(
    page: Chart, entries: list[tuple[Group, list[str]]], corner: tuple[float, float], notes: list[str], *, empty: bool
) -> None:
    """Write the legend of solvers downwards from the corner."""
    x, y = corner[0] + 0.14, corner[1] - 0.1
    inches = page.dpi_scale_trans
    what = "no tensions are admissible" if empty else "shaded: the admissible tensions"
    page.text(x - 0.1, y, what, transform=inches, va="center", color=BAD if empty else GOOD, fontweight="bold")
    y -= 1.5 * LINE
    for number, (group, texts) in enumerate(entries, 1):
        write_badge(page, (x, y), number, group.admissible, inches)
        for text in texts:
            page.text(x + 0.22, y, text, transform=inches, va="center", color=INK)
            y -= LINE
        y -= SPACE
    y -= SPACE
    for text in notes:
        page.text(x - 0.1, y, text, transform=inches, va="center", color=SOFT)
        y -= LINE
