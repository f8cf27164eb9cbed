"""Drawing interface of figures, independent of the backend: sheets and frames with axes.

There are two backends. `svg` writes pages a hundred times faster than matplotlib and without any package. `chart` uses
matplotlib, for editable figures and for print. Styles are dictionaries with matplotlib's names: color, linestyle,
linewidth, solid_capstyle, marker, markersize and zorder of lines; facecolor, edgecolor, linewidth and zorder of areas;
color, fontsize (pt), fontweight, ha, va and zorder of texts. Lines with the same `thing`, "kind:name", have the same
colour throughout a page.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, TypeVar

from numpy.typing import ArrayLike

from cdpr.model.robot import Array

Look = Mapping[str, Any]
Box = tuple[float, float, float, float]  # left, bottom, width and height, in, from the lower left of the sheet

LETTERS, LABEL = 8.5, 9.0  # pt, of texts and of axis labels
STEPS = (1, 2, 2.5, 5, 10)  # tick steps, times a power of ten
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class Frame(Protocol):
    """Part of a sheet with a scale. Lines and areas are clipped at its edges."""

    def scale(self, *, x: tuple[float, float] | None = None, y: tuple[float, float] | None = None) -> None:
        """Set the data range of the axes."""

    def line(self, x: ArrayLike, y: ArrayLike, look: Look, across: str = "") -> None:
        """Draw a line through points, with gaps at NaN.

        Args:
            x: coordinates.
            y: coordinates.
            look: style.
            across: axes ("", "x", "y" or "xy") whose coordinates are fractions (0 to 1) of the frame.
        """

    def area(self, rings: Sequence[Array], look: Look, across: str = "") -> None:
        """Fill the area between closed rings of points (k, 2), without repeating the first point."""

    def text(self, x: float, y: float, text: str, look: Look, across: str = "", *, halo: bool = False) -> None:
        """Draw text, which may lie outside; `halo` hides the background behind it."""

    def time_axis(self, ticks: int) -> None:
        """Set at most `ticks` ticks on the lower edge."""

    def label_time(self, label: str, below: float) -> None:
        """Write numbers at the ticks of the lower edge, and the label `below` it (in)."""

    def value_axis(self, label: str, beside: float, *, powers: bool) -> None:
        """Set the ticks of the left edge, exponents of ten if `powers`, and the label `beside` it (in)."""

    def bare(self) -> None:
        """Hide the axes."""


class Sheet(Protocol):
    """Figure with lengths in inches from its lower left."""

    def frame(self, box: Box) -> Frame:
        """Add a frame with axes."""

    def line(self, x: Sequence[float], y: Sequence[float], look: Look) -> None:
        """Draw a line that is not clipped by any frame."""

    def text(self, x: float, y: float, text: str, look: Look) -> None:
        """Draw text outside the frames."""


S = TypeVar("S", bound=Sheet)
Make = Callable[[float, float], S]  # constructor of a sheet of this width and height, in
