"""What the checks of robots and of runs share."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from cdpr.fields import DEFERRED, Section
from cdpr.model import DOF_NAMES
from cdpr.problems import Path
from cdpr.scenario.document import Document
from cdpr.scenario.problems import Problems
from cdpr.scenario.robot_schema import MAX_CABLES, CableSection, DofName

DOF: TypeAdapter[tuple[DofName, ...]] = TypeAdapter(tuple[DofName, ...], config=DEFERRED)

S = TypeVar("S", bound=Section)


class Checks:
    """Looks at the sections that are right by themselves, so that one wrong number does not hide the next."""

    def __init__(self, document: Document, problems: Problems) -> None:
        self.document = document
        self.problems = problems

    def section(self, model: type[S], path: Path) -> S | None:
        """Return the section at `path` if it is right but for unknown keys, else None."""
        return _known(model, self.document.get(path))

    def cables(self, root: Path) -> Iterator[tuple[int, CableSection]]:
        """Yield the cables that are right, and their indices, of the robot at `root`."""
        given = self.document.get((*root, "cables"))
        if isinstance(given, list):
            yield from _read_cables(json.dumps(given))

    def directions(self, path: Path) -> tuple[DofName, ...] | None:
        """Return the directions at `path`, all where there are none; None where they are wrong by themselves."""
        given = self.document.get(path)
        try:
            return DOF.validate_python(DOF_NAMES if given is None else tuple(given))
        except (ValidationError, TypeError):
            return None

    def say(self, path: Path, text: str) -> None:
        """Report a problem of the value at `path`."""
        self.problems.add(self.document.mark(path), path, text)


def _known(model: type[S], data: Any) -> S | None:
    """Return a section if it is right but for unknown keys, else None."""
    if isinstance(data, dict):
        data = {key: value for key, value in data.items() if key in model.model_fields}
    return _read(model, json.dumps(data))


@lru_cache(maxsize=16)  # several checks ask for all cables, and the cases of a study for the same ones
def _read_cables(text: str) -> tuple[tuple[int, CableSection], ...]:
    cables = ((i, _known(CableSection, data)) for i, data in enumerate(json.loads(text)))
    return tuple((i, cable) for i, cable in cables if cable)


@lru_cache(maxsize=4 * MAX_CABLES)  # and of some it is one cable that differs
def _read(model: type[S], text: str) -> S | None:
    try:
        return model.model_validate_json(text)
    except ValidationError:
        return None
