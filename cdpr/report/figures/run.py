"""The time histories of a run, drawn. Each function returns a matplotlib figure; none needs pyplot."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr.log.run import Run
from cdpr.report.figures.canvas import Chart, styled
from cdpr.report.figures.panels import stack
from cdpr.report.marks import events
from cdpr.report.plots import run as plots
from cdpr.report.plots.panel import Panel


@styled
def overview(run: Run) -> Chart:
    """Draw position, errors and tensions with their limits on one page, for notebooks."""
    head = run.header
    title = " · ".join((head.scenario, head.robot, head.backend, head.controller, head.solver))
    notes = [f"{i} {event.kind} at {event.time:.4g} s" for i, event in enumerate(events(run)[:4], 1)]
    if len(run.events) > 4:
        notes.append(f"and {len(run.events) - 4} more")
    return stack(
        run,
        (plots.position_panel(run), *plots.errors(run), plots.tension_panel(run, height=1.9)),
        title,
        ";  ".join(notes),
    )


@styled
def draw(run: Run | None, panels: Sequence[Panel], span_of: tuple[float, float] = (0.0, 0.0)) -> Chart:
    """Draw panels under one another on the time axis of a run, with what happened in it, or over `span_of`, s."""
    return stack(run, panels, span_of=span_of)
