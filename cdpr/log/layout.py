"""One row of a run: which quantity stands in which columns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

# (name, width); 0 stands for the number of cables. state, desired and cable are contiguous, so that the loop can hand
# out one view of each.
FIELDS: tuple[tuple[str, int], ...] = (
    ("time", 1),
    ("position", 3),
    ("orientation", 4),
    ("velocity", 3),
    ("angular_velocity", 3),
    ("desired_position", 3),
    ("desired_orientation", 4),
    ("desired_velocity", 3),
    ("desired_angular_velocity", 3),
    ("desired_acceleration", 3),
    ("desired_angular_acceleration", 3),
    ("wrench", 6),
    ("tension", 0),
    ("length", 0),
    ("rate", 0),
    ("status", 1),
    ("residual", 1),
    ("margin", 1),
    ("at_limit", 1),
    ("external", 6),
    ("kinetic", 1),
    ("potential", 1),
    ("cable_work", 1),
    ("external_work", 1),
)
# Besides, where cables are not ideal: there a tension is not what was commanded.
WINCHED: tuple[tuple[str, int], ...] = (("cable_tension", 0),)


@dataclass(frozen=True)
class Layout:
    """Columns of a row for a robot with m cables, ideal ones or not."""

    m: int
    ideal: bool = True

    @property
    def fields(self) -> tuple[tuple[str, int], ...]:
        """Names and widths in the order of the columns; 0 stands for m."""
        return FIELDS if self.ideal else FIELDS + WINCHED

    @cached_property
    def columns(self) -> dict[str, slice]:
        """Columns of each field by name."""
        columns: dict[str, slice] = {}
        start = 0
        for name, width in self.fields:
            stop = start + (width or self.m)
            columns[name] = slice(start, stop)
            start = stop
        return columns

    @property
    def width(self) -> int:
        """Number of columns."""
        return sum(width or self.m for _, width in self.fields)

    def span(self, first: str, last: str) -> slice:
        """Columns from the field `first` to the field `last`, both included."""
        return slice(self.columns[first].start, self.columns[last].stop)
