"""SVG implementation of `surface.Sheet` and `surface.Frame`, for pages."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape
from math import floor, isfinite, log10
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.model.robot import Array
from cdpr.scene import colours
from cdpr.ui.report.figures.surface import LABEL, LETTERS, STEPS, SUPERSCRIPT, Box, Look
from cdpr.ui.report.style import INK, PALE

PT = 72.0  # per inch
GRID: Look = {"color": colours.GRID.light, "linewidth": 0.6, "zorder": 0.6}
SPINE: Look = {"color": PALE, "linewidth": 0.7, "zorder": 2.5}
PAD = 3.0  # pt, from an axis to its tick numbers
HALO = 2.0  # pt, width of the background behind text
LARGEST = 1.7  # px per pt: limits the size on wide pages, so that letters do not exceed the page's text
VALUES = 6  # largest number of tick intervals of the vertical axis
# Exponents of ten that are written out; other numbers share a power of ten beside the axis.
TIME, VALUE = range(-2, 6), range(-4, 5)

# Marker shapes of unit size, relative to their position, as SVG paths; open shapes are drawn as lines.
MARKS = {
    "s": "m-.45-.45h.9v.9h-.9z",
    "D": "m0-.6l.6.6l-.6.6l-.6-.6z",
    "^": "m0-.5l.5 1h-1z",
    "v": "m0 .5l.5-1h-1z",
    "P": "m-.17-.5h.34v.33h.33v.34h-.33v.33h-.34v-.33h-.33v-.34h.33z",
    "X": "m-.5-.25l.25-.25l.25.25l.25-.25l.25.25l-.25.25l.25.25l-.25.25l-.25-.25l-.25.25l-.25-.25l.25-.25z",
    "*": "m0-.6l.14.41h.43l-.34.26l.12.41l-.35-.24l-.35.24l.12-.41l-.34-.26h.43z",
}
NUMBER = re.compile(r"-?\d*\.?\d+")
CROSS, STROKE = "m-.5-.5l1 1m0-1l-1 1", 1.2  # pt

DASHES = {"--": (4.0, 2.0), ":": (1.0, 1.65)}  # in line widths
ANCHORS = {"left": "start", "center": "middle", "right": "end"}
LOWER = {
    "top": 0.76,
    "center": 0.36,
    "baseline": 0.0,
    "bottom": -0.24,
}  # baselines, in font sizes below the position

FAR = 1e5  # pt: points beyond lie outside every frame
NEAR = 0.05  # pt: points this close to the line between their neighbours are left out
ROUNDS = 4  # passes over the remaining points


class OnPage:
    """Sheet that is written as an `<svg>` element."""

    def __init__(self, width: float, height: float) -> None:
        self._width, self._height = PT * width, PT * height
        self._frames: list[_Frame] = []
        self._parts: list[str] = []

    def frame(self, box: Box) -> _Frame:
        """Add a frame with axes."""
        x, y, width, height = (PT * length for length in box)
        self._frames.append(_Frame(x, self._height - y - height, width, height))
        return self._frames[-1]

    def line(self, x: Sequence[float], y: Sequence[float], look: Look) -> None:
        """Draw a line that is not clipped by any frame."""
        self._parts.append(_line(np.stack([PT * np.asarray(x), self._height - PT * np.asarray(y)], axis=1), look))

    def text(self, x: float, y: float, text: str, look: Look) -> None:
        """Draw text outside the frames."""
        self._parts.append(_text(PT * x, self._height - PT * y, text, look))

    def markup(self, label: str, *, both: bool = True) -> str:
        """Return the `<svg>` element.

        Args:
            label: description for screen readers.
            both: use CSS variables, which follow the page's light or dark mode; otherwise use the light colours.
        """
        parts = [*(frame.markup() for frame in self._frames), *self._parts]
        text = (
            f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{escape(label)}" '
            f'viewBox="0 0 {self._width:.4g} {self._height:.4g}" width="{self._width:.4g}" height="{self._height:.4g}" '
            f'style="max-width: {LARGEST * self._width:.4g}px" '
            'font-family="DejaVu Sans, Verdana, sans-serif" fill="none" stroke-linejoin="round">'
            + "\n".join(part for part in parts if part)
            + "</svg>"
        )
        return colours.on_either_ground(text) if both else text


class _Frame:
    """Frame of an SVG sheet; pt from the upper left."""

    def __init__(self, left: float, top: float, width: float, height: float) -> None:
        self._left, self._top, self._size = left, top, np.array((width, height))
        self._low, self._high = np.zeros(2), np.ones(2)
        self._parts: list[tuple[float, Any]] = []  # clipped at the edges, with their zorder
        self._texts: list[Any] = []

    def scale(self, *, x: tuple[float, float] | None = None, y: tuple[float, float] | None = None) -> None:
        for k, span in enumerate((x, y)):
            if span is not None:
                self._low[k], self._high[k] = span

    def line(self, x: ArrayLike, y: ArrayLike, look: Look, across: str = "") -> None:
        points = np.stack([np.asarray(x, dtype=float), np.asarray(y, dtype=float)], axis=-1)
        self._parts.append((look.get("zorder", 2.0), lambda: _line(self._placed(points, across), look)))

    def area(self, rings: Sequence[Array], look: Look, across: str = "") -> None:
        self._parts.append((look.get("zorder", 1.0), lambda: _area([self._placed(r, across) for r in rings], look)))

    def text(self, x: float, y: float, text: str, look: Look, across: str = "", *, halo: bool = False) -> None:
        def write() -> str:
            px, py = self._placed(np.array((x, y)), across)
            return _text(px + self._left, py + self._top, text, look, halo=halo)

        self._texts.append(write)

    def time_axis(self, ticks: int) -> None:
        self._grid(0, ticks_within(self._low[0], self._high[0], ticks))
        self._ticks = ticks

    def label_time(self, label: str, below: float) -> None:
        width, height = self._size
        known = ticks_within(self._low[0], self._high[0], self._ticks)
        names, power = numbers(known, TIME)
        self._name(0, known, names)
        if power:
            self._write(width, height + PAD + 1.2 * LETTERS, power, "right", "top")
        self._write(width / 2, height + PT * below, label, "center", "top", LABEL)

    def value_axis(self, label: str, beside: float, *, powers: bool) -> None:
        known = ticks_within(self._low[1], self._high[1], VALUES, whole=powers)
        if powers:
            names, power = ["10" + f"{at:.0f}".translate(SUPERSCRIPT) for at in known], ""
        else:
            names, power = numbers(known, VALUE)
        self._grid(1, known)
        self._name(1, known, names)
        if power:
            self._write(-PAD, -PAD, power, "right", "bottom")
        x, y = self._left - PT * beside + LABEL * LOWER["bottom"], self._top + self._size[1] / 2
        self._texts.append(lambda: _text(x, y, label, {"ha": "center", "fontsize": LABEL}, _turned(x, y, 90)))

    def axis(self, which: int, ticks: Sequence[float], names: Sequence[str] = (), *, turned: float = 0.0) -> None:
        """Draw ticks, with names if any, on the lower (0) or left edge (1); `turned` rotates names (degrees)."""
        self._grid(which, ticks)
        self._name(which, ticks, names, turned)

    def _grid(self, which: int, ticks: Sequence[float]) -> None:
        for at in ticks:
            x, y = ((0.0, 1.0), (at, at)) if which else ((at, at), (0.0, 1.0))
            self.line(x, y, GRID, "yx"[which])
        x, y = ((0.0, 0.0), (0.0, 1.0)) if which else ((0.0, 1.0), (0.0, 0.0))
        self.line(x, y, SPINE, "xy")

    def _name(self, which: int, ticks: Sequence[float], names: Sequence[str], turned: float = 0.0) -> None:
        for at, name in zip(ticks, names, strict=bool(names)):
            x, y = self._placed(np.array((at, at)), "yx"[which])
            if which:
                self._write(-PAD, y, name, "right", "center")
            else:
                below = self._size[1] + PAD
                self._write(x, below, name, "right" if turned else "center", "top", turned=turned)

    def bare(self) -> None:
        """Do nothing: axes are drawn only on request."""

    def markup(self) -> str:
        """Return the frame's content as SVG."""
        width, height = self._size
        inside = "\n".join(draw() for _, draw in sorted(self._parts, key=lambda part: part[0]))
        texts = "\n".join(write() for write in self._texts)
        place = f'x="{self._left:.5g}" y="{self._top:.5g}" width="{width:.5g}" height="{height:.5g}"'
        return f'<svg {place} overflow="hidden">\n{inside}\n</svg>\n{texts}'

    def _placed(self, points: Array, across: str) -> Array:
        """Return the coordinates of points (..., 2), pt from the frame's upper left."""
        shares = points.astype(float)
        for k, axis in enumerate("xy"):
            if axis not in across:
                shares[..., k] = (points[..., k] / 2 - self._low[k] / 2) / (self._high[k] / 2 - self._low[k] / 2)
        shares[..., 1] = 1.0 - shares[..., 1]
        placed = self._size * shares
        return np.where(np.isfinite(placed), np.clip(placed, -FAR, FAR), np.nan)

    def _write(
        self, x: float, y: float, text: str, ha: str, va: str, size: float = LETTERS, *, turned: float = 0.0
    ) -> None:
        at = (x + self._left, y + self._top)
        more = _turned(*at, turned) if turned else ""
        self._texts.append(lambda: _text(*at, text, {"ha": ha, "va": va, "fontsize": size}, more))


