"""Data model of an import, in terms of cdpr's own files."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from cdpr.base.errors import FormatError
from cdpr.base.fields import NAME_PATTERN
from cdpr.base.problems import Path
from cdpr.formats.read.unread import Source
from cdpr.scenario.robot_schema import names_of_exports


@dataclass
class Motion:
    """Motion of a source, which becomes a scenario.

    Attributes:
        name: name in the source.
        trajectory: section of the scenario.
        duration: s.
        initial: section of the scenario.
        controller: section of the scenario, if the source has one.
        tables: content of the referenced files, by name.
    """

    name: str
    trajectory: dict[str, Any]
    duration: float
    initial: dict[str, Any]
    controller: dict[str, Any] | None = None
    tables: dict[str, str] = field(default_factory=dict)


@dataclass
class Imported:
    """Robot and motions from another program's files.

    Attributes:
        name: valid robot name.
        source: description such as "CASPR, robot_bodies.xml", for the first line of the output.
        robot: data of the robot file.
        documents: all documents that were read; `report` adds their unread parts to `left_out`.
        comments: origin of values, by path in the robot file.
        motions: motions of the source.
        left_out: items of the source that are not imported, with reasons.
        warnings: assumed or substituted values.
    """

    name: str
    source: str
    robot: dict[str, Any]
    documents: list[Source]
    comments: dict[Path, str] = field(default_factory=dict)
    motions: list[Motion] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def slug(text: str, otherwise: str) -> str:
    """Return a valid name: unchanged if possible, else letters, digits, `_` and `-`, starting with a letter."""
    if re.fullmatch(NAME_PATTERN, text):
        return text
    kept = "".join(char if char.isascii() and (char.isalnum() or char in "_-") else "_" for char in text.strip())
    kept = "_".join(part for part in kept.split("_") if part)[:60]
    if not kept:
        return otherwise
    return kept if kept[0].isalpha() else f"{otherwise}_{kept}"


def unique(names: list[str]) -> list[str]:
    """Return the names with numbers appended to duplicates."""
    taken: set[str] = set()
    counts: dict[str, int] = {}
    found = []
    for name in names:
        new = name
        while new in taken:
            counts[name] = counts.get(name, 1) + 1
            new = f"{name}_{counts[name]}"
        taken.add(new)
        found.append(new)
    return found


def apart(tools: dict[str, list[float]], cables: Iterable[str]) -> dict[str, list[float]]:
    """Return the tools; names that the exports of a robot with these cables use for other parts get a number."""
    reserved = sorted(names_of_exports(cables))
    return dict(zip(unique([*reserved, *tools])[len(reserved) :], tools.values(), strict=True))


def refuse(file: str, line: int, text: str) -> FormatError:
    """Return the error for a position in a file."""
    return FormatError(f"{file}:{line}: {text}")
