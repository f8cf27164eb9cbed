"""Figure of `cdpr tension` for null spaces of more than two dimensions: the range of each tension."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr.model.robot import Array
from cdpr.ui.report.figures.canvas import Chart, Line2D, MaxNLocator, styled
from cdpr.ui.report.figures.legend import LINE
from cdpr.ui.report.figures.null_space_panel import ADMISSIBLE, BAD, GOOD, Group, write_badge
from cdpr.ui.report.figures.placing import spread_out
from cdpr.ui.report.style import INK, PALE, SOFT, shorten
from cdpr.ui.report.text.aligned import vector

# Lengths in inches.
WIDTH = 5.6  # of the panel
LANE = 0.46  # height of a cable's row
BAR = 0.11  # half the height of a range
LEFT, BOTTOM, TOP, GAP, COLUMN = 1.15, 0.55, 0.8, 0.3, 3.0
BADGE = 0.19  # between two numbers
LETTERS = 38  # per line of the column
RANGE: dict[str, Any] = {"facecolor": ADMISSIBLE, "edgecolor": GOOD, "linewidth": 0.9, "zorder": 2}
LIMITS_BEYOND = 3.0  # a limit farther away than this multiple of the widest range is not shown


@styled
def chart(figures: dict[str, Any], groups: Sequence[Group], notes: Sequence[str]) -> Chart:
    """Draw the limits and range of each cable, and the numbered results above their tensions."""
    cables, m = figures["cables"], figures["m"]
    ranges = np.array(figures["ranges_N"], dtype=float)  # NaN if nothing is admissible
    N, c = (np.array(figures["null_space"][key]) for key in ("basis", "particular_N"))
    tensions = np.array([c + N @ group.x for group in groups]).reshape(-1, m)
    limits = np.array([[cable["tension_min_N"], cable["tension_max_N"]] for cable in cables])
    low, high = _window(ranges, tensions, limits)
    entries = [textwrap.wrap(_text(group), LETTERS) for group in groups]
    below = [line for note in notes for line in textwrap.wrap(note, LETTERS)]
    height = TOP + max(m * LANE + BOTTOM, LINE * (sum(map(len, entries)) + len(below) + len(groups) + 4))
    width = LEFT + WIDTH + GAP + COLUMN
    page = Chart(figsize=(width, height))
    axes = page.add_axes(
        (LEFT / width, (height - TOP - m * LANE) / height, WIDTH / width, m * LANE / height),
        xlim=(low, high),
        ylim=(m - 0.5, -0.5),
    )
    axes.grid(visible=False, axis="y")
    axes.xaxis.set_major_locator(MaxNLocator(nbins=8, steps=(1, 2, 2.5, 5, 10)))
    axes.set_yticks(range(m), [shorten(cable["name"], 16) for cable in cables])
    axes.set_xlabel("tension (N)")
    inch = (high - low) / WIDTH
    for i in range(m):
        middle = i + 0.2
        axes.add_artist(Line2D([max(low, limits[i, 0]), min(high, limits[i, 1])], [middle] * 2, color=PALE))
        for value in limits[i]:
            if low <= value <= high:
                axes.add_artist(Line2D([value] * 2, [middle - 0.16, middle + 0.16], color=INK, linewidth=1.1, zorder=3))
        if np.isfinite(ranges[i]).all():
            bottom, size = middle - BAR / LANE, 2.0 * BAR / LANE
            axes.broken_barh([(ranges[i, 0], ranges[i, 1] - ranges[i, 0])], (bottom, size), **RANGE)
        shown = [k for k in range(len(groups)) if low <= tensions[k, i] <= high]
        places = spread_out([float(tensions[k, i] - low) / inch for k in shown], BADGE, 0.0, WIDTH)
        for k, place in zip(shown, places, strict=True):
            colour = GOOD if groups[k].admissible else BAD
            x = tensions[k, i]
            axes.add_artist(
                Line2D([x, x, low + place * inch], [middle + 0.13, middle - 0.13, i - 0.2], color=colour, linewidth=0.9)
            )
            write_badge(axes, (low + place * inch, i - 0.24), k + 1, groups[k].admissible, axes.transData)
    _column(page, groups, entries, below, (LEFT + WIDTH + GAP, height - TOP), empty=not np.isfinite(ranges).all())
    title = f"{figures['robot']}: the range of each tension that balances the wrench"
    page.text(LEFT / width, 1.0 - 0.18 / height, title, va="top", fontsize=10.0, fontweight="bold")
    where = f"{vector(figures['wrench']['value'])} N, N m at {vector(figures['pose']['position_m'])} m"
    page.text(LEFT / width, 1.0 - 0.4 / height, where, va="top", color=SOFT)
    return page


def _window(ranges: Array, tensions: Array, limits: Array) -> tuple[float, float]:
    """Return the window of all ranges, results and nearby limits."""
    values = np.concatenate([ranges[np.isfinite(ranges)], tensions.ravel()])
    if not len(values):
        values = limits.ravel()
    low, high = float(values.min()), float(values.max())
    reach = LIMITS_BEYOND * max(high - low, 1.0)
    near = limits[(limits >= low - reach) & (limits <= high + reach)]
    low, high = min([low, *near.tolist()]), max([high, *near.tolist()])
    room = 0.04 * max(high - low, 1.0)
    return low - room, high + room


def _text(group: Group) -> str:
    return ", ".join(group.solvers) + ("" if group.admissible else " (not admissible)")


def _column(
    page: Chart, groups: Sequence[Group], entries: Sequence[Sequence[str]], notes: Sequence[str],
    corner: tuple[float, float], *, empty: bool,
) -> None:  # fmt: skip
    """Write the legend of solvers downwards from the corner."""
    x, y = corner[0] + 0.04, corner[1] - 0.1
    inches = page.dpi_scale_trans
    what = "no tensions are admissible" if empty else "bars: range of each tension"
    page.text(x, y, what, transform=inches, va="center", color=BAD if empty else GOOD, fontweight="bold")
    y -= 1.6 * LINE
    for number, (group, texts) in enumerate(zip(groups, entries, strict=True), 1):
        write_badge(page, (x + 0.1, y), number, group.admissible, inches)
        for text in texts:
            page.text(x + 0.32, y, text, transform=inches, va="center", color=INK)
            y -= LINE
        y -= 0.4 * LINE
    for text in notes:
        page.text(x, y, text, transform=inches, va="center", color=SOFT)
        y -= LINE
