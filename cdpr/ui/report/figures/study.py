"""Small multiples of a study: one figure of all runs over the study's axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np

from cdpr.analysis.study.points import Label
from cdpr.analysis.study.spread import distribution
from cdpr.ui.report.figures.legend import LETTER, LINE, legend_width, write_legend
from cdpr.ui.report.figures.study_layout import LEAST_PLACES, MOST_PLACES, Curve, Layout, panels, thinned
from cdpr.ui.report.figures.surface import LABEL, Frame, Look
from cdpr.ui.report.figures.svg import OnPage, ticks_within
from cdpr.ui.report.plots.panel import room_for
from cdpr.ui.report.style import CABLES, shorten
from cdpr.ui.report.text.study import Figure, Record, label_text

# Lengths in inches.
ALONE_WIDE, WIDTH = 5.2, 9.0  # width of a figure with one panel, which takes half a page, and with more
ALONE, HEIGHT = 2.4, 1.75  # height of panels in a single row, and in several rows
LEFT, TOP, UNTITLED, BOTTOM = 0.75, 0.4, 0.15, 0.55
GAP, ROW_GAP = 0.25, 0.62
ACROSS = 4  # panels per row

# Coinciding lines remain visible: the first is broad, later ones are narrower and dashed, and later markers smaller.
# Widths in pt; the widest line is at most three times the narrowest, so that no line looks more important.
BROAD, MORE, THIN, ONLY = 2.2, 0.25, 1.4, 1.4  # first width, increment per line, last width, width of a single line
LARGE, GROWTH, SMALL = 8.5, 0.3, 3.8  # size of the first marker, increment per line, size of the last marker
FULL = 2.6  # in: lines and markers are smaller in narrower panels
MARKS = "osD^vPX*"
DASHES: tuple[Any, ...] = ((0, (2.2, 1.6)), (0, (4.0, 2.4)), (0, (1.2, 2.2)))

BESIDE = 0.1  # offset between the dots of two lines, if x is categorical

MOST_NAMES = 24  # on the x axis
DOTS = 3000  # per figure

DECADE = 30.0  # largest ratio on a linear scale
FEW = 3.0  # decades up to which a logarithmic scale has ticks at 2 and 5
TICKS = 6  # largest number of tick intervals
NAME = 0.45  # in, width of a tick's name
MARK = 0.055  # height of a row of crosses, relative to the panel
ABOVE, BELOW = 0.05, 0.3  # in: distance of a title above its frame, and of the x label below it
CROWDED, TURNED = 30, 35.0  # total letters on the x axis above which names are rotated, and the angle in degrees


@dataclass(frozen=True)
class Scale:
    """Scale of a panel edge: linear or logarithmic.

    Attributes:
        low: lower end; its decadic logarithm on a logarithmic scale.
        high: upper end; its decadic logarithm on a logarithmic scale.
        logarithmic: True for a logarithmic scale.
    """

    low: float
    high: float
    logarithmic: bool

    @classmethod
    def of(cls, values: Sequence[float], least: float = 0.0) -> Scale:
        """Return a scale with a margin around `values`; ranges below `least` are treated as noise."""
        low, high = min(values), max(values)
        if low > 0.0 and high > least and high / low > DECADE:
            first, last = math.log10(low), math.log10(high)
            air = 0.06 * (last - first)
            return cls(first - air, last + air, True)
        air = 0.06 * (high - low)
        if high == low:
            air = 0.05 * abs(high) or 1.0
        air = max(air, 0.5 * (room_for(low, high, least) - (high - low)))
        return cls(low - air, high + air, False)

    @property
    def span(self) -> tuple[float, float]:
        """Lower and upper end."""
        return self.low, self.high

    def at(self, value: float) -> float:
        """Return the coordinate of a value; NaN if it has no logarithm."""
        if not self.logarithmic:
            return value
        return math.log10(value) if value > 0.0 else nan

    def ticks(self, most: int) -> dict[float, str]:
        """Return the labels of about `most` ticks, by coordinate."""
        if not self.logarithmic:
            return {tick: f"{tick + 0.0:.6g}" for tick in ticks_within(self.low, self.high, most)}
        parts = (1, 2, 5) if self.high - self.low < FEW else (1,)
        every = math.ceil((self.high - self.low) / most)
        powers = range(math.floor(self.low / every) * every, math.ceil(self.high), every)
        found = {power + math.log10(part): f"{part * 10.0**power:g}" for power in powers for part in parts}
        return {place: name for place, name in found.items() if self.low <= place <= self.high}


def multiples(layout: Layout, records: Sequence[Record], figure: Figure, dots: int = DOTS) -> OnPage:
    """Draw one quantity of all runs: a panel per combination of `layout.panels`, all with the same scales.

    Args:
        layout: axes of the figure.
        records: cases of the study.
        figure: quantity to draw.
        dots: approximate largest number of points; of more, only local minima and maxima are drawn.
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
    legend = legend_width([*names, *(text for text, _ in [*heading, *ending])], least=0) if names or crosses else 0.1
    width = WIDTH if len(drawn) > 1 else ALONE_WIDE
    wide = (width - LEFT - legend - (across - 1) * GAP) / across
    looks = {label: _line_style(i, len(labels), min(1.0, wide / FULL)) for i, label in enumerate(labels)}
    entries = list(zip(names, looks.values(), strict=False))
    tall = ALONE if down == 1 else HEIGHT
    x = _along(layout, drawn, wide)
    height = top + down * tall + (down - 1) * ROW_GAP + BOTTOM + x.room
    height = max(height, top + LINE * (len(entries) + 3))
    sheet = OnPage(width, height)
    values = [value for curves in drawn.values() for curve in curves for at in curve.values for value in at]
    y = Scale.of(values or [0.0, 1.0], figure.least)
    heights = y.ticks(TICKS)
    for k, (title, curves) in enumerate(drawn.items()):
        row, column = divmod(k, across)
        left = LEFT + column * (wide + GAP)
        bottom = height - top - tall - row * (tall + ROW_GAP)
        frame = sheet.frame((left, bottom, wide, tall))
        frame.scale(x=x.span, y=y.span)
        last = k + across >= len(drawn)
        frame.axis(0, [*x.ticks], [*x.ticks.values()] if last else [], turned=x.turned)
        frame.axis(1, [*heights], [*heights.values()] if column == 0 else [])
        sheet.text(left, bottom + tall + ABOVE, shorten(title, 44), {})
        if last:
            below = {"ha": "center", "va": "top", "fontsize": LABEL}
            sheet.text(left + wide / 2, bottom - BELOW - x.room, shorten(layout.x, 40), below)
        for i, curve in enumerate(curves):
            aside = 0.0 if layout.numeric else BESIDE * (i - (len(curves) - 1) / 2)
            _draw(frame, layout, curve, looks[curve.label], aside, x, y, i)
    write_legend(sheet, [*heading, *entries, *ending], (width - legend, height - top))
    return sheet


