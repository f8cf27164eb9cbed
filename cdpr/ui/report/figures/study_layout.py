"""Assignment of a study's axes to the x axis, lines and panels of a figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from cdpr.analysis.study.plan import Grid
from cdpr.analysis.study.points import Label, Point
from cdpr.analysis.study.spread import WITHOUT_FIGURES, seed_axis
from cdpr.ui.report.style import CABLES
from cdpr.ui.report.text.study import Figure, Record, label_text, value

MOST_LINES = len(CABLES)  # one colour each
MOST_PANELS = 12
MOST_PLACES = 400  # per curve: more are indistinguishable
LEAST_PLACES = 8  # per curve, even if many curves share a page


@dataclass(frozen=True)
class Layout:
    """Axes of one part of a study in a figure; runs that differ only in other axes coincide.

    If they differ only in their seeds, `seeds` is True.
    """

    x: str
    numeric: bool  # x is a numeric scale, not categorical
    scattered: bool  # x is random: points are not connected
    line: str | None
    panels: tuple[str, ...]
    seeds: bool = False


@dataclass(frozen=True)
class Curve:
    """Curve in one panel: the values at each x, and the x of cases without a value."""

    label: Label
    x: tuple[Label, ...]
    values: tuple[tuple[float, ...], ...]
    lost: tuple[Label, ...]


def layouts(grid: Grid) -> list[Layout]:
    """Return the layouts of one part of a study: one per numeric axis along x; none for a single case.

    Seeds are along x only if nothing else varies: they are samples, not quantities.
    """
    groups = sorted((column for column in grid.columns if len(column) > 1), key=len, reverse=True)
    if not groups:
        return []
    seeds = seed_axis(grid)
    others = [group for group in groups if seeds not in group[0].labels]
    pooled = len(others) not in (0, len(groups))
    groups = others if pooled else groups
    drawn = {leaf.label for axis in grid.axes for leaf in axis.leaves() if leaf.random is not None}
    along = next((group for group in groups if _numeric(group)), groups[0])
    rest = [group for group in groups if group is not along]
    line = next((group for group in rest if len(group) <= MOST_LINES), None)
    rest = [group for group in rest if group is not line]
    panels: list[str] = []
    count = 1
    for group in sorted(rest, key=len):
        if count * len(group) <= MOST_PANELS:
            count *= len(group)
            panels.append(_first(group))
    pooled = pooled and len(panels) == len(rest)
    order = list(dict.fromkeys(leaf.label for axis in grid.axes for leaf in axis.leaves()))
    panels.sort(key=order.index)
    numeric = _numeric(along)
    return [
        Layout(x, bool(numeric), x in drawn, None if line is None else _first(line), tuple(panels), pooled)
        for x in numeric or [_first(along)]
    ]


def panels(layout: Layout, records: Sequence[Record], figure: Figure) -> dict[str, list[Curve]]:
    """Return the curves of each panel, by title."""
    out: dict[str, list[Curve]] = {}
    for place in dict.fromkeys(tuple(record[axis] for axis in layout.panels) for record in records):
        inside = [record for record in records if tuple(record[axis] for axis in layout.panels) == place]
        title = ", ".join(
            label_text(label) if isinstance(label, str) else f"{axis.rpartition('.')[2]} {label_text(label)}"
            for axis, label in zip(layout.panels, place, strict=True)
        )
        labels = dict.fromkeys(None if layout.line is None else record[layout.line] for record in inside)
        out[title] = [_curve(layout, inside, label, figure) for label in labels]
    return out


def _curve(layout: Layout, records: Sequence[Record], label: Label, figure: Figure) -> Curve:
    found: dict[Label, list[float]] = {}
    lost: dict[Label, None] = {}
    for record in records:
        if layout.line is not None and record[layout.line] != label:
            continue
        at, cell = record[layout.x], value(record, figure)
        if record["status"] in WITHOUT_FIGURES:
            lost[at] = None
        elif cell is not None:
            found.setdefault(at, []).append(cell)
    if layout.numeric:
        found = dict(sorted(found.items(), key=lambda item: float(item[0] or 0.0)))
    return Curve(label, tuple(found), tuple(map(tuple, found.values())), tuple(lost))


def thinned(curve: Curve, most: int = MOST_PLACES) -> Curve:
    """Return a curve of at most about `most` points: the minimum and maximum of each section of x."""
    lost = curve.lost[:: -(-len(curve.lost) // most) or 1]
    if len(curve.x) <= most:
        return replace(curve, lost=lost)
    kept: set[int] = set()
    size = -(-2 * len(curve.x) // most)
    for first in range(0, len(curve.x), size):
        part = range(first, min(first + size, len(curve.x)))
        kept |= {min(part, key=lambda k: min(curve.values[k])), max(part, key=lambda k: max(curve.values[k]))}
    order = sorted(kept)
    return replace(curve, x=tuple(curve.x[k] for k in order), values=tuple(curve.values[k] for k in order), lost=lost)


def _numeric(group: Sequence[Point]) -> list[str]:
    """Return the axes of a group along which all values are numbers."""
    return [
        axis
        for axis in group[0].labels
        if all(isinstance(p.labels[axis], int | float) and not isinstance(p.labels[axis], bool) for p in group)
    ]


def _first(group: Sequence[Point]) -> str:
    return next(iter(group[0].labels))
