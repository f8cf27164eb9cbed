"""Strict YAML: from text to a `Document`, refusing what a scenario never needs before it costs anything.

PyYAML only scans and parses; its events are composed here, one by one, so that the limits hold while reading
and no constructor ever runs. An alias is what was written at its anchor, composed anew and counted like anything else
(so no bombs). No tags (no code), no merge keys, no duplicate keys.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from typing import Any

import yaml

from cdpr.problems import Mark, Path, dotted, shown
from cdpr.scenario.document import Document
from cdpr.scenario.files import MAX_BYTES
from cdpr.scenario.problems import Problems
from cdpr.scenario.scalars import WORDS, resolve

MAX_DEPTH = 32
TOO_DEEP = "exceeded maximum nesting depth"  # libyaml's own words
MAX_NODES = 20_000

# Printable text and the line ends of an editor. U+0085, U+2028 and U+2029 would end a line for YAML alone.
FORBIDDEN = re.compile("[^\t\n\r\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]")
TAB = re.compile(r"^[^#\n]*?\t", re.MULTILINE)
XML = re.compile(r"\s*<[?!A-Za-z]")  # not the << of a merge
SURROGATE = re.compile("[\ud800-\udfff]")

# libyaml, where PyYAML was built with it: 10 times faster.
PARSER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


# What YAML notices only where it ends, often a line later, and what is then wrong where it begins.
BEGUN = {
    "simple key": "; a colon is missing after this word",
    "quoted scalar": "; the quote that begins here is not closed",
    "flow mapping": "; the bracket { that opens here is not closed, or a comma is missing in it",
    "flow sequence": "; the bracket [ that opens here is not closed, or a comma is missing in it",
}


def _place(error: yaml.MarkedYAMLError) -> Any:
    """Return the mark of what is wrong: where it begins, if it is noticed in another line."""
    begin, noticed = error.context_mark, error.problem_mark
    if begin and noticed and begin.line != noticed.line and any(what in (error.context or "") for what in BEGUN):
        return begin
    return noticed or begin


class _RefusedError(Exception):
    def __init__(self, mark: Mark, text: str, path: Path = ()) -> None:
        super().__init__(text)
        self.mark = mark
        self.text = text
        self.path = path


def parse(content: bytes | str, source: str, problems: Problems, *, parser: Any = PARSER) -> Document | None:
    """Return the document, or None if it cannot be read at all; what is wrong goes to `problems`.

    `source` names the file in messages, and its folder is where relative names start.
    """
    composer = _Composer(source, problems)
    try:
        if XML.match(content if isinstance(content, str) else content.decode("latin-1")):
            raise _RefusedError(
                Mark(source, 1, 1), "XML; YAML is expected: 'cdpr import' reads robots of other programs"
            )
        data = composer.compose(content, parser)
        if not isinstance(data, dict):
            found = "a list" if isinstance(data, list) else shown(data)
            raise _RefusedError(composer.values[()], f"a mapping (key: value) is expected at the top, got {found}")
    except _RefusedError as refused:
        problems.add(refused.mark, refused.path, refused.text)
        return None
    return Document(data, source, os.path.dirname(source), composer.keys, composer.values)


def parse_value(text: str) -> Any:
    """Return the value that `text` stands for by the same rules; ValueError says what is wrong."""
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
    """Builds plain data out of events and notes where each node stands."""

    def __init__(self, source: str, problems: Problems) -> None:
        self.source = source
        self.problems = problems
        self.keys: dict[Path, Mark] = {}
        self.values: dict[Path, Mark] = {}
        self.nodes = 0
        self.anchors: dict[str, list[Any]] = {}  # events of what carries each name
        self.open: list[tuple[str, list[Any]]] = []  # of those, that are still being read

    def compose(self, content: bytes | str, parser: Any) -> Any:
        text = self._text(content)
        try:
            return self._document(yaml.parse(text, Loader=parser))
        except yaml.MarkedYAMLError as error:
            place = _place(error)
            mark = Mark(self.source, place.line + 1, place.column + 1) if place else Mark(self.source, 1, 1)
            if TOO_DEEP in (error.problem or ""):  # newer libyaml looks ahead farther than that
                raise _RefusedError(mark, f"nested more than {MAX_DEPTH} deep") from None
            parts = [part for part in (error.context, error.problem) if part]
            hint = next((hint for begun, hint in BEGUN.items() if begun in (error.context or "")), "")
            raise _RefusedError(mark, f"not valid YAML: {', '.join(parts)}{hint}") from None
        except yaml.YAMLError as error:
            raise _RefusedError(Mark(self.source, 1, 1), f"not valid YAML: {' '.join(str(error).split())}") from None

    def _text(self, content: bytes | str) -> str:
        """Decode and check the characters, which PyYAML's two parsers judge differently."""
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
        if found := FORBIDDEN.search(text):
            code = f"U+{ord(found.group()):04X}"
            raise _RefusedError(self._place(text[: found.start()]), f"control character {code}; remove it")
        if found := TAB.search(text):
            raise _RefusedError(self._place(text[: found.end() - 1]), "tab character; indent and separate with spaces")
        return text

    def _place(self, before: str) -> Mark:
        """Return the mark of what follows the text `before`."""
        line = before.count("\n") + 1
        return Mark(self.source, line, len(before) - (before.rfind("\n") + 1) + 1)

    def _mark(self, event: Any) -> Mark:
        return Mark(self.source, event.start_mark.line + 1, event.start_mark.column + 1)

    def _document(self, events: Iterator[Any]) -> Any:
        next(events)  # the start of the stream
        start = next(events)
        if isinstance(start, yaml.StreamEndEvent):
            raise _RefusedError(Mark(self.source, 1, 1), "the file is empty")
        if start.version or start.tags:
            raise _RefusedError(self._mark(start), "directives (%YAML, %TAG) are not supported; remove the line")
        inner = self._recorded(events)
        value = self._value(next(inner), (), 1, inner)
        next(events)  # the end of the document
        after = next(events)
        if not isinstance(after, yaml.StreamEndEvent):
            raise _RefusedError(self._mark(after), "a second document begins here (---); one file holds one document")
        return value

    def _recorded(self, events: Iterator[Any]) -> Iterator[Any]:
        """Hand on events, keeping them for all anchors that are open."""
        for event in events:
            for _, kept in self.open:
                kept.append(event)
            yield event

    def _value(self, event: Any, path: Path, depth: int, events: Iterator[Any]) -> Any:
        if isinstance(event, yaml.AliasEvent):
            return self._alias(event, path, depth)
        name = event.anchor
        if name is None or (name in self.anchors and self.anchors[name][0] is event):  # none, or composed again
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
        """Compose again what stands at the anchor; problems in it are told where it stands."""
        mark, name = self._mark(event), event.anchor
        if any(name == other for other, _ in self.open):
            raise _RefusedError(mark, f"the alias *{name} stands within its own anchor", path)
        if name not in self.anchors:
            raise _RefusedError(mark, f"no anchor &{name} stands before this alias", path)
        replayed = iter(self.anchors[name])
        return self._node(next(replayed), path, depth, replayed)

    def _node(self, event: Any, path: Path, depth: int, events: Iterator[Any]) -> Any:
        mark = self._plain(event, path)
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
            mark = self._plain(event, path)
            key = self._key(event, mark, path)
            place = (*path, key)
            if key in data:
                self.problems.add(mark, place, f"given twice; the first is in line {lines[key]}, remove one")
            lines.setdefault(key, mark.line)
            self.keys[place] = mark
            data[key] = self._value(next(events), place, depth + 1, events)
        return data

    def _plain(self, event: Any, path: Path) -> Mark:
        """Count a node and refuse what is no plain data."""
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
        if SURROGATE.search(key):
            raise _RefusedError(mark, "a key has an escape that is no character", path)
        return key

    def _scalar(self, event: Any, mark: Mark, path: Path) -> Any:
        if SURROGATE.search(event.value):
            raise _RefusedError(mark, "the text has an escape that is no character", path)
        if not event.implicit[0]:  # quoted or a block: a text whatever it looks like
            return event.value
        try:
            return resolve(event.value)
        except ValueError as error:
            self.problems.add(mark, path, str(error))
            self.problems.unreadable.add(path)  # said once: no "a number expected" after this
            return event.value
