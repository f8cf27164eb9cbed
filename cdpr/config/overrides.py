"""Overrides of file values, such as `--set key=value`.

They are written into the document before validation, so that they pass the same checks as the file.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from cdpr.base.errors import CdprError
from cdpr.base.fields import Section
from cdpr.base.lazy import late
from cdpr.base.problems import Mark, Path, shown
from cdpr.config.document import Document
from cdpr.config.problems import Problems
from cdpr.config.scalars import MAX_DIGITS
from cdpr.config.yaml_nodes import MAX_DEPTH, has_surrogate, parse_value
from cdpr.model import Robot
from cdpr.native.arrays import MASKED, masked

KEY = r"[^.\[\]=\s]+(?:\[\d{1,9}\]|\.[^.\[\]=\s]+)*"
PART = r"\[(\d+)\]|([^.\[\]]+)"


@dataclass(frozen=True)
class Change:
    """Value to set. Path components written as [0] are integers."""

    path: Path
    value: Any
    mark: Mark


Overrides = Mapping[str, Any] | Sequence[str] | Sequence[Change] | Sequence[str | Change]


def read_overrides(overrides: Overrides, problems: Problems) -> list[Change]:
    """Return the changes of `overrides`: a mapping of keys to values, texts `key=value` in YAML, or changes."""
    if isinstance(overrides, Mapping):
        return _changes(
            [(key, value, Mark("overrides"), plain_value) for key, value in overrides.items()],
            problems,
        )
    try:
        given = [overrides] if isinstance(overrides, str) else list(overrides)
    except TypeError:
        given = None
    wrong = [overrides] if given is None else [item for item in given if not isinstance(item, (str, Change))]
    if given is None or wrong:
        raise CdprError(f"overrides: expected {{key: value}} or texts KEY=VALUE, got {shown(wrong[0])}")
    changes = [item for item in given if isinstance(item, Change)]
    texts = [item for item in given if isinstance(item, str)]
    rows = [(text.partition("=")[0], text, Mark(f"--set {brief(text)}"), _parsed) for text in texts]
    return [*changes, *_changes(rows, problems)]


def path_of(key: str) -> Path:
    """Return the path of a key such as robot.cables[0].frame[2]."""
    return tuple(int(index) if index else word for index, word in re.findall(PART, key))


def marked_changes(items: Iterable[tuple[str, Any, Mark]], problems: Problems) -> list[Change]:
    """Return changes from keys, plain values and positions."""
    return _changes([(key, value, mark, plain_value) for key, value, mark in items], problems)


def _changes(rows: Sequence[tuple[str, Any, Mark, Callable[[Any], Any]]], problems: Problems) -> list[Change]:
    changes: list[Change] = []
    for key, value, mark, convert in rows:
        if not isinstance(key, str) or not re.fullmatch(KEY, key.strip()):
            text = "expected a key such as simulation.duration or robot.cables[0].frame[2]"
            problems.add(mark, (), text if str(mark).startswith("--") else f"{text}, got {shown(key)}")
            continue
        path: Path = path_of(key.strip())
        try:
            changes.append(Change(path, convert(value), mark))
        except ValueError as error:
            problems.add(mark, path, str(error))
    return changes


def apply(document: Document, change: Change, problems: Problems) -> None:
    """Apply a change to the document and create missing parent sections."""
    node: Any = document.data
    path: Path = ()
    for i, part in enumerate(change.path):
        key = _key_in(node, part, path, change.mark, problems)
        if key is None:
            return
        path = (*path, key)
        if i == len(change.path) - 1:
            document.put(path, change.value, change.mark)
        elif isinstance(node, dict) and node.get(str(key)) is None:
            if str(item := change.path[i + 1]).isdecimal():
                problems.add(change.mark, path, f"there is no item [{item}]: no list is given here")
                return
            document.put(path, {}, change.mark)
        node = document.get(path)


def _key_in(node: Any, part: str | int, path: Path, mark: Mark, problems: Problems) -> str | int | None:
    """Return `part` as key or index of this node; report a problem and return None if it is neither."""
    if isinstance(node, dict) and isinstance(part, str):
        return part
    if isinstance(node, list) and str(part).isdecimal():
        if int(part) < len(node):
            return int(part)
        problems.add(mark, path, f"there is no item [{part}]: {_extent(node)}")
    else:
        what = f"a list{_index_of(part, node)}" if isinstance(node, list) else shown(node)
        problems.add(mark, path, f"{shown(part)} does not exist in it: it is {what}")
    return None


def _index_of(name: str | int, items: list[Any]) -> str:
    """Return a hint with the index of the item that has this name or type."""
    for key in ("name", "type"):
        for i, item in enumerate(items):
            if isinstance(item, dict) and item.get(key) == name:
                return f"; use the index of the item, [{i}]"
    return ""


def _extent(items: list[Any]) -> str:
    return f"the list has the items [0] to [{len(items) - 1}]" if items else "the list is empty"


def _parsed(text: str) -> Any:
    key, equals, value = text.partition("=")
    if not equals:
        raise ValueError(f"expected key=value, such as {key.strip()}=1.5")
    return parse_value(value.strip())


class NotPlainError(ValueError):
    """Python value that is no plain data; `path` is its place."""

    def __init__(self, path: Path, text: str) -> None:
        super().__init__(text)
        self.path = path


def plain_value(value: Any, path: Path = ()) -> Any:
    """Convert a Python value at `path` into plain data; arrays become lists, robots and sections mappings.

    Raises:
        NotPlainError: if it is not convertible.
    """
    if len(path) > MAX_DEPTH:
        raise NotPlainError(path[:2], f"nested more than {MAX_DEPTH} deep")
    if isinstance(value, Robot):  # checked with the data of which it is a part
        return late("robot_data")(value)
    if isinstance(value, Section):
        return value.to_dict()
    if isinstance(value, BaseModel):  # options of a plugin
        return value.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
    if hasattr(value, "tolist"):  # NumPy array or scalar
        if masked(value):
            raise NotPlainError(path, MASKED)
        value = value.tolist()
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, str) and has_surrogate(value):
        raise NotPlainError(path, f"expected a text of valid characters, got {shown(value)}")
    if isinstance(value, int) and abs(value) >= 10**MAX_DIGITS:
        raise NotPlainError(path, "the whole number is too large")
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Mapping):
        return {plain_key(key, path): plain_value(item, (*path, key)) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain_value(item, (*path, i)) for i, item in enumerate(value)]
    raise NotPlainError(path, f"expected a number, a text, a list or a mapping, got {type(value).__name__}")


def plain_key(key: object, path: Path = ()) -> str:
    """Return a key of the mapping at `path`; raise NotPlainError if it is no text."""
    if not isinstance(key, str):
        raise NotPlainError(path, f"expected texts as keys, got {shown(key)}")
    return str(key)


def brief(value: object) -> str:
    """Return a value as text in one short line."""
    try:
        text = " ".join(str(value).split())
    except Exception:  # of a foreign class; Python also refuses to print integers with many digits
        text = "..."
    return text if len(text) <= 80 else text[:77] + "..."
