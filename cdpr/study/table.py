"""The table of a study: one row a case, the same to the bit whoever computed it."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from cdpr.errors import PluginError
from cdpr.jobs.cases import Outcome
from cdpr.study.figures import figures
from cdpr.study.plan import Study

NOT_RUN = "not run"

Cell = bool | int | float | str | None


@dataclass(frozen=True)
class Table:
    """Columns, and rows of as many cells; what a case does not have is None."""

    axes: tuple[str, ...]
    figures: tuple[str, ...]
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def records(self) -> list[dict[str, Cell]]:
        """The rows by column."""
        return [dict(zip(self.columns, row, strict=True)) for row in self.rows]


def make_table(study: Study, rows: Mapping[str, Outcome]) -> Table:
    """Return the table of a study; `rows` holds how its cases ended, by id."""
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
    """Wall-clock times, which differ from run to run."""
    names = ("setup_s", "loop_s", "case_s")
    found = {case.id: rows[case.id].timings for case in study.cases if case.id in rows}
    cells = [(key, *(seconds.get(name) for name in names)) for key, seconds in found.items()]
    return Table((), names, ("case", *names), tuple(cells))


def to_csv(table: Table) -> bytes:
    """CSV with shortest exact decimals; an empty cell is None."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table.columns)
    writer.writerows([_text(cell) for cell in row] for row in table.rows)
    return text.getvalue().encode()


def to_parquet(table: Table) -> bytes:
    """Parquet; a column of numbers stays one. Raises PluginError without pyarrow."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise PluginError("Parquet needs pyarrow, which is not installed: pip install 'cdpr[data]'") from error
    columns = [pyarrow.array(_uniform(column)) for column in zip(*table.rows, strict=True)]
    buffer = io.BytesIO()
    parquet.write_table(pyarrow.Table.from_arrays(columns, names=list(table.columns)), buffer)
    return buffer.getvalue()


def _uniform(cells: Sequence[Cell]) -> Iterable[Cell]:
    """Make cells of one type: numbers where all are, else texts."""
    kinds = {type(cell) for cell in cells if cell is not None}
    if len(kinds) <= 1:
        return cells
    if kinds == {int, float}:
        return [None if cell is None else float(cell) for cell in cells]
    return [None if cell is None else _text(cell) for cell in cells]


def _text(cell: Cell) -> str:
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return "true" if cell else "false"
    return repr(cell) if isinstance(cell, float) else str(cell)
