"""What was found in a file of another program, as our own files have it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from cdpr.errors import FormatError
from cdpr.fields import NAME_PATTERN
from cdpr.formats.read.unread import Source
from cdpr.problems import Path
from cdpr.scenario.robot_schema import names_of_exports


@dataclass
class Motion:
    """One motion of a source: a scenario is made of it.

    Attributes:
        name: of it, in the source.
        trajectory: the section of a scenario.
        duration: s.
        initial: the section of a scenario.
        controller: the section of a scenario, where the source has one.
        tables: files that it names, with their content.
    """

    name: str
    trajectory: dict[str, Any]
    duration: float
    initial: dict[str, Any]
    controller: dict[str, Any] | None = None
    tables: dict[str, str] = field(default_factory=dict)


@dataclass
class Imported:
    """A robot, and motions of it, from another program's files.

    Attributes:
        name: of the robot, as our files take it.
        source: what it was, such as "CASPR, robot_bodies.xml": the first line of what is written.
        robot: as a robot file has it.
        comments: where numbers came from, by their path in it.
        motions: of the source.
        left_out: what the source says and our files do not, and why.
        warnings: what was filled in or guessed.
        documents: all that were read; `report` adds what was not read of them to `left_out`.
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
    """Return a name as our files take it: as it is, or of letters, digits, `_` and `-`, beginning with a letter."""
    if re.fullmatch(NAME_PATTERN, text):
        return text
    kept = "".join(char if char.isascii() and (char.isalnum() or char in "_-") else "_" for char in text.strip())
    kept = "_".join(part for part in kept.split("_") if part)[:60]
    if not kept:
        return otherwise
    return kept if kept[0].isalpha() else f"{otherwise}_{kept}"


def unique(names: list[str]) -> list[str]:
    """Return names of which those that stood there before get a number."""
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
    """Return tools of which those get a number that are called as a part of a robot with these cables is."""
    reserved = sorted(names_of_exports(cables))
    return dict(zip(unique([*reserved, *tools])[len(reserved) :], tools.values(), strict=True))


def refuse(file: str, line: int, text: str) -> FormatError:
    """Return the error of a place."""
    return FormatError(f"{file}:{line}: {text}")
