"""Write the table of docs/columns.md. Run: python docs/columns.py. A test holds the page to it."""

from __future__ import annotations

from pathlib import Path

from marked import rewritten, table

from cdpr.base.columns import Column, known_columns

PAGE = Path(__file__).parent / "columns.md"


def columns_table() -> str:
    """Every column, as the one table of columns has it."""
    titles = ("column", "shape", "unit", "frame", "topic and field", "recorded if", "description")
    return table(titles, (_cells(column, condition) for column, condition in known_columns().values()))


def _cells(column: Column, condition: str) -> tuple[str, ...]:
    places = "; ".join(f"`{topic}` {field}" for topic, field in column.topics)
    return f"`{column.name}`", column.shape, column.unit, column.frame, places, condition, column.text


def updated(text: str) -> str:
    """The page with its table written anew."""
    return rewritten(text, {"columns": columns_table})


if __name__ == "__main__":
    PAGE.write_text(updated(PAGE.read_text()))
