"""Section of a study's page with mean and spread over the seeds."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from cdpr.analysis.study import Results
from cdpr.analysis.study.spread import Spread
from cdpr.ui.report.pages.page import table
from cdpr.ui.report.text.study import ESTIMATE, Figure, figures_of
from cdpr.ui.report.text.study_spread import Cell, headings, kinds, labels, row, shown

MOST_ROWS = 200
EXPLAINED = (
    "Mean ± standard deviation of the runs, and below them the band from the 2.5th to the 97.5th percentile, which "
    "contains 95 % of many runs. spread.csv contains all figures."
)
CONSISTENT = (
    "NIS and NEES are first averaged over the time of each run, then over the runs. The last columns are the mean of "
    "their last values in all runs, and below it the band that contains this mean with a probability of 95 % if the "
    "model of the estimator is right: a chi-square distribution for this number of runs. Bold values are outside."
)


def spread_section(results: Results) -> str:
    """Return the section; "" for a study that does not vary the seed."""
    found = results.spreads
    if not found:
        return ""
    figures = figures_of(results.table.records())
    out = "<h2>Mean and spread over the seeds</h2>\n"
    out += _table(found, results.table.axes, shown(found, [each for each in figures if each not in ESTIMATE]), ())
    if more := len(found[MOST_ROWS:]):
        out += f"\n<p>And {more} more in spread.csv.</p>"
    out += f"\n<p>{EXPLAINED}</p>"
    estimate, also = shown(found, [each for each in figures if each in ESTIMATE]), kinds(found)
    if estimate:
        out += f"\n<h3>Estimator</h3>\n{_table(found, results.table.axes, estimate, also)}"
        out += f"\n<p>{CONSISTENT}</p>" if also else ""
    return out


def _table(found: Sequence[Spread], axes: Sequence[str], figures: Sequence[Figure], also: Sequence[str]) -> str:
    """Return the table of these figures, and of the consistency of the kinds `also`."""
    axes = [axis for axis in axes if any(axis in each.labels for each in found)]
    blocks = ["Block"] if any(each.block is not None for each in found) else []
    titles = [*blocks, *axes, "Runs", *(figure.title for figure in figures), *headings(also)]
    rows = []
    for each in found[:MOST_ROWS]:
        heads = [*([each.block or ""] if blocks else []), *labels(each, axes)]
        rows.append((*map(escape, heads), *map(_cell, row(each, figures, also))))
    return table(rows, tuple(escape(title).replace(".", ".<wbr>") for title in titles))  # may break in key names


def _cell(cell: Cell) -> str:
    text = f"<strong>{escape(cell.text)}</strong>" if cell.outside else escape(cell.text)
    return text + (f"<br><small>{escape(cell.band)}</small>" if cell.band else "")
