"""Small multiples of a study: one figure of the runs over its axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from cdpr.report.figures.canvas import Axes, Chart, Line2D, styled
from cdpr.report.figures.chart import OnChart
from cdpr.report.figures.legend import LINE, legend_width, write_legend
from cdpr.report.figures.study_layout import LEAST_PLACES, MOST_PLACES, Curve, Layout, panels, thinned
from cdpr.report.marks import CABLES, INK, shorten
from cdpr.report.plots.panel import room_for
from cdpr.report.text.study import Figure, Record, label_text

# Inches.
WIDTH = 9.0  # of every figure: that of its card, with letters as large as the page's
ALONE, HEIGHT = 2.4, 1.75  # of panels that stand in one row, and in more
LEFT, TOP, UNTITLED, BOTTOM = 0.75, 0.4, 0.15, 0.55
GAP, ROW_GAP = 0.25, 0.62
ACROSS = 4  # panels in a row

# Lines that lie upon each other are all seen: the first is broad, each that follows narrower and broken, and each has
# a mark of its own, smaller than the one below. Widths in pt.
BROAD, THIN, ONLY = 4.2, 1.3, 1.4
LARGE, SMALL = 8.5, 3.8
FULL = 2.6  # in: in narrower panels lines and marks are smaller
MARKS = "osD^vPX*"
DASHES: tuple[Any, ...] = ((0, (2.2, 1.6)), (0, (4.0, 2.4)), (0, (1.2, 2.2)))

BESIDE = 0.1  # from one line's dots to the next one's, where x is a row of names

MOST_NAMES = 24  # on x
DOTS = 3000  # of a figure

DECADE = 30.0  # largest ratio on a linear scale
MARK = 0.055  # height of a row of crosses, of the panel's


@styled
def multiples(layout: Layout, records: Sequence[Record], figure: Figure, dots: int = DOTS) -> Chart:
    """Draw one figure of all runs: a panel per combination of `layout.panels`, the same scales in all.

    Of more runs than about `dots` the least and the greatest of their neighbourhoods are drawn.
    """
    drawn = panels(layout, records, figure)
    most = min(MOST_PLACES, max(LEAST_PLACES, dots // sum(map(len, drawn.values()))))
    drawn = {title: [thinned(curve, most) for curve in curves] for title, curves in drawn.items()}
    top = TOP if any(drawn) else UNTITLED
    across = _across(layout, records, len(drawn))
    down = math.ceil(len(drawn) / across)
    labels = list(dict.fromkeys(curve.label for curves in drawn.values() for curve in curves))
    names = [shorten(label_text(label)) for label in labels] if layout.line else []
    crosses = any(curve.lost for curves in drawn.values() for curve in curves)
    heading = [] if layout.line is None else [(shorten(layout.line), {"linestyle": ""})]
    ending = [("× no figure: diverged, died, ...", {"linestyle": ""})] if crosses else []
    legend = legend_width([*names, *(text for text, _ in [*heading, *ending])]) if names or crosses else 0.1
    wide = (WIDTH - LEFT - legend - (across - 1) * GAP) / across
    looks = {label: _look(i, len(labels), min(1.0, wide / FULL)) for i, label in enumerate(labels)}
    entries = list(zip(names, looks.values(), strict=False))
    tall = ALONE if down == 1 else HEIGHT
    height = top + down * tall + (down - 1) * ROW_GAP + BOTTOM
    height = max(height, top + LINE * (len(entries) + 3))
    sheet = OnChart(WIDTH, height)
    chart = sheet.chart
    first: Axes | None = None
    for k, (title, curves) in enumerate(drawn.items()):
        row, column = divmod(k, across)
        left = LEFT + column * (wide + GAP)
        bottom = height - top - tall - row * (tall + ROW_GAP)
        box = (left / WIDTH, bottom / height, wide / WIDTH, tall / height)
        axes = chart.add_axes(box, sharex=first, sharey=first)
        if first is None:
            first = axes
            _scale(axes, layout, drawn, figure.least)
        axes.set_title(shorten(title, 44), fontsize=8.5, loc="left", pad=4)
        axes.tick_params(labelleft=column == 0, labelbottom=k + across >= len(drawn))
        if k + across >= len(drawn):
            axes.set_xlabel(shorten(layout.x, 40))
        for i, curve in enumerate(curves):
            _draw(axes, layout, curve, looks[curve.label], (i, len(curves)), _positions(layout, drawn))
    write_legend(sheet, [*heading, *entries, *ending], (WIDTH - legend, height - top))
    return chart


def _look(i: int, count: int, scale: float) -> dict[str, Any]:
    """How line i of so many looks, and its marks."""
    share = i / (count - 1) if count > 1 else 1.0
    return {
        "color": CABLES[i % len(CABLES)],
        "linewidth": scale * BROAD + share * (THIN - scale * BROAD) if count > 1 else ONLY,
        "linestyle": DASHES[(i - 1) % len(DASHES)] if i else "-",
        "marker": MARKS[i % len(MARKS)] if count > 1 else "o",
        "markersize": scale * LARGE + share * (SMALL - LARGE) * scale,
        "markeredgewidth": 0.0,
        "markevery": [1],  # in a legend
    }


def _across(layout: Layout, records: Sequence[Record], count: int) -> int:
    """Panels in a row: one for each place on the last axis, if these are not too many."""
    last = len({record[layout.panels[-1]] for record in records}) if layout.panels else 1
    return last if 1 < last <= ACROSS else min(ACROSS, count)


def _draw(
    axes: Axes,
    layout: Layout,
    curve: Curve,
    look: dict[str, Any],
    rank: tuple[int, int],  # of the curve, and how many there are
    place: Mapping[Any, float],
) -> None:
    """Dots, joined through the middle where a place has several; crosses at the top for cases without a figure."""
    i, count = rank
    aside = 0.0 if layout.numeric else BESIDE * (i - (count - 1) / 2)
    x = [place[at] + aside for at in curve.x]
    middle = [sorted(values)[len(values) // 2] for values in curve.values]
    joined = {} if layout.numeric and not layout.scattered else {"linestyle": ""}
    axes.add_artist(Line2D(x, middle, **{**look, **joined, "markevery": None}))
    for at, values in zip(x, curve.values, strict=True):
        if len(values) > 1:
            axes.add_artist(Line2D([at] * 2, [min(values), max(values)], linewidth=0.8, color=look["color"]))
    heights = [0.965 - MARK * i] * len(curve.lost)
    lost = [place[at] + aside for at in curve.lost]
    cross = {"marker": "x", "markersize": 4.0, "linestyle": "", "color": look["color"]}
    axes.add_artist(Line2D(lost, heights, transform=axes.get_xaxis_transform(), **cross))


def _scale(axes: Axes, layout: Layout, drawn: Mapping[str, Sequence[Curve]], least: float) -> None:
    curves = [curve for curves in drawn.values() for curve in curves]
    values = [value for curve in curves for at in curve.values for value in at]
    positions = _positions(layout, drawn)
    if layout.numeric:
        low, high, logarithmic = _limits(list(positions.values()))
        axes.set_xscale("log" if logarithmic else "linear")
        axes.set_xlim(low, high)
        axes.xaxis.set_major_formatter(_plain)
    else:
        axes.set_xlim(-0.5, len(positions) - 0.5)
        every = math.ceil(len(positions) / MOST_NAMES)
        names = [shorten(label_text(label), 14) for label in positions][::every]
        crowded = sum(map(len, names)) > 30
        axes.set_xticks(
            range(0, len(positions), every), names, rotation=35 if crowded else 0, ha="right" if crowded else "center"
        )
    low, high, logarithmic = _limits(values or [0.0, 1.0], least)
    axes.set_yscale("log" if logarithmic else "linear")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_formatter(_plain)
    axes.minorticks_off()
    axes.tick_params(colors=INK)


def _plain(value: float, _: object) -> str:
    return f"{value:g}"


def _positions(layout: Layout, drawn: Mapping[str, Sequence[Curve]]) -> dict[Any, float]:
    """Where each place on x stands."""
    places = dict.fromkeys(at for curves in drawn.values() for curve in curves for at in (*curve.x, *curve.lost))
    return {at: float(at) if layout.numeric else float(i) for i, at in enumerate(places)}  # type: ignore[arg-type]


def _limits(values: Sequence[float], least: float = 0.0) -> tuple[float, float, bool]:
    """Limits with some air, and whether the scale is logarithmic; what is less than `least` has no magnitude."""
    low, high = min(values), max(values)
    if low > 0.0 and high > least and high / low > DECADE:
        air = (high / low) ** 0.06
        return low / air, high * air, True
    air = 0.06 * (high - low)
    if high == low:
        air = 0.05 * abs(high) or 1.0
    air = max(air, 0.5 * (room_for(low, high, least) - (high - low)))
    return low - air, high + air, False
