"""Typed access to YAML of other programs; errors are reported with file, line and key."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from cdpr.base.errors import FormatError
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.base.problems import Path, dotted, shown
from cdpr.config.document import Document
from cdpr.config.problems import Problems
from cdpr.config.yaml_nodes import parse
from cdpr.formats.read.imported import refuse
from cdpr.formats.read.unread import Unread

DONE = "\0"  # not a possible key: YAML does not allow this character


@dataclass(frozen=True)
class Node:
    """Value in a document, with its position."""

    document: Document
    path: Path = ()
    read: set[Path] = field(default_factory=set)  # paths of values that were read, shared by all nodes of a document

    @property
    def value(self) -> Any:
        """The plain value; None if missing."""
        self.read.add(self.path)
        return self.document.get(self.path)

    @property
    def line(self) -> int:
        """Its line; if missing, that of the enclosing section."""
        return self.document.key_mark(self.path).line

    @property
    def at(self) -> str:
        """Its key and line, for comments."""
        return f"{dotted(self.path)}, line {self.line}"

    def __contains__(self, key: str | int) -> bool:
        return (self / key).value is not None

    def __truediv__(self, key: str | int) -> Node:
        return Node(self.document, (*self.path, key), self.read)

    def number(self) -> float:
        """Return a finite number.

        Raises:
            FormatError: if it is not one.
        """
        if isinstance(self.value, bool) or not isinstance(self.value, int | float) or not _moderate(self.value):
            raise self.wrong(f"expected a number of at most {MAX_MAGNITUDE:g}, got {shown(self.value)}")
        return float(self.value)

    def vector(self, count: int) -> list[float]:
        """Return a list of `count` finite numbers.

        Raises:
            FormatError: if it is not one.
        """
        if not isinstance(self.value, list) or len(self.value) != count:
            raise self.wrong(f"expected {count} numbers, got {shown(self.value)}")
        return [(self / k).number() for k in range(count)]

    def items(self) -> list[Node]:
        """Return the items of a non-empty list.

        Raises:
            FormatError: if it is not one.
        """
        if not isinstance(self.value, list) or not self.value:
            raise self.wrong(f"expected a list with one item or more, got {shown(self.value)}")
        return [self / k for k in range(len(self.value))]

    def done(self) -> None:
        """Mark the value and its content as reported, for example by a separate message."""
        self.read.add((*self.path, DONE))

    def unread(self) -> Iterator[Unread]:
        """Yield keys that were not read, neither themselves nor any value inside."""
        yield from self._unread({path[:k] for path in self.read for k in range(len(path) + 1)})

    def _unread(self, known: set[Path]) -> Iterator[Unread]:
        value = self.document.get(self.path)
        if (*self.path, DONE) in known or not isinstance(value, dict | list):
            return
        for key in value if isinstance(value, dict) else range(len(value)):
            inner = self / key
            if inner.path in known:
                yield from inner._unread(known)
            elif isinstance(value, dict):
                # Without indices of list items, so that items with the same unread key share one line.
                name = ".".join(str(part) for part in inner.path if not isinstance(part, int))
                yield Unread(self.document.source, inner.line, f"key '{name}'")

    def wrong(self, text: str) -> FormatError:
        """Return an error for this position."""
        return refuse(self.document.source, self.line, f"{dotted(self.path)}: {text}" if self.path else text)


def document_of(content: bytes, file: str) -> Node:
    """Return the root node of a document.

    Raises:
        ScenarioError: if it cannot be parsed.
    """
    problems = Problems()
    found = parse(content, file, problems)
    problems.raise_any()
    assert found is not None
    return Node(found)


def _moderate(value: float) -> bool:
    return math.isfinite(value) and abs(value) <= MAX_MAGNITUDE
