"""Static figures for print and for pages without scripts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cdpr.log.run import Run
from cdpr.scene import Pictures
from cdpr.ui.report.figures import sketch
from cdpr.ui.report.figures.panels import stack
from cdpr.ui.report.figures.solid_region import Surface
from cdpr.ui.report.figures.svg import OnPage
from cdpr.ui.report.plots.histories import histories
from cdpr.ui.report.plots.overlay import Shade
from cdpr.ui.report.plots.panel import Panel
from cdpr.ui.report.plots.pictures import pictures_of


@np.errstate(all="ignore")  # a diverged run ends in inf and NaN
def still(run: Run, panels: Sequence[Panel] | None, title: str) -> str:
    """Return a figure of a run as SVG: its panels, or the 3D view if `panels` is None."""
    if panels is None:
        return still_scene(pictures_of(histories(run).outline), title)
    return stack(run, panels, OnPage).markup(title)


def still_scene(shown: Pictures, title: str, region: Surface | None = None) -> str:
    """Return the 3D view of a robot as SVG, in front of the surface of a workspace."""
    return sketch.draw(shown, region).markup(title)


def still_panels(panels: Sequence[Panel], span_of: tuple[float, float], shades: Sequence[Shade], title: str) -> str:
    """Return panels of data that were not simulated, over `span_of` (s), as SVG."""
    return stack(None, panels, OnPage, span_of=span_of, shades=shades).markup(title)
