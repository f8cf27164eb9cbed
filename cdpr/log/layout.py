"""Columns of one row of a run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

from cdpr.base.columns import FIRST, WINCHED, Column
from cdpr.model.robot import Array


@dataclass(frozen=True)
class Layout:
    """Columns of a row for a robot with m cables, ideal or not, and additional columns after `FIRST`."""

    m: int
    ideal: bool = True
    more: tuple[Column, ...] = ()

    @cached_property
    def fields(self) -> dict[str, Column]:
        """Fields of a row, in order, by name."""
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
        """Return the columns of the fields from `first` to `last`, both included."""
        return slice(self.columns[first].start, self.columns[last].stop)

    @property
    def added(self) -> slice:
        """Columns of `more`, which are the last ones."""
        return slice(self.width - sum(column.width or self.m for column in self.more), self.width)


class Rows(Protocol):
    """Rows of a long run, (K, width), read from its log on access."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows, and of columns."""

    def __len__(self) -> int: ...

    def __getitem__(self, key: Any) -> Any: ...

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array: ...
