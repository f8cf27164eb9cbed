"""Figures as they stand on paper and where no script runs: by matplotlib, where it is installed."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr.errors import PluginError
from cdpr.log.run import Run
from cdpr.report.plots.overlay import Shade
from cdpr.report.plots.panel import Panel
from cdpr.view import Pictures


def still(run: Run, panels: Sequence[Panel] | None, key: str, title: str) -> str:
    """Return a figure as SVG: panels, or without any the robot in space; nothing without matplotlib."""
    if no_stills():
        return ""
    from cdpr.report.figures import sketch
    from cdpr.report.figures.canvas import inline_svg
    from cdpr.report.figures.run import draw

    return inline_svg(sketch.robot(run) if panels is None else draw(run, panels), key, title)


def still_scene(shown: Pictures, key: str, title: str) -> str:
    """Return a robot in space as SVG; nothing without matplotlib."""
    if no_stills():
        return ""
    from cdpr.report.figures import sketch
    from cdpr.report.figures.canvas import inline_svg

    return inline_svg(sketch.draw(shown), key, title)


def still_panels(
    panels: Sequence[Panel], span_of: tuple[float, float], shades: Sequence[Shade], key: str, title: str
) -> str:
    """Return panels of what was not simulated, over `span_of` (s), as SVG; nothing without matplotlib."""
    if no_stills():
        return ""
    from cdpr.report.figures.canvas import inline_svg
    from cdpr.report.figures.run import draw

    return inline_svg(draw(None, panels, span_of, shades), key, title)


def no_stills() -> str:
    """Return why there are none, or nothing."""
    try:
        import cdpr.report.figures.canvas  # noqa: F401
    except PluginError as error:
        return str(error)
    return ""
