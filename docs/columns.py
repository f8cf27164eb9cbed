"""Write the tables of docs/columns.md. Run: python docs/columns.py. A test holds the page to it."""

from __future__ import annotations

from pathlib import Path

from marked import rewritten, table

from cdpr.base.column import Column
from cdpr.base.columns import FIRST, known_columns

PAGE = Path(__file__).parent / "columns.md"
TITLES = ("column", "shape", "unit", "description")
TOPIC = "topic and field in the log"


def always_table() -> str:
    """Columns of every run, as the one table of columns has them."""
    found = (column for column, condition in known_columns().values() if not condition)
    return table((*TITLES, TOPIC), ((*_cells(column), _places(column)) for column in found))


def sometimes_table() -> str:
    """Columns of some runs, with their conditions."""
    found = ((column, condition) for column, condition in known_columns().values() if condition)
    titles = (*TITLES, "recorded if", TOPIC)
    return table(titles, ((*_cells(column), condition, _places(column)) for column, condition in found))


def _cells(column: Column) -> tuple[str, ...]:
    return f"`{column.name}`", column.shape, column.unit, column.text


def _places(column: Column) -> str:
    first, *second = (f"`{topic}` {field}" for topic, field in column.topics)
    if second and column not in FIRST:
        return ", ".join([first, *second])
    return f"with ideal cables: {second[0]}; with other cables: {first}" if second else first


def updated(text: str) -> str:
    """The page with its tables written anew."""
    return rewritten(text, {"columns": always_table, "more columns": sometimes_table})


if __name__ == "__main__":
    PAGE.write_text(updated(PAGE.read_text()))
