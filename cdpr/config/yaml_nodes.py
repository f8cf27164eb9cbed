"""Strict YAML parser: from text to a `Document`, with limits enforced while reading.

PyYAML only scans and parses. Its events are composed here one by one, so that limits apply early and no constructor
runs. Aliases are expanded and counted like other values, which prevents alias bombs. Tags, merge keys and duplicate
keys are rejected.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from typing import Any

import yaml

from cdpr.base.files import MAX_BYTES
from cdpr.base.problems import Mark, Path, dotted, shown
from cdpr.config.document import Document
from cdpr.config.problems import Problems
from cdpr.config.scalars import WORDS, resolve

MAX_DEPTH = 32
TOO_DEEP = "exceeded maximum nesting depth"  # message of libyaml
MAX_NODES = 20_000

# Allows printable text and usual line ends. U+0085, U+2028 and U+2029 are line ends only in YAML.
# These patterns take milliseconds to compile, so they are compiled only for texts with such characters.
FORBIDDEN = "[^\t\n\r\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"
TAB = r"(?m)^[^#\n]*?\t"
SURROGATE = "[\ud800-\udfff]"
XML = re.compile(r"\s*<[?!A-Za-z]")  # not the << of a merge

# libyaml if available: 10 times faster.
PARSER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


# Errors that YAML detects only at the end, often on a later line, with a hint on their start.
BEGUN = {
    "simple key": "; a colon is missing after this word",
    "quoted scalar": "; the quote that begins here is not closed",
    "flow mapping": "; the bracket { that opens here is not closed, or a comma is missing in it",
    "flow sequence": "; the bracket [ that opens here is not closed, or a comma is missing in it",
}


def _place(error: yaml.MarkedYAMLError) -> Any:
    """Return the position of an error: its start, if it was detected on another line."""
    begin, noticed = error.context_mark, error.problem_mark
    if begin and noticed and begin.line != noticed.line and any(what in (error.context or "") for what in BEGUN):
        return begin
    return noticed or begin


def _is_plain(text: str) -> bool:
    """Return True if a text has only printable ASCII characters and line feeds."""
    return text.isascii() and text.replace("\n", "").isprintable()


def has_surrogate(text: str) -> bool:
    """Return True if a text has half of a character, from an escape."""
    return not text.isascii() and re.search(SURROGATE, text) is not None


class _RefusedError(Exception):
    def __init__(self, mark: Mark, text: str, path: Path = ()) -> None:
        super().__init__(text)
        self.mark = mark
        self.text = text
        self.path = path


def parse(content: bytes | str, source: str, problems: Problems, *, parser: Any = PARSER) -> Document | None:
    """Return the document, or None if it cannot be read; errors are added to `problems`.

    Args:
        content: text or UTF-8 bytes.
        source: file name for messages; its folder is the base of relative file names.
        problems: receives the errors.
        parser: PyYAML loader class.
    """
    composer = _Composer(source, problems)
    try:
        if XML.match(content if isinstance(content, str) else content.decode("latin-1")):
            raise _RefusedError(
                Mark(source, 1, 1), "expected YAML, got XML; 'cdpr import' reads robots of other programs"
            )
        data = composer.compose(content, parser)
        if not isinstance(data, dict):
            found = "a list" if isinstance(data, list) else shown(data)
            raise _RefusedError(composer.values[()], f"expected a mapping (key: value) at the top, got {found}")
    except _RefusedError as refused:
        problems.add(refused.mark, refused.path, refused.text)
        return None
    return Document(data, source, os.path.dirname(source), composer.keys, composer.values)


def parse_value(text: str) -> Any:
    """Return the value of `text` by the same rules; raise ValueError if it is invalid."""
    problems = Problems()
    try:
        value = _Composer("", problems).compose(text or "null", PARSER)
    except _RefusedError as refused:
        raise ValueError(refused.text) from None
    if problems.items:
        first = problems.items[0]
        raise ValueError(f"{dotted(first.path)}: {first.text}" if first.path else first.text)
    return value


class _Composer:
    """Composer of plain data from events, with the positions of all nodes."""

    def __init__(self, source: str, problems: Problems) -> None:
        self.source = source
        self.problems = problems
        self.keys: dict[Path, Mark] = {}
        self.values: dict[Path, Mark] = {}
        self.nodes = 0
        self.anchors: dict[str, list[Any]] = {}  # events of each anchored value
        self.open: list[tuple[str, list[Any]]] = []  # anchored values that are still being read

    def compose(self, content: bytes | str, parser: Any) -> Any:
        text = self._text(content)
        try:
            return self._document(yaml.parse(text, Loader=parser))
        except yaml.MarkedYAMLError as error:
            place = _place(error)
            mark = Mark(self.source, place.line + 1, place.column + 1) if place else Mark(self.source, 1, 1)
            if TOO_DEEP in (error.problem or ""):  # newer versions of libyaml look farther ahead
                raise _RefusedError(mark, f"nested more than {MAX_DEPTH} deep") from None
            parts = [part for part in (error.context, error.problem) if part]
            hint = next((hint for begun, hint in BEGUN.items() if begun in (error.context or "")), "")
            raise _RefusedError(mark, f"not valid YAML: {', '.join(parts)}{hint}") from None
        except yaml.YAMLError as error:
            raise _RefusedError(Mark(self.source, 1, 1), f"not valid YAML: {' '.join(str(error).split())}") from None

    def _text(self, content: bytes | str) -> str:
        """Decode the text and check its characters, which PyYAML's two parsers treat differently."""
        size = len(content) if isinstance(content, bytes) else len(content.encode("utf-8", "surrogatepass"))
        if size > MAX_BYTES:
            raise _RefusedError(Mark(self.source, 1, 1), f"larger than {MAX_BYTES // 1024} KiB; no scenario needs that")
        if isinstance(content, bytes):
            try:
                text = content.decode("utf-8")
            except UnicodeDecodeError as error:
                before = content[: error.start].decode("utf-8")
                byte = content[error.start]
                raise _RefusedError(
                    self._place(before), f"not UTF-8 text (byte 0x{byte:02x}); save it as UTF-8"
                ) from None
        else:
            text = content
        if text.startswith("\ufeff"):
            raise _RefusedError(Mark(self.source, 1, 1), "begins with a byte order mark; save it as UTF-8 without one")
        if not _is_plain(text) and (found := re.search(FORBIDDEN, text)):
            code = f"U+{ord(found.group()):04X}"
            raise _RefusedError(self._place(text[: found.start()]), f"control character {code}; remove it")
        if "\t" in text and (found := re.search(TAB, text)):
            raise _RefusedError(self._place(text[: found.end() - 1]), "tab character; indent and separate with spaces")
        return text

    def _place(self, before: str) -> Mark:
        """Return the position after the text `before`."""
        line = before.count("\n") + 1
        return Mark(self.source, line, len(before) - (before.rfind("\n") + 1) + 1)

    def _mark(self, event: Any) -> Mark:
        return Mark(self.source, event.start_mark.line + 1, event.start_mark.column + 1)

    def _document(self, events: Iterator[Any]) -> Any:
        next(events)  # start of the stream
        start = next(events)
        if isinstance(start, yaml.StreamEndEvent):
            raise _RefusedError(Mark(self.source, 1, 1), "the file is empty")
        if start.version or start.tags:
            raise _RefusedError(self._mark(start), "directives (%YAML, %TAG) are not supported; remove the line")
        inner = self._recorded(events)
        value = self._value(next(inner), (), 1, inner)
        next(events)  # end of the document
        after = next(events)
        if not isinstance(after, yaml.StreamEndEvent):
            raise _RefusedError(self._mark(after), "a second document begins here (---); one file holds one document")
        return value

    def _recorded(self, events: Iterator[Any]) -> Iterator[Any]:
        """Yield the events, and record them for all open anchors."""
        for event in events:
            for _, kept in self.open:
                kept.append(event)
            yield event

    def _value(self, event: Any, path: Path, depth: int, events: Iterator[Any]) -> Any:
        if isinstance(event, yaml.AliasEvent):
            return self._alias(event, path, depth)
        name = event.anchor
        if name is None or (name in self.anchors and self.anchors[name][0] is event):  # no anchor, or replayed
            return self._node(event, path, depth, events)
        if name in self.anchors or any(name == other for other, _ in self.open):
            raise _RefusedError(self._mark(event), f"the anchor &{name} is given twice; rename one", path)
        kept = [event]
        self.open.append((name, kept))
        value = self._node(event, path, depth, events)
        self.open.pop()
        self.anchors[name] = kept
        return value

    def _alias(self, event: Any, path: Path, depth: int) -> Any:
        """Compose the anchored value again; problems have the position of the anchor."""
        mark, name = self._mark(event), event.anchor
        if any(name == other for other, _ in self.open):
            raise _RefusedError(mark, f"the alias *{name} is inside its own anchor", path)
        if name not in self.anchors:
            raise _RefusedError(mark, f"no anchor &{name} precedes this alias", path)
        replayed = iter(self.anchors[name])
        return self._node(next(replayed), path, depth, replayed)

    def _node(self, event: Any, path: Path, depth: int, events: Iterator[Any]) -> Any:
        mark = self._count_node(event, path)
        self.values[path] = mark
        if isinstance(event, yaml.ScalarEvent):
            return self._scalar(event, mark, path)
        if depth > MAX_DEPTH:
            raise _RefusedError(mark, f"nested more than {MAX_DEPTH} deep")
        if isinstance(event, yaml.MappingStartEvent):
            return self._mapping(path, depth, events)
        items: list[Any] = []
        while not isinstance(item := next(events), yaml.SequenceEndEvent):
            items.append(self._value(item, (*path, len(items)), depth + 1, events))
        return items

    def _mapping(self, path: Path, depth: int, events: Iterator[Any]) -> dict[str, Any]:
        data: dict[str, Any] = {}
        lines: dict[str, int] = {}
        while not isinstance(event := next(events), yaml.MappingEndEvent):
            if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
                raise _RefusedError(self._mark(event), "a key takes no anchor and no alias (&name, *name)", path)
            mark = self._count_node(event, path)
            key = self._key(event, mark, path)
            place = (*path, key)
            if key in data:
                self.problems.add(mark, place, f"given twice; the first is in line {lines[key]}, remove one")
            lines.setdefault(key, mark.line)
            self.keys[place] = mark
            data[key] = self._value(next(events), place, depth + 1, events)
        return data

    def _count_node(self, event: Any, path: Path) -> Mark:
        """Count a node and reject tags."""
        mark = self._mark(event)
        self.nodes += 1
        if self.nodes > MAX_NODES:
            raise _RefusedError(mark, f"more than {MAX_NODES} values; no scenario needs that")
        if event.tag is not None:
            raise _RefusedError(mark, f"tags are not supported: {shown(event.tag)}; write the plain value", path)
        return mark

    def _key(self, event: Any, mark: Mark, path: Path) -> str:
        if not isinstance(event, yaml.ScalarEvent):
            raise _RefusedError(mark, "a key must be a word, not a list or a mapping", path)
        key = str(event.value)
        plain = event.implicit[0]
        if plain and key == "<<":
            raise _RefusedError(mark, "merge keys (<<) are not supported; write the keys out", path)
        if plain and key in WORDS and WORDS[key] is None:
            raise _RefusedError(mark, "a key is missing before ':'", path)
        if has_surrogate(key):
            raise _RefusedError(mark, "a key has an escape that is not a character", path)
        return key

    def _scalar(self, event: Any, mark: Mark, path: Path) -> Any:
        if has_surrogate(event.value):
            raise _RefusedError(mark, "the text has an escape that is not a character", path)
        if not event.implicit[0]:  # quoted or block scalar: always text
            return event.value
        try:
            return resolve(event.value)
        except ValueError as error:
            self.problems.add(mark, path, str(error))
            self.problems.unreadable.add(path)  # suppresses a further "expected a number"
            return event.value
