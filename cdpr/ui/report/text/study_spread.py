"""Mean and spread over the seeds of a study as rows of text, for terminal and page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from cdpr.analysis.study.spread import Consistent, Distribution, Spread
from cdpr.ui.report.text.aligned import digits
from cdpr.ui.report.text.study import Figure, label_text

NAMES = {"nis": "NIS", "nees": "NEES"}


class Cell(NamedTuple):
    """Cell of the table: mean and standard deviation, and below them the band."""

    text: str
    band: str = ""
    outside: bool = False  # a mean outside its band


def shown(found: Sequence[Spread], figures: Sequence[Figure]) -> list[Figure]:
    """Return the figures that are not zero in all runs."""
    return [
        figure
        for figure in figures
        if any((each := one.figures.get(figure.column)) and (each.low or each.high) for one in found)
    ]


def kinds(found: Sequence[Spread]) -> list[str]:
    """Return "nis" and "nees", if some runs have them."""
    return [kind for kind in NAMES if any(kind in one.consistent for one in found)]


def headings(kinds: Sequence[str]) -> list[str]:
    """Return the titles of the columns on consistency."""
    return [f"{NAMES[kind]} at the end" for kind in kinds]


def row(spread: Spread, figures: Sequence[Figure], kinds: Sequence[str]) -> list[Cell]:
    """Return the cells of one combination: number of runs, figures, and consistency."""
    runs = str(spread.runs) if spread.used == spread.runs else f"{spread.used} of {spread.runs}"
    return [
        Cell(runs),
        *(_figure(spread.figures.get(figure.column), figure.scale) for figure in figures),
        *(_consistent(spread.consistent.get(kind)) for kind in kinds),
    ]


def labels(spread: Spread, axes: Sequence[str]) -> list[str]:
    """Return the values on the axes."""
    return [label_text(spread.labels.get(axis)) for axis in axes]


def _figure(found: Distribution | None, scale: float) -> Cell:
    if found is None:
        return Cell("-")
    deviation = "" if found.std is None else f" ± {_short(scale * found.std)}"
    return Cell(
        f"{digits(scale * found.mean)}{deviation}", f"{digits(scale * found.low)} to {digits(scale * found.high)}"
    )


def _consistent(found: Consistent | None) -> Cell:
    if found is None:
        return Cell("-")
    band = f"{found.low:.3g} to {found.high:.3g}"
    return Cell(f"{found.mean:.3g}", band, not found.low <= found.mean <= found.high)


def _short(value: float) -> str:
    """Return a standard deviation with two significant digits."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.2g}"
