"""Parsed file: plain data with the position of each key and value."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field
from typing import Any

from cdpr.base.problems import Mark, Path


@dataclass
class Document:
    """Plain dictionaries, lists and scalars with their positions.

    Copies share dictionaries and lists until they change them: these are changed by the methods only.

    A robot file is inserted into the scenario's document and keeps its own positions. Overrides have the position of
    the change.
    """

    data: dict[str, Any]
    source: str
    folder: str = ""  # base of relative file names
    keys: dict[Path, Mark] = field(default_factory=dict)
    values: dict[Path, Mark] = field(default_factory=dict)
    dropped: list[str] = field(default_factory=list)  # options removed because another plugin was selected
    notes: list[str] = field(default_factory=list)  # remarks on the options of replaced plugins
    filled: list[Path] = field(default_factory=list)  # derived values, recomputed after each change
    waiting: list[tuple[Path, Any, Mark]] = field(default_factory=list)  # changes that cannot be applied yet
    files: Mapping[str, str] = field(default_factory=dict)  # texts that replace referenced files, by path
    passed: dict[str, dict[Path, Any]] = field(default_factory=dict)  # what checks read that found no problem, by name
    sections: dict[Any, tuple[Any, Any]] = field(default_factory=dict)  # data and section, by kind and path
    reads: dict[Path, Any] | None = None  # values returned by `get`, if they are recorded

    def copy(self) -> Document:
        """Return a copy that can be modified."""
        marks = dict(self.keys), dict(self.values)
        lists = list(self.dropped), list(self.notes)
        twin = Document(dict(self.data), self.source, self.folder, *marks, *lists)
        twin.filled, twin.waiting, twin.files = list(self.filled), list(self.waiting), self.files
        twin.passed, twin.sections = self.passed, self.sections
        return twin

    def get(self, path: Path) -> Any:
        """Return the value at `path`, or None."""
        node: Any = self.data
        for part in path:
            if isinstance(node, dict):
                node = node.get(part)
            elif isinstance(node, list) and isinstance(part, int) and part < len(node):
                node = node[part]
            else:
                node = None
                break
        if self.reads is not None:
            self.reads[path] = node
        return node

    def mark(self, path: Path) -> Mark:
        """Return the position of the value at `path`; if it is missing, that of the enclosing section's key."""
        if path in self.values:
            return self.values[path]
        for end in range(len(path) - 1, 0, -1):
            if path[:end] in self.keys:
                return self.keys[path[:end]]
            if path[:end] in self.values:
                return self.values[path[:end]]
        return self.values.get((), Mark(self.source, 1, 1))

    def key_mark(self, path: Path) -> Mark:
        """Return the position of the key at `path`."""
        return self.keys.get(path) or self.mark(path)

    def put(self, path: Path, value: Any, mark: Mark) -> None:
        """Set the value at `path`, whose parent exists.

        Enclosing lists get the position of the change, because it may be the cause of problems of the whole list.
        """
        self._forget(path, self.get(path))
        self.own(path[:-1])[path[-1]] = value
        self.keys[path] = self.values[path] = mark
        while isinstance(path[-1], int):
            path = path[:-1]
            self.values[path] = mark

    def drop(self, path: Path) -> None:
        """Remove the key at `path`, with what was filled in there."""
        self.filled[:] = [each for each in self.filled if each[: len(path)] != path]
        self._forget(path, self.get(path))
        del self.own(path[:-1])[path[-1]]

    def rename(self, old: str, new: str) -> None:
        """Rename a key of the file; its place, value and positions stay."""
        self.data = rename_key(self.data, old, new)
        for marks in (self.keys, self.values):
            for path in [path for path in marks if path[:1] == (old,)]:
                marks[(new, *path[1:])] = marks.pop(path)

    def own(self, path: Path) -> Any:
        """Return the dictionary or list at `path`, which this document shares with no other from now on."""
        node: Any = self.data
        for part in path:
            node[part] = node = copy(node[part])
        return node

    def graft(self, path: Path, other: Document) -> None:
        """Insert the data of another file at `path`, with their positions in that file."""
        key = self.key_mark(path)
        self.put(path, other.data, key)
        self.keys.update({path + part: mark for part, mark in other.keys.items()})
        self.values.update({path + part: mark for part, mark in other.values.items()})
        self.keys[path] = other.mark(())  # keys missing in the other file are reported there

    def transplant(self, path: Path, other: Document, source: Path) -> None:
        """Insert the value at `source` of another document at `path`, with its positions."""
        self.put(path, other.get(source), other.key_mark(source))
        count = len(source)
        self.keys.update({path + at[count:]: mark for at, mark in other.keys.items() if at[:count] == source})
        self.values.update({path + at[count:]: mark for at, mark in other.values.items() if at[:count] == source})

    def _forget(self, path: Path, node: Any) -> None:
        """Remove the positions of `node` at `path`, and of everything in it."""
        self.keys.pop(path, None)
        self.values.pop(path, None)
        items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
        for part, item in items:
            self._forget((*path, part), item)


def rename_key(data: dict[str, Any], old: str, new: str) -> dict[str, Any]:
    """Return plain data with another name of a key."""
    return {new if key == old else key: value for key, value in data.items()}


def same(one: Any, other: Any) -> bool:
    """Return True if plain data are equal and of equal types: 1, 1.0 and true differ."""
    return one is other or (one == other and repr(one) == repr(other))


def copied(node: Any) -> Any:
    """Return a copy of plain data; 5 times faster than copy.deepcopy, which tracks shared objects."""
    if isinstance(node, dict):
        return {key: copied(value) for key, value in node.items()}
    return [copied(value) for value in node] if isinstance(node, list) else node
