"""Overlaid runs of a study: pose errors and extreme tensions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cdpr.log.run import Run
from cdpr.ui.report.plots.histories import Points, histories
from cdpr.ui.report.plots.panel import Curves, Entry, Panel, calm_until
from cdpr.ui.report.style import LEAST_ERROR, overlaid_looks, shorten

PANELS = (
    # label, quantity of `histories` (its first column), smallest range
    ("position error (mm)", "position_error", LEAST_ERROR),
    ("orient. error (mrad)", "orientation_error", LEAST_ERROR),
    ("largest tension (N)", "highest", 1.0),
    ("smallest tension (N)", "lowest", 1.0),
)
BEYOND = 10.0  # multiple of the largest value before divergence; larger values would flatten all other lines


def overlay(runs: Mapping[str, Run]) -> list[Panel]:
    """Return the panels with one line for each run."""
    looks = overlaid_looks("case", list(runs))
    legend: list[Entry] = [(shorten(who), look) for who, look in looks.items()]
    return [
        Panel(
            label, tuple(Curves.of(_calm(run, name), who, looks[who]) for who, run in runs.items()), legend, least=least
        )
        for label, name, least in PANELS
    ]


def _calm(run: Run, name: str) -> Points:
    """Return a quantity without the final values of a diverged run."""
    points = histories(run)[name].columns(slice(0, 1))
    until = calm_until(run)
    if until is None:
        return points
    before = np.abs(points.values[points.time < until])
    most = BEYOND * float(np.max(before[np.isfinite(before)], initial=0.0))
    return Points(points.time, np.where((points.time < until) | (np.abs(points.values) <= most), points.values, np.nan))
