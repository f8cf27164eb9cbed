"""The one door to matplotlib: no pyplot, one fixed style, and the same SVG for the same run."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from html import escape
from io import StringIO
from typing import Any, TypeVar, cast

import numpy as np

from cdpr.errors import PluginError
from cdpr.report.marks import DRAWN_BY, INK, PALE
from cdpr.view import colours

try:
    import matplotlib as mpl
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure
    from matplotlib.font_manager import FontProperties
    from matplotlib.lines import Line2D
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path
    from matplotlib.textpath import TextToPath
    from matplotlib.ticker import MaxNLocator
except ImportError as error:
    raise PluginError(f"plots and reports need matplotlib ({error}): pip install 'cdpr[plot]'") from error

__all__ = [
    "Axes",
    "Chart",
    "Line2D",
    "MaxNLocator",
    "Path",
    "PathPatch",
    "inline_svg",
    "styled",
    "text_width",
]


# All that the reader's own matplotlibrc could change in these figures.
STYLE: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],
    "font.size": 8.5,
    "text.color": INK,
    "text.usetex": False,
    "text.parse_math": False,  # a name may hold a dollar sign
    "axes.unicode_minus": True,
    "axes.facecolor": "white",
    "axes.edgecolor": PALE,
    "axes.linewidth": 0.7,
    "axes.labelcolor": INK,
    "axes.labelsize": 9.0,
    "axes.labelweight": "normal",
    "axes.labelpad": 4.0,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.grid.axis": "both",
    "axes.grid.which": "major",
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-5, 5),
    "axes.formatter.use_mathtext": False,
    "axes.formatter.use_locale": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": colours.GRID.light,
    "grid.linewidth": 0.6,
    "grid.linestyle": "-",
    "grid.alpha": 1.0,
    "xtick.bottom": False,
    "ytick.left": False,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "xtick.major.pad": 3.0,
    "ytick.major.pad": 3.0,
    "figure.facecolor": "white",
    "figure.autolayout": False,
    "figure.constrained_layout.use": False,
    "lines.linewidth": 1.2,
    "lines.dashed_pattern": (4.0, 2.0),
    "lines.scale_dashes": True,
    "lines.solid_joinstyle": "round",
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
    "path.sketch": None,
    "path.effects": [],
    "savefig.bbox": None,
    "savefig.facecolor": "auto",
    "svg.fonttype": "none",  # text stays text: small, searchable, and cheap to write
    "svg.image_inline": True,
}


# Of files for print: fonts as TrueType, which publishers take, and letters as outlines where no font can be brought.
PRINT: dict[str, Any] = {
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "svg.fonttype": "path",
    "svg.hashsalt": "cdpr",
    "savefig.dpi": 300,
}
# What files say of themselves: who drew them, and no date, so that the same figure has the same bytes.
SAID: dict[str, dict[str, str | None]] = {
    "svg": {"Creator": DRAWN_BY, "Date": None},
    "pdf": {"Creator": DRAWN_BY, "CreationDate": None},
    "png": {"Software": DRAWN_BY},
}


class Chart(Figure):
    """A matplotlib figure that notebooks can show although pyplot is not loaded."""

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save as matplotlib does, fit for print: fonts embedded as TrueType in PDF and PS, as outlines in SVG.

        The same figure gives the same bytes as SVG, PDF and PNG.
        """
        named = os.path.splitext(fname)[1][1:] if isinstance(fname, str | os.PathLike) else ""
        kind = str(options.get("format") or named).lower()
        metadata = {**SAID.get(kind, {}), **(options.pop("metadata", None) or {})}
        with mpl.rc_context({**STYLE, **PRINT}), _any_letter():
            super().savefig(fname, metadata=metadata, **options)

    def _repr_svg_(self) -> str:
        return inline_svg(self, "notebook", "Time histories of a run", both=False)


Draw = TypeVar("Draw", bound=Callable[..., Chart])


def styled(draw: Draw) -> Draw:
    """Let a function draw in our style, whatever the reader's is, and bear values that are not finite."""

    @wraps(draw)
    def within(*args: Any, **options: Any) -> Chart:
        with mpl.rc_context(STYLE), np.errstate(all="ignore"):
            return draw(*args, **options)

    return cast(Draw, within)


def inline_svg(figure: Figure, key: str, label: str, *, both: bool = True) -> str:
    """Return `figure` as an `<svg>` element for HTML.

    `key` keeps its ids apart from those of other figures on the page; `label` is what a screen reader says. With
    `both`, our colours are what the page says that they are on its ground; without, those of light ground, which
    programs other than browsers understand.
    """
    buffer = StringIO()
    with mpl.rc_context({**STYLE, "svg.hashsalt": f"cdpr {key}"}), _any_letter():
        nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        FigureCanvasSVG(figure).print_figure(buffer, format="svg", dpi=72, metadata=nothing)
    text = buffer.getvalue()
    width, height = (f"{72 * inches:.4g}" for inches in figure.get_size_inches())
    root = (
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" role="img" '
        f'aria-label="{escape(label)}" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
    )
    text = root + text[text.index(">", text.index("<svg ")) + 1 :]
    # Ids such as line2d_7 are never referred to, nor unique on a page; indents are a tenth of the file.
    text = re.sub(r' id="[a-z0-9.]+_\d+"', "", text)
    text = re.sub(r"\n +", "\n", text)
    text = re.sub(r' d="[^"]*"', _two_decimals, text)
    return colours.on_either_ground(text) if both else text


def text_width(text: str, size: float) -> float:
    """Width of a line of text in letters of `size` pt, in."""
    with mpl.rc_context(STYLE), _any_letter():
        width, _, _ = TextToPath().get_text_width_height_descent(text, FontProperties(size=size), ismath=False)
    return float(width) / 72.0


@contextmanager
def _any_letter() -> Iterator[None]:
    """Letters that matplotlib's font lacks are no reason to warn: in a browser text stays text."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


def _two_decimals(data: re.Match[str]) -> str:
    """Cut coordinates to 0.01 pt, which nobody can see and which halves the file."""
    return re.sub(r"(?<=\.\d\d)\d+", "", data[0])
