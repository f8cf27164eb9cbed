"""One row of a run: which quantity stands in which columns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from cdpr.columns import FIRST, WINCHED, Column


@dataclass(frozen=True)
class Layout:
    """Columns of a row for a robot with m cables, ideal ones or not, and what the run has beyond `FIRST`."""

    m: int
    ideal: bool = True
    more: tuple[Column, ...] = ()

    @cached_property
    def fields(self) -> dict[str, Column]:
        """What stands in a row, in this order, by name."""
        fields = FIRST if self.ideal else FIRST + WINCHED
        return {column.name: column for column in fields + self.more}

    @cached_property
    def columns(self) -> dict[str, slice]:
        """Columns of each field by name."""
        columns: dict[str, slice] = {}
        start = 0
        for name, column in self.fields.items():
            stop = start + (column.width or self.m)
            columns[name] = slice(start, stop)
            start = stop
        return columns

    @property
    def width(self) -> int:
        """Number of columns."""
        return sum(column.width or self.m for column in self.fields.values())

    def span(self, first: str, last: str) -> slice:
        """Columns from the field `first` to the field `last`, both included."""
        return slice(self.columns[first].start, self.columns[last].stop)

    @property
    def added(self) -> slice:
        """Columns of `more`, which are the last ones."""
        return slice(self.width - sum(column.width or self.m for column in self.more), self.width)
