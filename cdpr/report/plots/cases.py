"""Runs of a study over one another: how far each is from where it should be, and its tensions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.report.marks import CABLES, LEAST_ERROR, shorten
from cdpr.report.plots.histories import Points, histories
from cdpr.report.plots.panel import Curves, Entry, Panel, calm_until

PANELS = (
    # label, quantity of `histories` (its first column), least range
    ("position error (mm)", "position_error", LEAST_ERROR),
    ("orient. error (mrad)", "orientation_error", LEAST_ERROR),
    ("largest tension (N)", "highest", 1.0),
    ("smallest tension (N)", "lowest", 1.0),
)
# So that lines upon each other show: the first broad, those upon it narrower and broken.
LOOKS: tuple[tuple[float, Any], ...] = ((3.4, "-"), (2.2, (0, (4.0, 2.0))), (1.6, (0, (1.2, 2.4))), (0.9, "-"))
BEYOND = 10.0  # times what a run that diverges came to while it was calm: more would flatten all others


def overlay(runs: Mapping[str, Run]) -> list[Panel]:
    """Return the panels of runs, at most as many as there are `LOOKS`, by their names: one line each."""
    looks: list[dict[str, Any]] = [
        {"color": colour, "linewidth": width, "linestyle": dashes}
        for colour, (width, dashes) in zip(CABLES, LOOKS, strict=False)
    ]
    legend: list[Entry] = [(shorten(who), look) for who, look in zip(runs, looks, strict=False)]
    return [
        Panel(
            label,
            tuple(
                Curves(_calm(run, name), (look["color"],), (look["linestyle"],), look["linewidth"], (who,))
                for look, (who, run) in zip(looks, runs.items(), strict=False)
            ),
            legend,
            least=least,
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
