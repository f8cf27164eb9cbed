"""Time histories of a run as matplotlib figures, without pyplot."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr.log.run import Run
from cdpr.ui.report.figures.canvas import Chart, styled
from cdpr.ui.report.figures.chart import OnChart
from cdpr.ui.report.figures.panels import stack
from cdpr.ui.report.figures.print import inches, on_paper
from cdpr.ui.report.plots.panel import Panel
from cdpr.ui.report.plots.pick import pick
from cdpr.ui.report.style import events


@styled
def plot(
    run: Run, names: Sequence[str], cables: str | int | Sequence[str | int] | None, width: str | float | None
) -> Chart:
    """Draw panels of a run; see `Run.plot`."""
    across = None if width is None else inches(width)
    chosen = pick(run, names or ("position", "position_error", "orientation_error", "tension"), cables)
    if across is not None:
        return on_paper(run, chosen, across)
    return charted(run, chosen, *(() if names else _heading(run)))


def _heading(run: Run) -> tuple[str, str]:
    """Return the title (names of the scenario and its parts) and the list of the first events."""
    head = run.header
    title = " · ".join((head.scenario, head.robot, head.backend, head.controller, head.solver))
    notes = [f"{i} {event.kind} at {event.time:.4g} s" for i, event in enumerate(events(run)[:4], 1)]
    if len(run.events) > 4:
        notes.append(f"and {len(run.events) - 4} more")
    return title, ";  ".join(notes)


@styled
def charted(run: Run, panels: Sequence[Panel], title: str = "", foot: str = "") -> Chart:
    """Draw panels below one another on the time axis of a run, with its events and shaded intervals."""
    return stack(run, panels, OnChart, title, foot).chart
