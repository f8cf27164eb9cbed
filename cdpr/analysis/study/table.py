"""Table of a study: one row per case, bit-identical whatever machine computed it."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.study.figures import figures
from cdpr.analysis.study.plan import Study
from cdpr.base.errors import PluginError

NOT_RUN = "not run"

INT64 = 2**63 - 1  # larger whole numbers become floats

Cell = bool | int | float | str | None


@dataclass(frozen=True)
class Table:
    """Columns and rows of equal length; missing values are None."""

    axes: tuple[str, ...]
    figures: tuple[str, ...]
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def records(self) -> list[dict[str, Cell]]:
        """Return the rows as dictionaries by column."""
        return [dict(zip(self.columns, row, strict=True)) for row in self.rows]


def make_table(study: Study, rows: Mapping[str, Outcome]) -> Table:
    """Return the table of a study; `rows` are the outcomes of its cases by id."""
    blocks = any(case.block is not None for case in study.cases)
    axes = tuple(dict.fromkeys(axis for case in study.cases for axis in case.labels))
    found = [figures(rows[case.id].summary) if case.id in rows else {} for case in study.cases]
    names = tuple(dict.fromkeys(name for one in found for name in one))
    table = []
    for case, values in zip(study.cases, found, strict=True):
        row = rows.get(case.id) or Outcome(case.id, NOT_RUN, "", "")
        labels = [case.labels.get(axis) for axis in axes]
        block = [case.block] if blocks else []
        table.append((case.id, *block, *labels, row.status, row.reason, *(values.get(name) for name in names)))
    columns = ("case", *(["block"] if blocks else []), *axes, "status", "message", *names)
    return Table(axes, names, columns, tuple(table))


def times(study: Study, rows: Mapping[str, Outcome]) -> Table:
    """Return the wall-clock times, which differ from run to run."""
    names = ("setup_s", "loop_s", "case_s")
    found = {case.id: rows[case.id].timings for case in study.cases if case.id in rows}
    cells = [(key, *(seconds.get(name) for name in names)) for key, seconds in found.items()]
    return Table((), names, ("case", *names), tuple(cells))


def to_csv(table: Table) -> bytes:
    """Return the table as CSV with shortest exact decimals; None is an empty cell."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table.columns)
    writer.writerows([_text(cell) for cell in row] for row in table.rows)
    return text.getvalue().encode()


def to_parquet(table: Table) -> bytes:
    """Return the table as Parquet with typed columns.

    Raises:
        PluginError: if pyarrow is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise PluginError("Parquet needs pyarrow, which is not installed: pip install 'cdpr[data]'") from error
    columns = [_arrow(pyarrow, column) for column in zip(*table.rows, strict=True)]
    buffer = io.BytesIO()
    parquet.write_table(pyarrow.Table.from_arrays(columns, names=list(table.columns)), buffer)
    return buffer.getvalue()


def _arrow(pyarrow: Any, cells: Sequence[Cell]) -> Any:
    """Return cells as an Arrow array of one type: numbers if all cells are numeric, else text.

    The buffers are built directly: for lists, pyarrow would import pandas, which takes as long as thirty cases.
    """
    known = np.array([cell is not None for cell in cells])
    kinds = {type(cell) for cell in cells if cell is not None}
    if not kinds:
        return pyarrow.nulls(len(cells))
    first = np.packbits(known, bitorder="little")
    if kinds == {bool}:
        kind, rest = pyarrow.bool_(), [np.packbits([cell is True for cell in cells], bitorder="little")]
    elif kinds == {int} and all(abs(cell or 0) <= INT64 for cell in cells):  # type: ignore[arg-type]
        kind, rest = pyarrow.int64(), [np.array([cell or 0 for cell in cells], dtype="<i8")]
    elif kinds <= {int, float}:
        kind, rest = pyarrow.float64(), [np.array([0.0 if cell is None else cell for cell in cells], dtype="<f8")]
    else:
        texts = [_text(cell).encode() for cell in cells]
        ends = np.cumsum([0, *map(len, texts)]).astype("<i4")
        kind, rest = pyarrow.string(), [ends, np.frombuffer(b"".join(texts), np.uint8)]
    buffers = [pyarrow.py_buffer(part.tobytes()) for part in (first, *rest)]
    return pyarrow.Array.from_buffers(kind, len(cells), buffers)


def _text(cell: Cell) -> str:
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return "true" if cell else "false"
    return repr(cell) if isinstance(cell, float) else str(cell)
