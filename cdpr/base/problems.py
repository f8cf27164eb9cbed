"""Positions in files, problems, and their text form."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

Path = tuple[str | int, ...]

MAX_PROBLEMS = 100  # of a file: keeps the output readable
FEW = 10  # problems of the arguments of one call
SHORTEST = 60  # maximum length of foreign text in messages


def printable(text: str) -> str:
    r"""Escape characters that would break a line or control a terminal: names, files and values are untrusted.

    Letters of all scripts remain; control characters, bidirectional controls and undecodable bytes become escapes such
    as \x1b.
    """
    if text.isprintable():
        return text
    return "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in text)


@dataclass(frozen=True, order=True)
class Mark:
    """Position in a file, counted from 1; line 0 means the whole source, such as one `--set`."""

    source: str
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        return f"{self.source}:{self.line}:{self.column}" if self.line else self.source


@dataclass(frozen=True)
class Problem:
    """One problem. `plugin` is True if only a plugin is missing."""

    mark: Mark
    path: Path
    text: str
    plugin: bool = False

    def as_dict(self) -> dict[str, str | int]:
        """Return the problem for JSON; line and column are 0 for the whole source."""
        source, line, column = self.mark.source, self.mark.line, self.mark.column
        text = printable(self.text)
        return {"source": source, "line": line, "column": column, "key": dotted(self.path), "text": text}

    def __str__(self) -> str:
        key = f"{dotted(self.path)}: " if self.path else ""
        place = f"{self.mark}: " if self.mark.source else ""  # none for values given in Python
        return printable(f"{place}{key}{self.text}")


def dotted(path: Path) -> str:
    """Return a path in the form `robot.cables[0].frame[2]`."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += ("." if text else "") + (part if re.fullmatch(r"[\w:-]{1,60}", part) else shown(part))
    return text


def first_ones(texts: Sequence[str], count: int = FEW) -> list[str]:
    """Return the first texts, and the number of others as the last one."""
    more = len(texts) - count
    return list(texts) if more <= 0 else [*texts[:count], f"and {more} more problem{'s' if more > 1 else ''}"]


def shown(value: object) -> str:
    """Return a value of a file or an argument as short text in one line; numbers of numpy as those of Python."""
    if type(value).__module__ == "numpy" and getattr(value, "shape", None) == ():
        value = value.item()  # type: ignore[attr-defined]
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return "an empty list" if not value else f"a list of {len(value)}"
    return short_repr(value)


def short_repr(value: object) -> str:
    """Return the representation of a Python value as short text in one line, also if its class cannot represent it."""
    try:
        text = repr(value)
    except Exception:  # of a foreign class; Python also refuses to write integers of thousands of digits
        return "an int with too many digits" if isinstance(value, int) else f"a value of type {type(value).__name__}"
    text = re.sub(r"\n\s*", " ", text)  # of arrays
    return text if len(text) <= SHORTEST else text[: SHORTEST - 4] + "..." + (text[-1] if text[-1] in "'\"" else "")
