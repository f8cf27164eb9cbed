"""Aligned text for people: rows, tables, vectors, attitudes."""

from __future__ import annotations

import io
import math
import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from cdpr.problems import printable

WIDTH = 120  # letters in a line
BETWEEN_WORDS = re.compile(r" (?![^(]*\))")  # of a heading: not within a unit, such as (N m)
WIDEST = 100_000  # of a table: what stands in it is told whole
ROUNDING = 1e-12  # of the largest number of a vector: far more than sums of a few numbers lose


def row(name: str, value: str) -> str:
    """One line of a list of facts."""
    return f"  {name:<21}{value}"


def wrapped(text: str, indent: int) -> list[str]:
    """`text` in lines of at most WIDTH letters, all but the first indented."""
    return textwrap.wrap(text, WIDTH, subsequent_indent=" " * indent)


def table(rows: Iterable[Sequence[str]], left: int = 1, *, indent: str = "  ", ruled: bool = False) -> Iterator[str]:
    """Yield the rows as lines, the first `left` columns flush left and the others flush right.

    Nothing wraps, is cut off or coloured, wherever it goes: a table in a file is that on the screen. Letters count as
    wide as a terminal shows them. A table that is `ruled` has its first row above a rule, a word below the other.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    head, *body = ([Text("\n".join(map(printable, cell.split("\n")))) for cell in row] for row in rows)
    grid = Table(
        box=box.SIMPLE_HEAD if ruled else None,
        show_header=ruled,
        show_edge=False,
        pad_edge=False,
        padding=(0, 1) if ruled else (0, 2),
        collapse_padding=True,
        header_style="none",
    )
    for i, title in enumerate(head):
        above = Text(BETWEEN_WORDS.sub("\n", title.plain)) if ruled else title
        grid.add_column(above, justify="left" if i < left else "right", no_wrap=True, vertical="bottom")
    for cells in body if ruled else (head, *body):
        grid.add_row(*cells)
    file = io.StringIO()
    Console(file=file, width=WIDEST, color_system=None, force_jupyter=False).print(grid, no_wrap=True, crop=False)
    for line in file.getvalue().splitlines():
        yield f"{indent}{line}".rstrip()


def vector(values: Sequence[float]) -> str:
    """Six digits of each number in brackets; what is rounding beside the largest is 0."""
    return "[" + ", ".join(f"{value:.6g}" for value in unrounded(values)) + "]"


def unrounded(values: Sequence[float]) -> list[float]:
    """Return numbers of one kind with 0 for those that are rounding beside the largest."""
    least = ROUNDING * max(map(abs, values), default=0.0)
    return [0.0 if abs(value) <= least else value for value in values]


def turned(q: Sequence[float]) -> str:
    """Roll, pitch, yaw of a quaternion w, x, y, z, as the end of a sentence."""
    w, x, y, z = q
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    upright = max(abs(x), abs(y), abs(z)) < 1e-12
    return ", upright" if upright else f", roll pitch yaw {vector([roll, pitch, yaw])} rad"


def number(value: float | None) -> str:
    """`digits` as a page has it, with the sign that is as wide as a plus."""
    return digits(value).replace("-", "−")


def digits(value: float | None) -> str:
    """Four significant digits; powers of ten only for the very small and the very large. None is not finite."""
    if value is None or not math.isfinite(value):
        return "not finite"
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}"


# Of lengths and angles: below this they are told in thousandths.
WHOLE = 1.0


def unit_for(values: Iterable[float], unit: str) -> tuple[float, str]:
    """Return the factor and the unit in which people read such errors: m or mm, rad or mrad, by the largest."""
    largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    return (1.0, unit) if largest >= WHOLE else (1e3, f"m{unit}")


def condition_number(value: float | None, robot: dict[str, Any]) -> str:
    """The condition number of W and, where it depends on one, the characteristic length; None is infinite."""
    number = "infinite" if value is None else f"{value:.4g}"
    if not any(name.startswith("r") for name in robot["dof"]):
        return number
    return f"{number} (moments divided by the characteristic length, {robot['characteristic_length_m']:.4g} m)"