def _line_style(i: int, count: int, scale: float) -> dict[str, Any]:
    """Return the style of line `i` of `count`, and of its markers."""
    share, broad, large = i / (count - 1) if count > 1 else 1.0, BROAD + MORE * count, LARGE + GROWTH * count
    return {
        "color": CABLES[i % len(CABLES)],
        "linewidth": scale * broad + share * (THIN - scale * broad) if count > 1 else ONLY,
        "linestyle": DASHES[(i - 1) % len(DASHES)] if i else "-",
        "marker": MARKS[i % len(MARKS)] if count > 1 else "o",
        "markersize": scale * (large + share * (SMALL - large)),
    }


def _across(layout: Layout, records: Sequence[Record], count: int) -> int:
    """Return the number of panels per row: one for each value of the last axis, if these are few."""
    last = len({record[layout.panels[-1]] for record in records}) if layout.panels else 1
    return last if 1 < last <= ACROSS else min(ACROSS, count)


def _draw(frame: Frame, layout: Layout, curve: Curve, look: Look, aside: float, x: XAxis, y: Scale, row: int) -> None:
    """Draw dots, joined through medians if a place has several; draw crosses at the top for cases without value.

    Of runs that differ only in their seeds, the dot is the mean, a thick bar the standard deviation, and a thin one the
    95 % band.
    """
    at = [x.places[place] + aside for place in curve.x]
    found = [distribution(values) for values in curve.values]
    middle = [each.mean for each in found] if layout.seeds else [sorted(each)[len(each) // 2] for each in curve.values]
    joined = {} if layout.numeric and not layout.scattered else {"linestyle": ""}
    frame.line(at, [y.at(value) for value in middle], {**look, **joined})
    several = [i for i, values in enumerate(curve.values) if len(values) > 1]
    ends = [(min(values), max(values)) for values in curve.values]
    if layout.seeds:
        ends = [(each.low, each.high) for each in found]
        deviations = [(each.mean - (each.std or 0.0), each.mean + (each.std or 0.0)) for each in found]
        _bars(frame, [(at[i], *deviations[i]) for i in several], y, {"linewidth": 2.2, "color": look["color"]})
    _bars(frame, [(at[i], *ends[i]) for i in several], y, {"linewidth": 0.8, "color": look["color"]})
    lost = [x.places[place] + aside for place in curve.lost]
    cross = {"marker": "x", "markersize": 4.0, "linestyle": "", "color": look["color"]}
    if lost:
        frame.line(lost, [0.965 - MARK * row] * len(lost), cross, "y")


def _bars(frame: Frame, bars: Sequence[tuple[float, float, float]], y: Scale, look: Look) -> None:
    """Draw vertical lines, each with its place and its ends."""
    if bars:
        places, ends = [], []
        for at, low, high in bars:
            places += [at, at, nan]
            ends += [y.low if y.logarithmic and low <= 0.0 else y.at(low), y.at(high), nan]
        frame.line(np.array(places), np.array(ends), look)


@dataclass(frozen=True)
class XAxis:
    """The x axis: coordinate of each value, range and tick labels."""

    places: Mapping[Label, float]
    span: tuple[float, float]
    ticks: Mapping[float, str]
    turned: float = 0.0
    room: float = 0.0  # in, height of rotated names


def _along(layout: Layout, drawn: Mapping[str, Sequence[Curve]], wide: float) -> XAxis:
    """Return the x axis of panels of width `wide`, in."""
    places = dict.fromkeys(at for curves in drawn.values() for curve in curves for at in (*curve.x, *curve.lost))
    if layout.numeric:
        numbers = {place: float(place or 0.0) for place in places}
        scale = Scale.of(list(numbers.values()))
        at = {place: scale.at(number) for place, number in numbers.items()}
        return XAxis(at, scale.span, scale.ticks(min(TICKS, int(wide / NAME))))
    every = math.ceil(len(places) / MOST_NAMES)
    names = {float(i): shorten(label_text(label), 14) for i, label in enumerate(places) if i % every == 0}
    at, span = {place: float(i) for i, place in enumerate(places)}, (-0.5, len(places) - 0.5)
    if sum(map(len, names.values())) <= CROWDED:
        return XAxis(at, span, names)
    room = LETTER * max(map(len, names.values())) * math.sin(math.radians(TURNED))
    return XAxis(at, span, names, TURNED, room)
