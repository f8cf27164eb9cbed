"""External wrenches and tensions that replace the output of controller or solver, and their file format.

The file is a text table: `t` and `until` (s), `fx` to `mz` (N, N m), and a column per cable (N), by name. A row
contains a wrench or tensions from the sample at `t` up to, but excluding, that at `until`; other cells are empty.
Numbers are written with full precision.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from cdpr.base.files import MAX_FAULTS, ContentError, text_of
from cdpr.base.problems import shown
from cdpr.model.robot import Array

MAX_BYTES = 512 * 1024 * 1024  # over an hour of tensions that change a thousand times a second
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")
TIMES = ("t", "until")

Kind = Literal["wrench", "tension"]


@dataclass(frozen=True, eq=False)
class Span:
    """Wrench (6,) or tensions (m,) during a time interval, s."""

    kind: Kind
    start: float
    end: float
    values: Array


def overlay(spans: Iterable[Span], later: Sequence[Span]) -> list[Span]:
    """Return all spans in order of time; `later` spans, which do not overlap each other, replace others."""
    later = sorted(later, key=lambda span: span.start)
    ends = [span.end for span in later]
    left = []
    for old in spans:
        start = old.start
        for new in later[bisect_right(ends, old.start) : bisect_left(ends, old.end) + 1]:
            if start < new.start and old.start < new.start:
                left.append(replace(old, start=start, end=min(new.start, old.end)))
            start = max(start, new.end)
        if start < old.end:
            left.append(replace(old, start=start))
    return sorted([*left, *later], key=lambda span: span.start)


def written(spans: Sequence[Span], cables: Sequence[str]) -> str:
    """Return the content of the file."""
    lines = [",".join((*TIMES, *WRENCH, *cables))]
    for span in spans:
        numbers = [repr(float(value)) for value in span.values]
        empty = [""] * (len(cables) if span.kind == "wrench" else len(WRENCH))
        cells = [*numbers, *empty] if span.kind == "wrench" else [*empty, *numbers]
        lines.append(",".join([repr(span.start), repr(span.end), *cells]))
    return "\n".join(lines) + "\n"


def parsed(content: bytes) -> tuple[tuple[str, ...], tuple[Span, ...]]:
    """Return the names of the cables and the spans; raise ContentError if the file is invalid."""
    lines = text_of(content, MAX_BYTES).splitlines()
    first = (*TIMES, *WRENCH)
    names = tuple(lines[0].split(",")) if lines else ()
    if names[: len(first)] != first or len(names) == len(first):
        raise ContentError([(1, 0, f"the columns must be {','.join(first)} and one for each cable, by its name")])
    spans: list[Span] = []
    faults: list[tuple[int, int, str]] = []
    for number, line in enumerate(lines[1:], 2):
        try:
            spans.append(_span(line.split(","), len(names), spans[-1].end if spans else 0.0))
        except ValueError as error:
            faults.append((number, 0, str(error)))
            if len(faults) >= MAX_FAULTS:
                break
    if faults:
        raise ContentError(faults)
    return names[len(first) :], tuple(spans)


def _span(cells: list[str], width: int, before: float) -> Span:
    """Return the span of a line that must not start before `before`, s; raise ValueError if it is invalid."""
    if len(cells) != width:
        raise ValueError(f"expected {width} cells, got {len(cells)}")
    wrench, tension = cells[2:8], cells[8:]
    if any(wrench) == any(tension):
        raise ValueError("expected a wrench, or the tension of each cable, and the other cells empty")
    kind: Kind = "wrench" if any(wrench) else "tension"
    start, end, *values = [_number(cell) for cell in (*cells[:2], *(wrench if any(wrench) else tension))]
    if not before <= start < end:
        raise ValueError(f"t must be at least {before!r} (s), the end of the row before, and less than `until`")
    return Span(kind, start, end, np.array(values))


def _number(cell: str) -> float:
    try:
        value = float(cell.replace("_", "?"))  # only Python accepts 1_000
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"expected a finite number, got {shown(cell)}")
    return value
