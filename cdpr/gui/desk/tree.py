"""Where each value stands in a YAML text: character offsets of everything that is written there."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

import yaml

from cdpr.problems import Path
from cdpr.scenario.yaml_nodes import PARSER

BREAK = re.compile(r"\r\n|\n|\r")
SPACE_OR_COMMENT = re.compile(r"(?:\s+|(?:(?<=\s)|^)#[^\r\n]*)*", re.MULTILINE)


@dataclass(eq=False)
class Node:
    """A value as it is written.

    Attributes:
        kind: what it is; an alias stands for what carries its name.
        outer: where it begins, with the anchor that it may carry.
        start: where the value itself begins.
        end: where it ends; that of a block is the end of its last value.
        flow: whether it is written in brackets.
        name: of its anchor, or of the one that the alias means.
        keys: of a mapping, one a value.
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
    words: list[str] = field(default_factory=list)  # the keys as texts

    def index(self, part: str | int) -> int | None:
        """Return the number of the item that a part of a path names; of a key that is given twice, the last."""
        if self.kind == "mapping":
            found = [i for i, word in enumerate(self.words) if word == part]
            return found[-1] if found else None
        return part if self.kind == "list" and isinstance(part, int) and part < len(self.items) else None

    def chain(self, path: Path) -> list[Node]:
        """Return this node and those that the parts of `path` lead to, as far as they go."""
        nodes = [self]
        for part in path:
            i = nodes[-1].index(part)
            if i is None:
                break
            nodes.append(nodes[-1].items[i])
        return nodes

    def walk(self, path: Path = ()) -> Iterator[tuple[Path, Node]]:
        """Yield this node and all in it, each with its path."""
        yield path, self
        for i, item in enumerate(self.items):
            yield from item.walk((*path, self.words[i] if self.kind == "mapping" else i))


def tree(text: str) -> Node:
    """Return the value that a text holds, which our reader has read."""
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
        if style in ("|", ">"):  # what follows its last line is not its own
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
    """Return where white space and comments end that begin at `at`."""
    found = SPACE_OR_COMMENT.match(text, at)
    return found.end() if found else at


def line_start(text: str, at: int) -> int:
    """Return where the line of `at` begins."""
    return max(text.rfind("\n", 0, at), text.rfind("\r", 0, at)) + 1


def line_end(text: str, at: int) -> int:
    """Return where the line of `at` ends, before its break."""
    found = BREAK.search(text, at)
    return found.start() if found else len(text)


def after_break(text: str, at: int) -> int:
    """Return where the line after that of `at` begins; the end of the text if there is none."""
    found = BREAK.search(text, at)
    return found.end() if found else len(text)


def line_break(text: str) -> str:
    """Return what ends the lines of a text."""
    found = BREAK.search(text)
    return found.group() if found else "\n"
