"""Legends, and the width that they share in all figures of one run."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr.report.figures.surface import Sheet
from cdpr.report.marks import shorten
from cdpr.report.plots.panel import Entry

LINE = 0.165  # in, from one line of text to the next
SAMPLE = 0.3  # in, of line
LETTER = 0.071  # in, mean width of a letter
MARGIN = 0.12  # in, between the axes and the legend
LEAST = 18  # letters: our own texts are no longer than this


def legend_width(cables: Sequence[str], least: int = LEAST) -> float:
    """Return the width (in) to keep free at the right for a legend of these names, of at least so many letters."""
    longest = max((len(shorten(name)) for name in cables), default=0)
    return MARGIN + SAMPLE + 0.1 + LETTER * max(longest, least)


def write_legend(sheet: Sheet, entries: Sequence[Entry], corner: tuple[float, float]) -> None:
    """Write a legend with its upper left corner at `corner`, in from the lower left of the sheet.

    By hand, because matplotlib's own legends would take a third of the time of a report.
    """
    x, y = corner[0] + MARGIN, corner[1] - 0.1
    for text, look in entries:
        sample = [x, x + 0.5 * SAMPLE, x + SAMPLE]  # a mark stands on its middle
        sheet.line(sample, [y] * 3, look)
        sheet.text(x + SAMPLE + 0.1, y, text, {"va": "center"})
        y -= LINE
