"""What `cdpr` writes to a terminal: text, and nothing that a terminal would obey.

Names of files, robots, plugins and variables come from strangers and reach the user by many ways; all of them end here.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO

from cdpr.errors import printable


class Printable:
    """A text stream that escapes all but printable letters, tabs, ends of lines and a `\\r` that ends what is written.

    The last is how the line of progress is written anew; within a text it would write over what stands before it.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write and return the number of letters that were given."""
        self._stream.write(text if text.isprintable() else _escaped(text))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write all."""
        for line in lines:
            self.write(line)


def _escaped(text: str) -> str:
    end = "\r" if text.endswith("\r") else ""
    lines = text.removesuffix(end).split("\n")
    return "\n".join("\t".join(map(printable, line.split("\t"))) for line in lines) + end


@contextmanager
def printable_streams() -> Iterator[None]:
    """Write to stdout and stderr through `Printable` until the end of the block or function."""
    before = {name: getattr(sys, name) for name in ("stdout", "stderr")}
    ours = {name: Printable(stream) for name, stream in before.items() if stream is not None}
    for name, stream in ours.items():
        setattr(sys, name, stream)
    try:
        yield
    finally:
        for name, stream in ours.items():
            if getattr(sys, name) is stream:  # not replaced meanwhile, as where its reader has gone
                setattr(sys, name, before[name])