def ticks_within(low: float, high: float, most: int, *, whole: bool = False) -> list[float]:
    """Return round numbers from `low` to `high` with at most `most` intervals; none if the range is empty."""
    raw = (high - low) / most
    if not (isfinite(raw) and raw > 0.0):
        return []
    power = 10.0 ** floor(log10(raw))
    step = next(each * power for each in (*STEPS, 20) if each * power >= raw * (1.0 - 1e-10))
    if whole:
        step = max(1.0, float(floor(step + 0.5)))
    first, last = low / step, high / step
    if not (step > 0.0 and isfinite(first) and isfinite(last)):
        return []
    # At large magnitudes, rounding moves ticks beyond the ends or makes them equal.
    found = dict.fromkeys(k * step for k in range(-floor(-first + 1e-9), floor(last + 1e-9) + 1))
    return [tick for tick in found if low - 1e-9 * step <= tick <= high + 1e-9 * step]


def numbers(ticks: Sequence[float], plain: range) -> tuple[list[str], str]:
    """Return the ticks as text, and their common power of ten, if any."""
    largest = max(map(abs, ticks), default=0.0)
    power = floor(log10(largest) + 1e-9) if largest > 0.0 else 0
    shift = 0 if power in plain else power
    # In two steps: a power of ten below 1e-308 underflows.
    scaled = [tick * 10.0 ** (-shift // 2) * 10.0 ** (-shift - -shift // 2) for tick in ticks]
    digits = next((d for d in range(12) if all(abs(each - round(each, d)) < 1e-6 * 10.0**-d for each in scaled)), 12)
    names = [f"{round(each, digits) + 0.0:.{digits}f}".replace("-", "−") for each in scaled]
    return names, f"×10{str(shift).translate(SUPERSCRIPT)}" if shift else ""


def _line(points: Array, look: Look) -> str:
    colour, width = look.get("color", INK), look.get("linewidth", 1.2)
    known: NDArray[np.bool_] = np.isfinite(points[:, 0]) & np.isfinite(points[:, 1])
    marker, style = look.get("marker"), look.get("linestyle", "-")
    parts = []
    if style != "":
        d = "".join(_strokes(points, known))
        cap = "butt" if style != "-" else look.get("solid_capstyle", "round")
        pattern = DASHES.get(style) if isinstance(style, str) else style[1]
        dashes = f"; stroke-dasharray: {' '.join(f'{width * part:.3g}' for part in pattern)}" if pattern else ""
        ink = f"stroke: {colour}; stroke-width: {width:.3g}; stroke-linecap: {cap}{dashes}"
        of = f' data-thing="{escape(look["thing"])}"' if "thing" in look else ""
        parts += [f'<path d="{d}" style="{ink}"{of}/>'] * bool(d)
    if marker and known.any():
        parts.append(_marks(points[known], marker, look["markersize"], colour))
    return "\n".join(parts)


def _marks(points: Array, marker: str, size: float, colour: str) -> str:
    """Return markers of this size (pt) at the points."""
    if marker == "o":
        dots = "".join(f'<circle cx="{x:.5g}" cy="{y:.5g}" r="{size / 2:.3g}"/>' for x, y in points)
        return f'<g style="fill: {colour}">{dots}</g>'
    shape = MARKS.get(marker, CROSS)
    shape = NUMBER.sub(lambda found: f"{size * float(found[0]):+.3g}", shape)
    ink = f"fill: {colour}" if marker in MARKS else f"stroke: {colour}; stroke-width: {STROKE}"
    return f'<path d="{"".join(f"M{x:.5g} {y:.5g}{shape}" for x, y in points)}" style="{ink}"/>'


def _strokes(points: Array, known: NDArray[np.bool_]) -> list[str]:
    """Return the paths of lines through points, with gaps where they are unknown."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(np.int8)))
    strokes = []
    for first, end in edges.reshape(-1, 2):
        values = [f"{value:.5g}" for value in _thinned(points[first:end]).ravel().tolist()]
        pairs = [f"{a} {b}" for a, b in zip(values[::2], values[1::2], strict=True)]
        strokes.append(f"M{'L'.join(pairs)}" if len(pairs) > 1 else f"M{pairs[0]}h0")
    return strokes


def _thinned(points: Array) -> Array:
    """Leave out points that lie on the line between their neighbours."""
    for _ in range(ROUNDS):
        before, here, after = points[:-2:2], points[1:-1:2], points[2::2]
        if not len(here):
            break
        way, off = after - before, here - before
        length = np.maximum(np.hypot(*way.T), 1e-12)
        along = (off * way).sum(axis=1) / length
        aside = np.abs(off[:, 0] * way[:, 1] - off[:, 1] * way[:, 0]) / length
        kept = np.ones(len(points), dtype=bool)
        kept[1:-1:2] = (aside > NEAR) | (along < -NEAR) | (along > length + NEAR)
        if kept.all():
            break
        points = points[kept]
    return points


def _area(rings: Sequence[Array], look: Look) -> str:
    d = "".join("M" + "L".join(f"{x:.5g} {y:.5g}" for x, y in ring) + "z" for ring in rings)
    edge, face = look.get("edgecolor", "none"), look.get("facecolor", "none")
    ink = f"stroke: {edge}; stroke-width: {look['linewidth']:.3g}" if look.get("linewidth") else "stroke: none"
    return f'<path d="{d}" style="fill: {face}; {ink}"/>' if d else ""


def _turned(x: float, y: float, degrees: float) -> str:
    """Return the SVG attribute that rotates text counter-clockwise about its position."""
    return f' transform="rotate(-{degrees:g} {x:.5g} {y:.5g})"'


def _text(x: float, y: float, text: str, look: Look, more: str = "", *, halo: bool = False) -> str:
    size = look.get("fontsize", LETTERS)
    y += size * LOWER[look.get("va", "baseline")]
    bold = "; font-weight: bold" * (look.get("fontweight") == "bold")
    behind = f"; paint-order: stroke; stroke: {colours.GROUND.light}; stroke-width: {HALO:g}" * halo
    style = f"fill: {look.get('color', INK)}; font-size: {size:g}px{bold}{behind}"
    anchor = ANCHORS[look.get("ha", "left")]
    return f'<text x="{x:.5g}" y="{y:.5g}" text-anchor="{anchor}" style="{style}"{more}>{escape(text)}</text>'
