"""Columns of one row of a run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

from cdpr.base.column import Column
from cdpr.base.columns import FIRST, GROUPS
from cdpr.model.robot import Array, ideal


def implied_columns(cable_model: str) -> tuple[Column, ...]:
    """Return the columns of a cable model that the header of a log does not list."""
    return () if ideal(cable_model) else GROUPS["winched"].columns


@dataclass(frozen=True)
class Layout:
    """Columns of a row for a robot with m cables: `FIRST`, then additional columns."""

    m: int
    more: tuple[Column, ...] = ()

    @cached_property
    def fields(self) -> dict[str, Column]:
        """Fields of a row, in order, by name."""
        return {column.name: column for column in FIRST + self.more}

    def has(self, group: str) -> bool:
        """Return True if the row has the columns of a group of `cdpr.base.columns.GROUPS`."""
        return GROUPS[group].within(self.more)

    @property
    def ideal(self) -> bool:
        """True if the tensions of all cables equal their commands, and have no column."""
        return not self.has("winched")

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
        """Columns of `more`, which are the last ones, without the tensions of the cables, which come first."""
        last = GROUPS["winched"].columns[-1] if self.has("winched") else FIRST[-1]
        return slice(self.columns[last.name].stop, self.width)


class Rows(Protocol):
    """Rows of a long run, (K, width), read from its log on access."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows, and of columns."""

    def __len__(self) -> int: ...

    def __getitem__(self, key: Any) -> Any: ...

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array: ...
