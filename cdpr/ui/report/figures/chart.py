"""Matplotlib implementation of `surface.Sheet` and `surface.Frame`, for editable figures and for print."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cdpr.model.robot import Array
from cdpr.ui.report.figures.canvas import Axes, Chart, Line2D, MaxNLocator, Path, PathPatch
from cdpr.ui.report.figures.surface import LABEL, STEPS, SUPERSCRIPT, Box, Look


def plain(look: Look) -> dict[str, Any]:
    """Return the style without `thing`, which matplotlib does not support."""
    return {key: value for key, value in look.items() if key != "thing"}


class OnChart:
    """Sheet that draws on a matplotlib figure, `chart`."""

    def __init__(self, width: float, height: float) -> None:
        self.chart = Chart(figsize=(width, height))

    def frame(self, box: Box) -> OnAxes:
        """Add a frame with axes."""
        whole = np.tile(self.chart.get_size_inches(), 2)
        return OnAxes(self.chart.add_axes(tuple(box / whole)), box)

    def line(self, x: Sequence[float], y: Sequence[float], look: Look) -> None:
        """Draw a line that is not clipped by any frame."""
        self.chart.add_artist(Line2D(x, y, transform=self.chart.dpi_scale_trans, **plain(look)))

    def text(self, x: float, y: float, text: str, look: Look) -> None:
        """Draw text outside the frames."""
        self.chart.text(x, y, text, transform=self.chart.dpi_scale_trans, **look)


class OnAxes:
    """Frame that draws on matplotlib axes."""

    def __init__(self, axes: Axes, box: Box) -> None:
        self.axes, self._box = axes, box
        self._transforms = {
            "": axes.transData,
            "x": axes.get_yaxis_transform(),
            "y": axes.get_xaxis_transform(),
            "xy": axes.transAxes,
        }

    def scale(self, *, x: tuple[float, float] | None = None, y: tuple[float, float] | None = None) -> None:
        """Set the data range of the axes."""
        if x is not None:
            self.axes.set_xlim(*x)
        if y is not None:
            self.axes.set_ylim(*y)

    def line(self, x: ArrayLike, y: ArrayLike, look: Look, across: str = "") -> None:
        """Draw a line through points."""
        self.axes.add_artist(Line2D(x, y, transform=self._transforms[across], **plain(look)))

    def area(self, rings: Sequence[Array], look: Look, across: str = "") -> None:
        """Fill the area between closed rings."""
        points = [point for ring in rings for point in (*ring, ring[0])]
        codes = [code for ring in rings for code in (Path.MOVETO, *[Path.LINETO] * (len(ring) - 1), Path.CLOSEPOLY)]
        self.axes.add_artist(PathPatch(Path(points, codes), transform=self._transforms[across], **look))

    def text(self, x: float, y: float, text: str, look: Look, across: str = "", *, halo: bool = False) -> None:
        """Draw text, which may lie outside the frame."""
        written = self.axes.text(x, y, text, transform=self._transforms[across], **look)
        if halo:
            written.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85})

    def time_axis(self, ticks: int) -> None:
        """Set at most `ticks` ticks on the lower edge, without numbers."""
        self.axes.ticklabel_format(axis="x", scilimits=(-3, 6))
        self.axes.xaxis.set_major_locator(MaxNLocator(nbins=ticks, steps=STEPS))
        self.axes.tick_params(labelbottom=False)

    def label_time(self, label: str, below: float) -> None:
        """Write numbers at the ticks of the lower edge, and the label `below` it (in)."""
        self.axes.tick_params(labelbottom=True)
        self.axes.set_xlabel(label, fontsize=LABEL)
        self.axes.xaxis.set_label_coords(0.5, -below / self._box[3])

    def value_axis(self, label: str, beside: float, *, powers: bool) -> None:
        """Set the ticks of the left edge and the label `beside` it (in)."""
        self.axes.set_ylabel(label, fontsize=LABEL)
        self.axes.yaxis.set_label_coords(-beside / self._box[2], 0.5)
        self.axes.yaxis.set_major_locator(MaxNLocator(nbins=6, steps=STEPS, integer=powers))
        if powers:
            self.axes.yaxis.set_major_formatter(lambda power, _: "10" + f"{power:.0f}".translate(SUPERSCRIPT))
        # Align a common power of ten away from the event numbers.
        self.axes.yaxis.get_offset_text().set_horizontalalignment("right")

    def bare(self) -> None:
        """Hide the axes."""
        self.axes.set_axis_off()
