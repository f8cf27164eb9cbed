"""What figures are drawn on, whatever that is: a sheet, and frames on it that have axes.

There are two: `svg` writes pages in a hundredth of the time that matplotlib takes, and needs no package for it; `chart`
is matplotlib's, for figures that readers change, and for print. Looks are dictionaries of matplotlib's names: color,
linestyle, linewidth, solid_capstyle, marker, markersize and zorder of lines; facecolor, edgecolor, linewidth and zorder
of areas; color, fontsize (pt), fontweight, ha, va, zorder of texts. The `thing` of a
line, "kind:name", has one colour throughout a page.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, TypeVar

from numpy.typing import ArrayLike

from cdpr.model.robot import Array

Look = Mapping[str, Any]
Box = tuple[float, float, float, float]  # left, lower edge, width and height, in, from the lower left of the sheet

LETTERS, LABEL = 8.5, 9.0  # pt, of texts and of what an axis says that it shows
STEPS = (1, 2, 2.5, 5, 10)  # between ticks, times a power of ten
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class Frame(Protocol):
    """A part of a sheet with a scale. Lines and areas end at its edges."""

    def scale(self, *, x: tuple[float, float] | None = None, y: tuple[float, float] | None = None) -> None:
        """What the edges stand for."""

    def line(self, x: ArrayLike, y: ArrayLike, look: Look, across: str = "") -> None:
        """A line through points, with gaps at NaN; `across` names what is a share (0 to 1) of the frame: "x" or "y"."""

    def area(self, rings: Sequence[Array], look: Look, across: str = "") -> None:
        """An area between closed rings of points (k, 2), the first of which is not said again."""

    def text(self, x: float, y: float, text: str, look: Look, across: str = "", *, halo: bool = False) -> None:
        """Text, which may stand outside; `across` also "xy", a `halo` keeps away what is behind."""

    def time_axis(self, ticks: int) -> None:
        """At most so many ticks along the lower edge."""

    def label_time(self, label: str, below: float) -> None:
        """Say at the lower edge what its ticks are, and under it, `below` (in), what the axis shows."""

    def value_axis(self, label: str, beside: float, *, powers: bool) -> None:
        """Ticks at the left edge, with `powers` those of ten; `beside` it, in, what the axis shows."""

    def bare(self) -> None:
        """No axes."""


class Sheet(Protocol):
    """A figure; lengths are in inches from its lower left."""

    def frame(self, box: Box) -> Frame:
        """A part with axes."""

    def line(self, x: Sequence[float], y: Sequence[float], look: Look) -> None:
        """A line that no frame cuts."""

    def text(self, x: float, y: float, text: str, look: Look) -> None:
        """Text outside frames."""


S = TypeVar("S", bound=Sheet)
Make = Callable[[float, float], S]  # makes a sheet of this width and height, in
