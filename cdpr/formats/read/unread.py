"""Report of the parts of a source document that an importer did not read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple, Protocol


class Unread(NamedTuple):
    """Part of a document that no importer code has read.

    Attributes:
        file: its file.
        line: its first line.
        what: its description; equal descriptions are reported together.
    """

    file: str
    line: int
    what: str


class Source(Protocol):
    """Document that records which of its parts are read."""

    def unread(self) -> Iterator[Unread]:
        """Yield the parts that were not read, in document order."""
        ...


def report(sources: Iterable[Source]) -> list[str]:
    """Return one line per kind of unread part, with the position of the first and the number of others."""
    first: dict[tuple[str, str], int] = {}
    more: dict[tuple[str, str], int] = {}
    for source in sources:
        for part in source.unread():
            key = part.file, part.what
            if key in first:
                more[key] = more.get(key, 0) + 1
            else:
                first[key] = part.line
    lines = []
    for (file, what), line in first.items():
        count = more.get((file, what), 0)
        also = f" (here and in {count} other {'place' if count == 1 else 'places'})" if count else ""
        lines.append(f"{file}:{line}: {what}: not imported{also}")
    return lines
