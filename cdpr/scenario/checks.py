"""Common base of the checks of robots and runs."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, TypeVar

from pydantic import BaseModel, TypeAdapter, ValidationError

from cdpr.base.fields import DEFERRED, Section
from cdpr.base.problems import Path
from cdpr.config.document import Document, same
from cdpr.config.problems import Problems
from cdpr.model import DOF_NAMES
from cdpr.scenario.robot_schema import MAX_CABLES, CableSection, DofName

DOF: TypeAdapter[tuple[DofName, ...]] = TypeAdapter(tuple[DofName, ...], config=DEFERRED)

S = TypeVar("S", bound=Section)
M = TypeVar("M", bound=BaseModel)
T = TypeVar("T")


class Checks:
    """Access to sections that are valid on their own, so that one invalid value does not hide other problems."""

    def __init__(self, document: Document, problems: Problems) -> None:
        self.document = document
        self.problems = problems

    def do(self, *checks: Callable[[], None]) -> None:
        """Run checks, but not if they found no problem before in what they would read again."""
        document = self.document
        for check in checks:
            name = check.__qualname__
            known = document.passed.get(name)
            if known is not None and all(same(document.get(path), value) for path, value in known.items()):
                continue
            reads = document.reads = {}
            check()
            document.reads = None
            if not self.problems.items and not self.problems.unreadable:
                document.passed[name] = reads

    def section(self, model: type[S], path: Path) -> S | None:
        """Return the section at `path` if it is valid apart from unknown keys, else None."""
        return self._once(path, model, _known) if isinstance(self.document.get(path), dict) else None

    def cables(self, root: Path) -> Iterator[tuple[int, CableSection]]:
        """Yield the index and section of each valid cable of the robot at `root`."""
        yield from self._once((*root, "cables"), CableSection, lambda _, given: _read_cables(json.dumps(given)))

    def _once(self, path: Path, kind: type[M], read: Callable[[type[M], Any], T]) -> T:
        """Return what `read` makes of the value at `path`, which other documents may share."""
        given, known = self.document.get(path), self.document.sections
        if (found := known.get((kind, path))) is None or found[0] is not given:
            found = known[kind, path] = given, read(kind, given)
        created: T = found[1]
        return created

    def directions(self, path: Path) -> tuple[DofName, ...] | None:
        """Return the directions at `path`; all if missing, None if invalid."""
        given = self.document.get(path)
        try:
            return DOF.validate_python(DOF_NAMES if given is None else tuple(given))
        except (ValidationError, TypeError):
            return None

    def add_problem(self, path: Path, text: str) -> None:
        """Report a problem of the value at `path`."""
        self.problems.add(self.document.mark(path), path, text)


def remember(section: Section, document: Document, path: Path = ()) -> None:
    """Let checks use the parts of a valid section at `path` instead of validating them again."""
    data, known = document.get(path), document.sections
    if (found := known.get((type(section), path))) is not None and found[0] is data:
        return
    known[type(section), path] = data, section
    for name, info in type(section).model_fields.items():
        key, value = info.alias or name, getattr(section, name)
        given = data.get(key)
        if isinstance(value, Section) and isinstance(given, dict):
            remember(value, document, (*path, key))
        elif isinstance(value, list | tuple) and isinstance(given, list):
            parts = [(i, part) for i, part in enumerate(value) if isinstance(part, Section)]
            for i, part in parts:
                remember(part, document, (*path, key, i))
            if parts and isinstance(value[0], CableSection):
                known[CableSection, (*path, key)] = given, tuple(parts)


def _known(model: type[S], data: Any) -> S | None:
    """Return a section if it is valid apart from unknown keys, else None."""
    if isinstance(data, dict):
        data = {key: value for key, value in data.items() if key in model.model_fields}
    return _read(model, json.dumps(data))


@lru_cache(maxsize=16)  # several checks use all cables, and cases of a study use the same ones
def _read_cables(text: str) -> tuple[tuple[int, CableSection], ...]:
    given = json.loads(text)
    cables = ((i, _known(CableSection, data)) for i, data in enumerate(given if isinstance(given, list) else ()))
    return tuple((i, cable) for i, cable in cables if cable)


@lru_cache(maxsize=4 * MAX_CABLES)  # cases often differ in a single cable
def _read(model: type[S], text: str) -> S | None:
    try:
        return model.model_validate_json(text)
    except ValidationError:
        return None
