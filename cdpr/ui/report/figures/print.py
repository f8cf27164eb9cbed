"""Figures for print: column width, 8 pt text and legends above the panels."""

from __future__ import annotations

import re
from collections.abc import Sequence
from numbers import Real

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.log.run import Run
from cdpr.ui.report.figures.canvas import Axes, Chart, text_width
from cdpr.ui.report.figures.chart import OnChart
from cdpr.ui.report.figures.overlay import draw_overlay, overlay_entries
from cdpr.ui.report.figures.panels import draw_panel, limit_entries
from cdpr.ui.report.plots.overlay import shades, span
from cdpr.ui.report.plots.panel import Entry, Panel
from cdpr.ui.report.style import shorten

WIDTHS = {"ieee": 3.5, "ieee-wide": 7.16}  # in: one and two columns of IEEE journals
UNITS = {"in": 1.0, "cm": 1.0 / 2.54, "mm": 1.0 / 25.4, "pt": 1.0 / 72.0}  # in
NARROWEST, WIDEST = 2.0, 40.0  # in: narrower figures have no room for a legend, wider ones are probably mistakes

LETTERS = 8.0  # pt, as IEEE requires

# Lengths in inches.
LEFT, RIGHT, BOTTOM, GAP = 0.62, 0.1, 0.4, 0.1
TICK, LABEL, EDGE = 0.12, 0.13, 0.02  # from an axis to its tick numbers, height of a rotated label, and outer margin
NUMBERS = 0.17  # height of the event numbers above the first panel
LEAST_NAME = 5  # letters: names are not shortened further
LINE, SAMPLE, APART = 0.145, 0.22, 0.14  # of a legend: line spacing, length of a sample line, distance of two entries
LEAST, SHARE = 1.05, 0.2  # height of a panel: minimum, and fraction of the width
A_TICK = 0.55  # width of the time axis per tick


def inches(width: str | float) -> float:
    """Return a width in inches.

    Args:
        width: a name in `WIDTHS`, a number of inches, or a number with a unit, such as "88 mm".

    Raises:
        CdprError: if the width is invalid or out of range.
    """
    allowed = f"{', '.join(WIDTHS)}, a number of inches from {NARROWEST:g} to {WIDEST:g}, or one with its unit: '88 mm'"
    value = np.nan
    if isinstance(width, str):
        found = re.fullmatch(r"\s*([0-9]+\.?[0-9]*|\.[0-9]+)\s*([a-z]*)\s*", width, re.ASCII)
        if width in WIDTHS:
            value = WIDTHS[width]
        elif found and (found[2] or "in") in UNITS:  # command lines pass numbers as text
            value = float(found[1]) * UNITS[found[2] or "in"]
    elif isinstance(width, Real) and not isinstance(width, bool):
        value = float(width)
    if not NARROWEST <= value <= WIDEST:
        raise CdprError(f"plot: width must be {allowed}, got {shown(width)}")
    return value


def on_paper(run: Run, panels: Sequence[Panel], width: float) -> Chart:
    """Draw panels below one another in a figure of this width (in), with legends above them and no title.

    The left margin grows if tick numbers are long.
    """
    drawn = _drawn(run, panels, width, LEFT, [False] * len(panels))
    left = max(LEFT, *map(_room, drawn.axes))
    powers = [bool(axes.yaxis.get_major_formatter().get_offset()) for axes in drawn.axes]
    return drawn if left == LEFT and not any(powers) else _drawn(run, panels, width, left, powers)


def _room(axes: Axes) -> float:
    """Return the width (in) of the tick numbers and the label of the vertical axis."""
    low, high = axes.get_ylim()
    places = [place for place in axes.yaxis.get_majorticklocs() if low <= place <= high]
    texts = axes.yaxis.get_major_formatter().format_ticks(places)
    power = axes.yaxis.get_major_formatter().get_offset()
    longest = max((text_width(text, LETTERS) for text in [*texts, power]), default=0.0)
    return longest + TICK + LABEL + EDGE


def _drawn(run: Run, panels: Sequence[Panel], width: float, left: float, powers: Sequence[bool]) -> Chart:
    """Draw with left margin `left`, and with space above panels whose tick numbers share a power of ten."""
    under, across = shades(run), span(run)
    inner = width - left - RIGHT
    tall = [max(LEAST, SHARE * inner, text_width(panel.label, LETTERS) + 0.06) for panel in panels]
    numbers = NUMBERS if run.events else 0.05
    entries = [[*panel.entries, *limit_entries(run, panel)] for panel in panels]
    entries[0] += overlay_entries(run, under)
    legends = [_rows(each, inner) for each in entries]
    above = [LINE * len(rows) + max(numbers if i == 0 else 0.04, NUMBERS * powers[i]) for i, rows in enumerate(legends)]
    height = sum(tall) + sum(above) + GAP * (len(panels) - 1) + BOTTOM
    sheet = OnChart(width, height)
    top = height
    for i, panel in enumerate(panels):
        _write(sheet, legends[i], left, top)
        top -= above[i]
        frame = sheet.frame((left, top - tall[i], inner, tall[i]))
        axes = frame.axes
        draw_overlay(frame, run, under, across, numbered=i == 0)
        frame.scale(x=across)
        draw_panel(frame, run, panel, left - EDGE - LABEL, ticks=max(3, int(inner / A_TICK)))
        if i == len(panels) - 1:
            frame.label_time("time (s)", 0.25)
        axes.tick_params(labelsize=LETTERS)
        for text in (axes.xaxis.label, axes.yaxis.label, axes.yaxis.get_offset_text(), *axes.texts):
            text.set_fontsize(LETTERS)
        top -= tall[i] + GAP
    return sheet.chart


def _rows(entries: Sequence[Entry], width: float) -> list[list[Entry]]:
    """Break a legend into lines."""
    rows: list[list[Entry]] = []
    left = 0.0
    for entry in (_fitted(each, width) for each in entries):
        takes = _takes(entry)
        if not rows or takes > left:
            rows.append([])
            left = width
        rows[-1].append(entry)
        left -= takes + APART
    return rows


def _fitted(entry: Entry, width: float) -> Entry:
    """Shorten a name that is wider than the legend."""
    text, look = entry
    while _takes((text, look)) > width and len(text) > LEAST_NAME:
        text = shorten(text, len(text) - 1)
    return text, look


def _sample(entry: Entry) -> float:
    """Return the width of an entry's sample line; remarks have none."""
    return 0.0 if entry[1].get("linestyle") == "" else SAMPLE + 0.05


def _takes(entry: Entry) -> float:
    return _sample(entry) + text_width(entry[0], LETTERS)


def _write(sheet: OnChart, rows: Sequence[Sequence[Entry]], left: float, top: float) -> None:
    """Write a legend below `top`, in inches from the lower edge of the figure."""
    for row, entries in enumerate(rows):
        x, y = left, top - (row + 0.5) * LINE
        for entry in entries:
            text, look = entry
            sheet.line([x, x + SAMPLE], [y, y], look)
            sheet.text(x + _sample(entry), y, text, {"va": "center", "fontsize": LETTERS})
            x += _takes(entry) + APART
