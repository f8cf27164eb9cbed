"""Positions of all values in a YAML text, as character offsets."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

import yaml

from cdpr.base.problems import Path
from cdpr.config.yaml_nodes import PARSER

BREAK = re.compile(r"\r\n|\n|\r")
SPACE_OR_COMMENT = re.compile(r"(?:\s+|(?:(?<=\s)|^)#[^\r\n]*)*", re.MULTILINE)


@dataclass(eq=False)
class Node:
    """Value as written in the text.

    Attributes:
        kind: kind of the value; an alias refers to the anchor of the same name.
        outer: start, including an anchor.
        start: start of the value itself.
        end: end; for a block, the end of its last value.
        flow: True if written in brackets.
        name: name of the anchor, or of the anchor that an alias refers to.
        keys: keys of a mapping, one per value.
        items: values of a mapping or list.
    """

    kind: Literal["scalar", "mapping", "list", "alias"]
    outer: int
    start: int
    end: int
    flow: bool = False
    style: str = ""
    name: str | None = None
    keys: list[Node] = field(default_factory=list)
    items: list[Node] = field(default_factory=list)
    words: list[str] = field(default_factory=list)  # keys as text

    def index(self, part: str | int) -> int | None:
        """Return the index of the item for a path component; for a duplicate key, the last one."""
        if self.kind == "mapping":
            found = [i for i, word in enumerate(self.words) if word == part]
            return found[-1] if found else None
        return part if self.kind == "list" and isinstance(part, int) and part < len(self.items) else None

    def chain(self, path: Path) -> list[Node]:
        """Return this node and the nodes along `path`, as far as they exist."""
        nodes = [self]
        for part in path:
            i = nodes[-1].index(part)
            if i is None:
                break
            nodes.append(nodes[-1].items[i])
        return nodes

    def walk(self, path: Path = ()) -> Iterator[tuple[Path, Node]]:
        """Yield this node and all nested nodes, each with its path."""
        yield path, self
        for i, item in enumerate(self.items):
            yield from item.walk((*path, self.words[i] if self.kind == "mapping" else i))


def tree(text: str) -> Node:
    """Return the root value of a text that has been parsed successfully before."""
    events = yaml.parse(text, Loader=PARSER)
    next(events)
    next(events)
    return _node(next(events), events, text)


def _node(event: Any, events: Iterator[Any], text: str) -> Node:
    begin, end = event.start_mark.index, event.end_mark.index
    if isinstance(event, yaml.AliasEvent):
        return Node("alias", begin, begin, end, name=event.anchor)
    start = begin if event.anchor is None else min(blank_end(text, begin + 1 + len(event.anchor)), max(begin, end))
    if isinstance(event, yaml.ScalarEvent):
        style = event.style or ""
        if style in ("|", ">"):  # exclude what follows the last line
            end = start + len(text[start:end].rstrip())
        return Node("scalar", begin, start, end, style=style, name=event.anchor)
    if event.anchor is not None:
        start = blank_end(text, begin + 1 + len(event.anchor))
    kind: Literal["mapping", "list"] = "mapping" if isinstance(event, yaml.MappingStartEvent) else "list"
    node = Node(kind, begin, start, end, flow=bool(event.flow_style), name=event.anchor)
    while not isinstance(item := next(events), (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
        if kind == "mapping":
            node.words.append(item.value)
            node.keys.append(_node(item, events, text))
            item = next(events)
        node.items.append(_node(item, events, text))
    closing: Any = item
    node.end = closing.end_mark.index if node.flow else node.items[-1].end
    return node


def blank_end(text: str, at: int) -> int:
    """Return the end of white space and comments that start at `at`."""
    found = SPACE_OR_COMMENT.match(text, at)
    return found.end() if found else at


def line_start(text: str, at: int) -> int:
    """Return the start of the line that contains `at`."""
    return max(text.rfind("\n", 0, at), text.rfind("\r", 0, at)) + 1


def line_end(text: str, at: int) -> int:
    """Return the end of the line that contains `at`, before its line break."""
    found = BREAK.search(text, at)
    return found.start() if found else len(text)


def after_break(text: str, at: int) -> int:
    """Return the start of the line after that of `at`; the end of the text if there is none."""
    found = BREAK.search(text, at)
    return found.end() if found else len(text)


def line_break(text: str) -> str:
    """Return the line break of a text."""
    found = BREAK.search(text)
    return found.group() if found else "\n"
