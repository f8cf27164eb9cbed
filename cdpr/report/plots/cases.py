"""Runs of a study over one another: how far each is from where it should be, and its tensions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cdpr.log.run import Run
from cdpr.report.marks import LEAST_ERROR, overlaid_looks, shorten
from cdpr.report.plots.histories import Points, histories
from cdpr.report.plots.panel import Curves, Entry, Panel, calm_until

PANELS = (
    # label, quantity of `histories` (its first column), least range
    ("position error (mm)", "position_error", LEAST_ERROR),
    ("orient. error (mrad)", "orientation_error", LEAST_ERROR),
    ("largest tension (N)", "highest", 1.0),
    ("smallest tension (N)", "lowest", 1.0),
)
BEYOND = 10.0  # times what a run that diverges came to while it was calm: more would flatten all others


def overlay(runs: Mapping[str, Run]) -> list[Panel]:
    """Return the panels of runs by their names: one line each."""
    looks = overlaid_looks("case", list(runs))
    legend: list[Entry] = [(shorten(who), look) for who, look in looks.items()]
    return [
        Panel(
            label, tuple(Curves.of(_calm(run, name), who, looks[who]) for who, run in runs.items()), legend, least=least
        )
        for label, name, least in PANELS
    ]


def _calm(run: Run, name: str) -> Points:
    """A quantity without what a run that diverged ends in."""
    points = histories(run)[name].columns(slice(0, 1))
    until = calm_until(run)
    if until is None:
        return points
    before = np.abs(points.values[points.time < until])
    most = BEYOND * float(np.max(before[np.isfinite(before)], initial=0.0))
    return Points(points.time, np.where((points.time < until) | (np.abs(points.values) <= most), points.values, np.nan))
