"""Formatting of aligned text: rows, tables, vectors, attitudes and numbers."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from cdpr.base.problems import printable

WIDTH = 120  # characters per line
BETWEEN_WORDS = re.compile(r" (?![^(]*\))")  # in a heading, except inside a unit such as (N m)
BETWEEN, RULE = "  ", "─"  # of the columns of a table, and below its first row
ROUNDING = 1e-12  # relative to the largest number of a vector: much more than the round-off of short sums


def row(name: str, value: str) -> str:
    """Return one line of a list of facts."""
    return f"  {name:<21}{value}"


def wrapped(text: str, indent: int) -> list[str]:
    """Return `text` as lines of at most WIDTH characters, all but the first indented."""
    return textwrap.wrap(text, WIDTH, subsequent_indent=" " * indent)


def table(rows: Iterable[Sequence[str]], left: int = 1, *, indent: str = "  ", ruled: bool = False) -> Iterator[str]:
    """Yield the rows as lines; the first `left` columns are left-aligned, the others right-aligned.

    Cells are never wrapped, truncated or coloured, so that a file shows the same as a terminal. Character widths are
    those of a terminal.

    Args:
        rows: cells; newlines split a cell.
        left: number of left-aligned columns.
        indent: prefix of each line.
        ruled: put a rule below the first row, and break its headings at each space.
    """
    cells = [[[printable(line) for line in cell.split("\n")] for cell in row] for row in rows]
    if ruled:
        cells[0] = [BETWEEN_WORDS.sub("\n", "\n".join(title)).split("\n") for title in cells[0]]
    columns = range(len(cells[0]))
    widths = [max(cell_width(line) for row in cells for cell in row[i : i + 1] for line in cell) for i in columns]
    for k, row in enumerate(cells):
        height = max(map(len, row))
        for n in range(-height, 0):  # cells end on the same line
            parts = (cell[n] if -n <= len(cell) else "" for cell in row)
            yield (indent + BETWEEN.join(_padded(part, widths[i], i < left) for i, part in enumerate(parts))).rstrip()
        if ruled and k == 0:
            yield indent + RULE * (sum(widths) + len(BETWEEN) * (len(widths) - 1))


def _padded(text: str, width: int, left: bool) -> str:
    """Return a text with this width on a terminal."""
    if left:
        return text + " " * (width - cell_width(text))
    text = text.rstrip()
    return " " * (width - cell_width(text)) + text


def cell_width(text: str) -> int:
    """Return the width of a text on a terminal, in characters."""
    if text.isascii():
        return len(text)
    from rich.cells import cell_len  # slow to import, and only required for such text

    return cell_len(text)


def vector(values: Sequence[float]) -> str:
    """Return a vector with six digits per number; round-off is written as 0."""
    return "[" + ", ".join(f"{value:.6g}" for value in unrounded(values)) + "]"


def unrounded(values: Sequence[float]) -> list[float]:
    """Return the numbers with 0 for those that are round-off relative to the largest."""
    least = ROUNDING * max(map(abs, values), default=0.0)
    return [0.0 if abs(value) <= least else value for value in values]


def turned(q: Sequence[float]) -> str:
    """Return roll, pitch, yaw of a quaternion (w, x, y, z) as the end of a sentence."""
    w, x, y, z = q
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    upright = max(abs(x), abs(y), abs(z)) < 1e-12
    return ", upright" if upright else f", roll pitch yaw {vector([roll, pitch, yaw])} rad"


def number(value: float | None) -> str:
    """Return `digits` with a typographic minus sign, for pages."""
    return digits(value).replace("-", "−")


def digits(value: float | None) -> str:
    """Return a number with four significant digits; "not finite" for None, inf and NaN."""
    if value is None or not math.isfinite(value):
        return "not finite"
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}"


# Lengths and angles below this are written in thousandths.
WHOLE = 1.0


def unit_for(values: Iterable[float], unit: str) -> tuple[float, str]:
    """Return the factor and unit for displaying values: m or mm, rad or mrad, depending on the largest."""
    largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    return (1.0, unit) if largest >= WHOLE else (1e3, f"m{unit}")


def condition_number(value: float | None, robot: dict[str, Any]) -> str:
    """Return the condition number of W (None is infinite) and, if it matters, the characteristic length."""
    number = "infinite" if value is None else f"{value:.4g}"
    if not any(name.startswith("r") for name in robot["dof"]):
        return number
    return f"{number} (moments divided by the characteristic length, {robot['characteristic_length_m']:.4g} m)"
