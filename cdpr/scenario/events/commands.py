"""External wrenches and commands of cables that replace the output of controller or solver, and their file format.

The file is a text table: `t` and `until` (s), `fx` to `mz` (N, N m), and a column per cable, by name. A row contains a
wrench or a command per cable from the sample at `t` up to, but excluding, that at `until`; other cells are empty.
Commands are tensions (N), unless a third column, `quantity`, contains `length` (m), `rate` (m/s), or `command`: the
quantity that the winch of each cable takes. Numbers are written with full precision.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from cdpr.base.fields import MAX_UNWOUND
from cdpr.base.files import MAX_FAULTS, ContentError, text_of
from cdpr.base.problems import shown
from cdpr.model.robot import Array

MAX_BYTES = 512 * 1024 * 1024  # over an hour of tensions that change a thousand times a second
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")
TIMES = ("t", "until")
QUANTITY = "quantity"

Kind = Literal["wrench", "tension", "length", "rate", "command"]
OF_WINCHES: tuple[Kind, ...] = ("length", "rate", "command")  # in the units of the winches


@dataclass(frozen=True, eq=False)
class Span:
    """Wrench (6,) or command of each cable (m,) during a time interval, s."""

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
    quantities = any(span.kind in OF_WINCHES for span in spans)
    head = (*TIMES, QUANTITY) if quantities else TIMES
    lines = [",".join((*head, *WRENCH, *cables))]
    for span in spans:
        numbers = [repr(float(value)) for value in span.values]
        empty = [""] * (len(cables) if span.kind == "wrench" else len(WRENCH))
        cells = [*numbers, *empty] if span.kind == "wrench" else [*empty, *numbers]
        quantity = [span.kind if span.kind in OF_WINCHES else ""] if quantities else []
        lines.append(",".join([repr(span.start), repr(span.end), *quantity, *cells]))
    return "\n".join(lines) + "\n"


def parsed(content: bytes) -> tuple[tuple[str, ...], tuple[Span, ...]]:
    """Return the names of the cables and the spans; raise ContentError if the file is invalid."""
    lines = text_of(content, MAX_BYTES).splitlines()
    names = tuple(lines[0].split(",")) if lines else ()
    first = (*TIMES, QUANTITY, *WRENCH) if names[2:3] == (QUANTITY,) else (*TIMES, *WRENCH)
    if names[: len(first)] != first or len(names) == len(first):
        raise ContentError([(1, 0, f"the columns must be {','.join(first)} and one for each cable, by its name")])
    spans: list[Span] = []
    faults: list[tuple[int, int, str]] = []
    for number, line in enumerate(lines[1:], 2):
        try:
            cells = line.split(",")
            if len(cells) != len(names):
                raise ValueError(f"expected {len(names)} cells, got {len(cells)}")
            quantity = cells.pop(2) if QUANTITY in first else ""
            spans.append(_span(cells, quantity, spans[-1].end if spans else 0.0))
        except ValueError as error:
            faults.append((number, 0, str(error)))
            if len(faults) >= MAX_FAULTS:
                break
    if faults:
        raise ContentError(faults)
    return names[len(first) :], tuple(spans)


def _span(cells: list[str], quantity: str, before: float) -> Span:
    """Return the span of a line that must not start before `before`, s; raise ValueError if it is invalid."""
    wrench, tension = cells[2:8], cells[8:]
    if any(wrench) == any(tension):
        raise ValueError("expected a wrench, or the tension of each cable, and the other cells empty")
    kind = _kind(quantity, any(wrench))
    start, end, *values = [_number(cell) for cell in (*cells[:2], *(wrench if any(wrench) else tension))]
    if not before <= start < end:
        raise ValueError(f"t must be at least {before!r} (s), the end of the row before, and less than `until`")
    beyond = next((value for value in values if kind == "length" and not 0.0 < value <= MAX_UNWOUND), None)
    if beyond is not None:
        raise ValueError(f"expected lengths of more than 0 and at most {MAX_UNWOUND:g} m, got {beyond:g}")
    return Span(kind, start, end, np.array(values))


def _kind(quantity: str, of_wrench: bool) -> Kind:
    """Return the kind of a command; raise ValueError if the cell `quantity` is invalid."""
    if not quantity:
        return "wrench" if of_wrench else "tension"
    found = next((kind for kind in OF_WINCHES if kind == quantity), None)
    if found is None or of_wrench:
        allowed = "nothing, for a wrench" if of_wrench else f"{', '.join(OF_WINCHES)}, or nothing, for tensions"
        raise ValueError(f"{QUANTITY}: expected {allowed}, got {shown(quantity)}")
    return found


def _number(cell: str) -> float:
    try:
        value = float(cell.replace("_", "?"))  # only Python accepts 1_000
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"expected a finite number, got {shown(cell)}")
    return value
