"""Interface to matplotlib: no pyplot, one fixed style, and identical SVG for equal runs."""

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

from cdpr.base.errors import MissingPackageError
from cdpr.scene import colours
from cdpr.ui.report.style import DRAWN_BY, INK, PALE

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
    raise MissingPackageError(f"plots and reports need matplotlib ({error}): pip install 'cdpr[plot]'") from error

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


# All settings that the user's matplotlibrc could change in these figures.
STYLE: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],
    "font.size": 8.5,
    "text.color": INK,
    "text.usetex": False,
    "text.parse_math": False,  # names may contain dollar signs
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
    "svg.fonttype": "none",  # text stays text: small, searchable and fast to write
    "svg.image_inline": True,
}


# Settings of saved files: TrueType fonts, as publishers require, and outlines in SVG, which cannot embed fonts.
PRINT: dict[str, Any] = {
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "svg.fonttype": "path",
    "svg.hashsalt": "cdpr",
    "savefig.dpi": 300,
}
# Metadata of saved files. Dates are omitted, so that equal figures give equal bytes.
SAID: dict[str, dict[str, str | None]] = {
    "svg": {"Creator": DRAWN_BY, "Date": None},
    "pdf": {"Creator": DRAWN_BY, "CreationDate": None},
    "png": {"Software": DRAWN_BY},
}


class Chart(Figure):
    """Matplotlib figure that notebooks can display without pyplot."""

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save the figure for print: fonts are embedded as TrueType in PDF and PS, and converted to outlines in SVG.

        Equal figures give equal bytes as SVG, PDF and PNG.

        Args:
            fname: as in matplotlib.
            options: as in matplotlib; `metadata` is merged with the default metadata.
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
    """Decorate a drawing function: use the fixed style and ignore warnings about non-finite values."""

    @wraps(draw)
    def within(*args: Any, **options: Any) -> Chart:
        with mpl.rc_context(STYLE), np.errstate(all="ignore"):
            return draw(*args, **options)

    return cast(Draw, within)


def inline_svg(figure: Figure, key: str, label: str, *, both: bool = True) -> str:
    """Return `figure` as an `<svg>` element for HTML.

    Args:
        figure: figure to convert.
        key: prefix that makes the ids unique on the page.
        label: description for screen readers.
        both: use CSS variables, which follow the page's light or dark mode; otherwise use the light colours, which also
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
    # Nothing refers to ids such as line2d_7, and they are not unique on a page. Indentation is a tenth of the file.
    text = re.sub(r' id="[a-z0-9.]+_\d+"', "", text)
    text = re.sub(r"\n +", "\n", text)
    text = re.sub(r' d="[^"]*"', _two_decimals, text)
    return colours.on_either_ground(text) if both else text


def text_width(text: str, size: float) -> float:
    """Return the width of a line of text at font size `size` (pt), in."""
    with mpl.rc_context(STYLE), _any_letter():
        width, _, _ = TextToPath().get_text_width_height_descent(text, FontProperties(size=size), ismath=False)
    return float(width) / 72.0


@contextmanager
def _any_letter() -> Iterator[None]:
    """Suppress warnings about glyphs that matplotlib's font lacks: browsers render the text with their own fonts."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


def _two_decimals(data: re.Match[str]) -> str:
    """Truncate coordinates to 0.01 pt, which is invisible and halves the file."""
    return re.sub(r"(?<=\.\d\d)\d+", "", data[0])
