"""Legends, and their common width in all figures of a run."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr.ui.report.figures.surface import Sheet
from cdpr.ui.report.plots.panel import Entry
from cdpr.ui.report.style import shorten

LINE = 0.165  # in, line spacing
SAMPLE = 0.3  # in, length of a sample line
LETTER = 0.071  # in, mean width of a letter
MARGIN = 0.12  # in, between the axes and the legend
LEAST = 18  # letters: fixed legend texts are not longer


def legend_width(cables: Sequence[str], least: int = LEAST) -> float:
    """Return the width (in) of a legend with these cable names, for at least `least` letters."""
    longest = max((len(shorten(name)) for name in cables), default=0)
    return MARGIN + SAMPLE + 0.1 + LETTER * max(longest, least)


def write_legend(sheet: Sheet, entries: Sequence[Entry], corner: tuple[float, float]) -> None:
    """Write a legend with its upper left corner at `corner`, in inches from the lower left of the sheet.

    Drawn by hand, because matplotlib's legends would take a third of the time of a report.
    """
    x, y = corner[0] + MARGIN, corner[1] - 0.1
    for text, look in entries:
        sample = [x, x + 0.5 * SAMPLE, x + SAMPLE]  # a marker lies on the middle point
        sheet.line(sample, [y] * 3, look)
        sheet.text(x + SAMPLE + 0.1, y, text, {"va": "center"})
        y -= LINE
